"""The base of a case: what is simulated, measured and expected of it, and its checks as data.

A case is one module or folder. It names no engine. To add one, subclass :class:`Case`:

1. ``parameters`` (a frozen :class:`harness.model.base.Parameters`), ``quantities``, ``presets``;
2. ``job`` returns the job of a run: a scene, or a template with values;
3. ``measure`` returns the quantities of an output, ``exact`` those with a closed form;
4. ``checks`` lists what ``verify`` judges; the runner (:mod:`harness.cases.checks`) makes exactly
   one row of each, whatever happens;
5. ``sections`` shows the results in a report.

A quantity that takes several runs for one value, such as a critical angle, declares the parameters
that its search ``varies``, and is measured by ``search``.
"""

from __future__ import annotations

import functools
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar

from harness.cases.bench import Bench
from harness.engines.base import Engine, Job, Output
from harness.errors import HarnessError, RequestError, Unsupported
from harness.model.base import Parameters
from harness.results.rows import LEVELS, Failure, Kind, Level, Tolerance

if TYPE_CHECKING:
    from harness.model.scene import Scene
    from harness.report.content import Discs, Section

__all__ = ["LEVELS", "Case", "Check", "Level", "Quantity", "Value"]

P = TypeVar("P", bound=Parameters)
EXPECTED = {
    "job": "a Job",
    "measure": "numbers by the names of quantities",
    "exact": "numbers by the names of quantities",
}  # results of calls of another package


class Value(NamedTuple):
    """A measured value with its uncertainty, in the unit of its quantity.

    ``failure`` is the class of a failure where the measurement shows more than a number, as the
    first divergence of a series does.
    """

    value: float
    uncertainty: float = 0.0
    note: str = ""
    failure: Failure = Failure.NONE

    @classmethod
    def of(cls, measured: Value | float) -> Value:
        """Return what a measurement returns, a value or a plain number, as a value."""
        return measured if isinstance(measured, Value) else cls(float(measured))


@dataclass(frozen=True)
class Quantity(Generic[P]):
    """A quantity of a case.

    ``unit`` is "1" for a pure number. ``scale`` is the size that the quantity has in the case
    [unit], by the parameters of a run or one for all: tolerances on round-off are a part of it.
    ``varies`` are the parameters that a search for it varies, none for what one run measures.
    """

    name: str
    unit: str
    meaning: str
    scale: float | Callable[[P], float] = 1.0
    varies: tuple[str, ...] = ()

    def size(self, parameters: P) -> float:
        """Return the scale [unit] for the parameters of a run."""
        return self.scale(parameters) if callable(self.scale) else self.scale


@dataclass(frozen=True, kw_only=True)
class Check:
    """One row of a verification: what is measured, what is expected, how close, and why so close.

    ``check`` names the route where a quantity of a setup is compared with two things. ``jobs`` are
    run in one batch with those of all other checks before anything is measured; an engine that
    refuses one of them is not tested. ``level`` is the shortest that runs the check, and its value
    must not depend on the level: another effort is another ``setup``. The difference of a finding
    is not judged; its tolerance, if any, is how far it may move from the accepted run. What is
    recorded has no expected value.
    """

    setup: str
    quantity: str
    unit: str
    measure: Callable[[Bench], Value | float]
    expected: float | Callable[[Bench], float] = float("nan")
    tolerance: Tolerance | Callable[[Bench], Tolerance] = field(default_factory=Tolerance)
    kind: Kind = Kind.CROSS_CODE
    level: Level = "quick"
    check: str = ""
    jobs: Sequence[Job] = ()
    note: str = ""


