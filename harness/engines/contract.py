"""The contract of an engine: write, execute, read.

To add an engine, make a folder beside ``lammps`` and ``reference`` with a subclass of
:class:`Engine` and name it in ``registry.py``:

1. ``traits`` declares its rules: tails, effective mass, integrator, digits, lineage;
2. ``identify`` says who it is (version, packages, executable), or raises
   EngineMissingError with what to install;
3. ``drops``, ``inclines`` and ``towers`` run cases. Split them into *write* (case to
   input, a pure function), *execute* (run it under limits of time and memory:
   ``process.py``) and *read* (output to result, a pure function tested on recorded
   output). Convert units at this edge and nowhere else.
4. a function named in ``registry.INPUTS`` returns the files that ``dem-harness inputs``
   writes, each of which runs with the engine alone.

``routes.py`` says where the grain of an incline starts and ends, ``path.py`` judges
a path that the engine wrote, ``tower_record.py`` makes the result of a tower from the
motion of its particles, ``timing.py`` plans the steps of a tower.

What goes wrong in one run must not touch the others: return the EngineError in
the place of its result. Raise RequestError for a case that the engine cannot state
(``traits.refuses`` tells of contacts). Formulas are not shared with theory or chain solvers.
The engine qualifies by its drops before it is believed (``verbs.qualification``).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Self

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.engines.traits import Traits
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

Route = Literal["passage", "steady"]


class Engine(ABC):
    """A DEM code that can run the cases of this harness. Use it as a context manager."""

    name: str
    traits: Traits

    states_towers = True
    """Whether it can run towers at all."""

    @abstractmethod
    def identify(self) -> Provenance:
        """Return version, packages and executable; raise EngineMissingError with the remedy."""

    @abstractmethod
    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run a grain against one fixed sphere, case by case, and return the paths in order.

        A sample at the start and after every ``case.every`` steps, ``case.steps`` in all.
        """

    @abstractmethod
    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Run the cases, in parallel where that helps, and return their results in order.

        With ``every``, the grain's path is sampled every so many steps.
        """

    @abstractmethod
    def towers(
        self,
        cases: Sequence[Tower],
        duration: float,
        *,
        steps_per_contact: float | None = None,
        samples: int | None = None,
        profiles: bool = False,
    ) -> list[TowerRun | EngineError]:
        """Run towers for ``duration`` [t0] and return their results in order.

        Steps count in pi sqrt(m/k), samples default to about 1000 per t0.
        Raise RequestError for a case that the engine cannot state.
        """

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return all that decides a result besides the case, JSON-ready, or None.

        Contents of programs and libraries, not only their version: results are
        kept under it. None, the default, has nothing kept.
        """
        return None

    def measured(self, cases: Sequence[Incline], route: Route) -> list[InclineRun]:
        """Run the cases and raise the first EngineError, for callers that need them all."""
        runs: list[InclineRun] = []
        for run in self.inclines(cases, route):
            if isinstance(run, EngineError):
                raise run
            runs.append(run)
        return runs

    def logs(self) -> dict[str, str]:
        """Return the log of one finished run for each script, by the script's name."""
        return {}

    def close(self) -> None:  # noqa: B027 - an engine without processes has nothing to close
        """End the engine's processes."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
