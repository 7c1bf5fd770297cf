"""A study: a question that one case answers with many runs, from the runs to a verdict in words.

A workflow for any case does the runs and returns the rows.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from harness.engines.contract import Engine
from harness.errors import RequestError
from harness.observables.reference import ReferencePoints
from harness.parameters.base import Parameters
from harness.report.sections import Section

if TYPE_CHECKING:
    from harness.cases.contract import LevelName

Row = Mapping[str, Any]
"""One run, flat as in a sweep: parameters and quantities with their units, status and reason."""


@dataclass(frozen=True)
class Arm:
    """Runs that belong together, each with parameters of its own; ``ranks`` of MPI in each."""

    name: str
    parameters: tuple[Parameters, ...]
    ranks: int = 1


@dataclass(frozen=True)
class Conclusion:
    """Result of a study: its rows, the verdict in sentences, the sections of its report.

    ``test`` is how the verdict follows from the numbers, stated before they are known.
    """

    rows: tuple[Row, ...]
    verdict: tuple[str, ...]
    test: str
    sections: tuple[Section, ...]


@dataclass(frozen=True)
class StudyCost:
    """What a level costs: what was ``measured``, a row for each number of cores, the model."""

    measured: tuple[Row, ...]
    rows: tuple[Row, ...]
    model: str


EngineOf = Callable[[int], AbstractContextManager[Engine]]
"""Opens an engine whose runs take so many ranks of MPI."""


class CaseStudy(ABC):
    """What is run at each level, and what follows from it."""

    title: str
    question: str
    columns: Sequence[str]
    """Of the rows of its conclusion, those that a terminal shows."""

    @abstractmethod
    def arms(self, level: LevelName) -> Sequence[Arm]:
        """Return the runs of a level."""

    def cost(self, level: LevelName, engine_of: EngineOf, runs: Sequence[Row] = ()) -> StudyCost:
        """Return what a level costs on 1, 16 and 256 cores.

        By the wall times of ``runs`` of this study, else measured on an engine in short runs.
        """
        raise RequestError(f"--cost: the study {self.title!r} does not tell what it costs")

    @abstractmethod
    def conclude(
        self, arms: Mapping[str, Sequence[Row]], points: ReferencePoints | None
    ) -> Conclusion:
        """Return what follows from the rows of each arm, in the order of its parameters.

        An arm whose engine is not here has no rows. ``points`` are a user's, to be drawn.
        """