class Case(ABC, Generic[P]):
    """One system: parameters to a job, an output to quantities, and what is expected of them."""

    name: str
    group: str = ""
    summary: str  # one line, for lists
    parameters: ClassVar[type[Parameters]]
    quantities: Sequence[Quantity[Any]]
    search_options: type[Parameters] = Parameters  # of `search`, next to the parameters
    presets: Mapping[str, P]  # by name; the first is the default of `run`
    sources: Mapping[str, str] = MappingProxyType({})  # preset: where it was published
    solvers: Sequence[str] = ()  # names of solvers of this package that `solve` runs

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        guard_calls(cls)

    @property
    def default(self) -> P:
        """Return the parameters of a run for which none are given."""
        return next(iter(self.presets.values()))

    # ---- one run

    @abstractmethod
    def job(self, parameters: P) -> Job:
        """Return the job of one run. Raise RequestError for parameters that cannot be run."""

    @abstractmethod
    def measure(self, parameters: P, output: Output) -> Mapping[str, float]:
        """Return the quantities of a run. Raise EngineOutputError for an output that is cut."""

    def exact(self, parameters: P) -> Mapping[str, float]:
        """Return the quantities with a closed form."""
        return {}

    def reference(self, parameters: P, bench: Bench) -> Mapping[str, float]:
        """Return the quantities at equal steps, under the conventions of the bench's engine.

        Raise Unsupported where the reference cannot run the case.
        """
        scene = self.scene(parameters)
        if scene is None:
            raise Unsupported("the reference does not run this case")
        return self.measure(parameters, bench.reference_output(scene))

    def scene(self, parameters: P) -> Scene | None:
        """Return the scene of a run, None where it is no scene of spheres and walls."""
        return self.job(parameters).scene

    def solve(self, parameters: P, solver: str) -> Mapping[str, float]:
        """Return the quantities by one of :attr:`solvers`."""
        raise RequestError(f"--engine {solver!r}: case {self.name!r} has no such solver")

    def profile(self, parameters: P, output: Output) -> Mapping[str, Sequence[float]]:
        """Return columns of one length over a run, empty for a case without a profile."""
        return {}

    def discs(self, parameters: P, output: Output) -> Discs:
        """Return what a film of a run shows. Raise RequestError for a case without a film."""
        raise RequestError(f"--film: case {self.name!r} has no film")

    def film_job(self, parameters: P, frames: int) -> Job:
        """Return the job of a run whose samples make a film of so many frames."""
        return self.job(parameters)

    def cost(self, parameters: P) -> float:
        """Return the steps of a run times its moving bodies, for an estimate of its time."""
        scene = self.scene(parameters)
        return 0.0 if scene is None else float(scene.steps * len(scene.bodies))

    # ---- several runs

    def search(
        self, names: Sequence[str], parameters: P, bench: Bench, **options: Any
    ) -> Mapping[str, Value]:
        """Return quantities that take several runs, by name; ``options`` as `search_options`."""
        raise RequestError(f"--quantity {','.join(names)}: case {self.name!r} has no such search")

    # ---- verification and report

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, of all levels."""
        return ()

    def checks_up_to(self, engine: Engine, level: Level) -> Iterable[Check]:
        """Return the checks of an engine of a level and shorter ones; more do no harm.

        For a case in which a check takes time to make.
        """
        return self.checks(engine)

    def own_checks(self) -> Iterable[Check]:
        """Return the checks of this package's solvers, whose bench has no engine."""
        return ()

    def comparisons(self, engines: Sequence[Engine]) -> Iterable[tuple[Engine, Check]]:
        """Return the checks of engines against one another, whose benches are ``bench.others``."""
        return ()

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return the sections of a report, from benches that have run their checks, by engine.

        The bench of this package's solvers has the name ``harness``; ``rows`` of a bench are those
        of its checks, by case.
        """
        return ()

    def quantity(self, name: str) -> Quantity[Any]:
        """Return a quantity by name. Raise RequestError for another name."""
        for quantity in self.quantities:
            if quantity.name == name:
                return quantity
        names = ", ".join(quantity.name for quantity in self.quantities)
        raise RequestError(f"--quantity {name!r}: case {self.name!r} measures {names}")


# ---- cases of another package: an error of a call becomes one line


class CaseError(RequestError):
    """A call of a case that raises, or returns another type than the contract has."""


def guard_calls(kind: type[Any]) -> None:
    """Guard the calls of a class of another package that are in :data:`EXPECTED`."""
    if kind.__module__.partition(".")[0] == "harness":
        return
    for name in EXPECTED.keys() & vars(kind).keys():
        setattr(kind, name, _guarded(name, vars(kind)[name]))


def case_error(case: Any, call: str, result: str, expected: str) -> CaseError:
    """Return the error of a call in one line: package, case, call, result and expected one."""
    package = type(case).__module__.partition(".")[0]
    where = "" if package == "harness" else f"package {package!r}, "
    return CaseError(f"{where}case {case.name!r}: {call} {result}, must return {expected}")


def _guarded(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(call)
    def guarded(self: Any, *arguments: Any, **options: Any) -> Any:
        try:
            value = call(self, *arguments, **options)
        except HarnessError:
            raise
        except Exception as error:  # another package may raise anything
            place = traceback.extract_tb(error.__traceback__)[-1]
            text = " ".join(f"{type(error).__name__}: {error}".split())[:160]
            result = f"raised {text} ({Path(place.filename).name}, line {place.lineno})"
            raise case_error(self, name, result, EXPECTED[name]) from error
        if not _is_expected(name, value):
            raise case_error(self, name, f"returned a {type(value).__name__}", EXPECTED[name])
        return value

    return guarded


def _is_expected(name: str, value: Any) -> bool:
    if name == "job":
        return isinstance(value, Job)
    return isinstance(value, Mapping) and all(isinstance(each, Real) for each in value.values())
