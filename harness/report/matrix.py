"""Matrices: rows of a run counted by two of their columns, with the verdicts of each cell.

Columns that a case adds to its rows work as well: ``matrix(rows.assign(law=..., system=...),
"law", "system")``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from harness.report.render import Badge
from harness.results.rows import Verdict

if TYPE_CHECKING:
    import pandas as pd

ORDER = {str(verdict): place for place, verdict in enumerate(Verdict)}
FAILING = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED)


def matrix(rows: pd.DataFrame, index: str | Sequence[str], columns: str) -> pd.DataFrame:
    """Return how many rows have each verdict, in cells of :class:`Badge`, the gravest first."""
    keys = [index] if isinstance(index, str) else list(index)
    cells = rows.groupby([*keys, columns], sort=True)["verdict"].agg(verdict_badges)
    return cells.unstack(columns).astype(object).where(lambda frame: frame.notna(), "")


def verdict_badges(verdicts: Iterable[str], address: str = "") -> tuple[Badge, ...]:
    """Return how many of the verdicts there are of each, the gravest first."""
    numbers = Counter(verdicts)
    present = [str(verdict) for verdict in Verdict if verdict in numbers]
    return tuple(Badge(f"{numbers[verdict]} {verdict}", verdict, address) for verdict in present)


def worst_verdicts(rows: pd.DataFrame, index: str | Sequence[str], columns: str) -> pd.DataFrame:
    """Return the gravest verdict of the rows in each cell, empty for a cell without rows."""
    keys = [index] if isinstance(index, str) else list(index)
    verdicts = rows.groupby([*keys, columns], sort=True)["verdict"]
    return verdicts.agg(lambda cell: min(cell, key=ORDER.__getitem__)).unstack(columns).fillna("")


def divided_setups(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the setups that fail in some engine: the gravest verdict in each engine."""
    cells = worst_verdicts(rows, ("case", "setup"), "engine")
    return cells[cells.isin(list(FAILING)).any(axis="columns")]
