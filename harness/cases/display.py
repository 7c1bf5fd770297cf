"""How a case is shown: sections of a report, figures of a sweep, a film."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Job
from harness.report.sections import Section

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from harness.cases.contract import Case
    from harness.report.film import Film


@dataclass(frozen=True)
class Display:
    """Shows what a case left; by default nothing but its rows."""

    case: Case[Any]

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the sections of the report: of the main engine, of solvers, of other engines."""
        return ()

    def figures(self, rows: pd.DataFrame) -> Mapping[str, Callable[[], Figure]]:
        """Return what draws figures of a sweep's rows, those that are done, by names of files."""
        return {}

    @property
    def has_film(self) -> bool:
        """Return whether the case has films."""
        return type(self).film is not Display.film

    def film_jobs(self, parameters: Any, frames: int) -> Sequence[Job]:
        """Return the jobs of a film that an engine may refuse although it runs the case."""
        return ()

    def film(self, engine: Engine, parameters: Any, frames: int) -> Film:
        """Return the film of one run of a case that has films.

        Raise EngineError for a run that failed.
        """
        raise NotImplementedError
