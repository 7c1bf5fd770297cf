"""Recompute the source, from the ledger to the movies."""

from __future__ import annotations

import platform

from harness import __version__
from harness.engines.contract import Engine
from harness.engines.registry import open_engine
from harness.reproduction.claims import Ledger, Statement
from harness.reproduction.compute_figure_data import exhibits
from harness.reproduction.findings import findings
from harness.reproduction.ledger import statements
from harness.reproduction.motions import motions
from harness.reproduction.result import Reproduction
from harness.workflows.progress import Progress, silent


def reproduce(*, engine: Engine | None = None, progress: Progress = silent) -> Reproduction:
    """Recompute every equation, number and figure of the source and return what was found.

    Without an engine, LAMMPS in-process is opened and closed again. Raise
    EngineError when the engine fails: a reproduction with holes is none. Write the
    report with :func:`harness.reproduction.pages.folder.write`.
    """
    if engine is None:
        with open_engine() as opened:
            return reproduce(engine=opened, progress=progress)
    shown = exhibits(engine, progress)
    rows = statements(engine=engine, progress=progress)
    return Reproduction(
        ledger=Ledger(in_order(rows, shown.statements)),
        exhibits=shown,
        motions=motions(engine, progress),
        findings=findings(engine, progress),
        provenance=engine.identify(),
        platform=f"{platform.system()} {platform.machine()}",
        harness_version=__version__,
    )


def in_order(rows: list[Statement], figures: tuple[Statement, ...]) -> tuple[Statement, ...]:
    """Return equations and text, then the figures, then the errata."""
    after = ("erratum", "beyond")
    text = [row for row in rows if not row.source.key.startswith(after)]
    errata = [row for row in rows if row.source.key.startswith(after)]
    return (*text, *figures, *errata)
