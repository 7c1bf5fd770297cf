"""Recompute the source, from the ledger to the movies."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness import __version__
from harness.engines.contract import Engine
from harness.engines.registry import open_engine
from harness.observables.provenance import Provenance
from harness.observables.reference import ReferencePoints
from harness.reproduction.claims import ClaimStatus, Ledger
from harness.reproduction.findings import Findings, findings
from harness.reproduction.ledger import in_order, statements
from harness.reproduction.movies.motions import Motions, motions
from harness.reproduction.reproduced_figures import SourceFigure, source_figures
from harness.shown import Shown
from harness.workflows.progress import Progress, silent

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure


@dataclass(frozen=True, repr=False)
class Reproduction(Shown):
    """All that a reproduction found; the same code and engine give the same."""

    ledger: Ledger
    figures: tuple[SourceFigure, ...]
    motions: Motions
    findings: Findings
    provenance: Provenance
    platform: str
    harness_version: str

    def frame(self) -> pd.DataFrame:
        """Return the ledger as a table, a row for each statement."""
        return self.ledger.frame()

    def told(self) -> dict[str, str]:
        """Return how many statements have each status, and who ran what it took."""
        counts = {str(status): str(self.ledger.count(status)) for status in ClaimStatus}
        return {**counts, "engine": self.provenance.told}

    def drawn(self) -> Figure:
        """Draw how many statements have each status."""
        from harness.shown.figure import Figure, label

        figure = Figure(figsize=(7.0, 2.6), layout="constrained")
        axes = figure.add_subplot()
        axes.barh([*map(str, ClaimStatus)], [self.ledger.count(status) for status in ClaimStatus])
        axes.invert_yaxis()
        label(axes, "statements of the source", "status")
        return figure


def reproduce(
    *,
    engine: Engine | None = None,
    reference: ReferencePoints | None = None,
    progress: Progress = silent,
) -> Reproduction:
    """Recompute every equation, number and figure of the source and return what was found.

    Without an engine, LAMMPS in-process is opened and closed again. ``reference`` are measured
    angles [deg] against height, for what the source compares with others. Raise EngineError when
    the engine fails: a reproduction with holes is none. Write the report with
    :func:`harness.reproduction.page.write`.
    """
    if engine is None:
        with open_engine() as opened:
            return reproduce(engine=opened, reference=reference, progress=progress)
    figures = source_figures(engine, progress, reference=reference)
    rows = statements(engine=engine, progress=progress)
    return Reproduction(
        ledger=Ledger(tuple(in_order([*rows, *(figure.statement for figure in figures)]))),
        figures=figures,
        motions=motions(engine, progress),
        findings=findings(engine, progress),
        provenance=engine.identify(),
        platform=f"{platform.system()} {platform.machine()}",
        harness_version=__version__,
    )
