"""Recompute the source, from the ledger to the movies."""

from __future__ import annotations

import platform

from harness import __version__
from harness.comparison.ledger import Ledger, Statement
from harness.comparison.reproduction import Reproduction
from harness.engines.contract import Engine
from harness.engines.registry import open_engine
from harness.verbs.progress import Progress, silent
from harness.verbs.reproduction.exhibits import exhibits
from harness.verbs.reproduction.findings import findings
from harness.verbs.reproduction.ledger import statements
from harness.verbs.reproduction.motions import motions


def reproduce(*, engine: Engine | None = None, progress: Progress = silent) -> Reproduction:
    """Recompute every equation, number and figure of the source and return what was found.

    Without an engine, LAMMPS in-process is opened and closed again. Raise
    EngineError when the engine fails: a reproduction with holes is none. Write the
    report with :func:`harness.report.reproduction.folder.write`.
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
