"""The matrix of cases and submodels release by release: cells that do not hold, defects by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from harness.comparison.baseline_record import name_in_cell
from harness.comparison.known_defects import defect_of
from harness.comparison.verdicts import RANK, Check, Kind, Verdict

Place = tuple[str, str, str]

JUDGED = frozenset({Verdict.PASS, Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED})
"""Verdicts of rows that were held against something."""


@dataclass(frozen=True)
class CellRow:
    """A cell in every release: the worst verdict of its checks, empty where it has none.

    ``reasons`` say why it was not tested, release by release; empty where it was.
    """

    case: str
    submodel: str
    system: str
    verdicts: tuple[str, ...]
    defects: tuple[str, ...]
    """Names of known defects, in any release."""
    reasons: tuple[str, ...] = ()

    def record(self) -> dict[str, Any]:
        """Return it as a JSON-ready mapping."""
        return asdict(self)


def cell_rows(checks: Sequence[Sequence[Check]]) -> list[CellRow]:
    """Return the cells that do not hold in every release; ``checks`` are those of each release."""
    columns = [_by_place(one) for one in checks]
    rows = []
    for place in sorted({place for column in columns for place in column}):
        cells = [column.get(place, []) for column in columns]
        verdicts = tuple(_worst(cell) for cell in cells)
        if {*verdicts} != {str(Verdict.PASS)}:
            names = {defect_of(check) for cell in cells for check in cell} - {""}
            reasons = tuple(map(_reason, cells))
            rows.append(CellRow(*place, verdicts, tuple(sorted(names)), reasons))
    return rows


def untested(rows: Sequence[CellRow], release: int) -> dict[str, list[CellRow]]:
    """Return the cells that a release leaves untested, by the reason."""
    found: dict[str, list[CellRow]] = {}
    for row in rows:
        if row.reasons[release]:
            found.setdefault(row.reasons[release], []).append(row)
    return found


def reasons_of_records(checks: Sequence[Check]) -> dict[str, str]:
    """Return why records have no values, by the name of the record of each untested cell."""
    values = [check for check in checks if check.cell is not None and not check.cell.invariance]
    return {
        name_in_cell(cell[0].cell): _reason(cell)
        for cell in _by_place(values).values()
        if cell[0].cell is not None and _reason(cell)
    }


def defects_of(checks: Sequence[Sequence[Check]]) -> dict[str, list[int]]:
    """Return in how many cells of each release a known defect was found, by its name."""
    found: list[set[tuple[str, Place]]] = [
        {
            (defect_of(check), place)
            for place, cell in _by_place(one).items()
            for check in cell
            if check.verdict is Verdict.KNOWN_DEFECT
        }
        for one in checks
    ]
    names = sorted({name for one in found for name, _ in one})
    return {name: [sum(1 for other, _ in one if other == name) for one in found] for name in names}


def _by_place(checks: Sequence[Check]) -> dict[Place, list[Check]]:
    found: dict[Place, list[Check]] = {}
    for check in checks:
        if check.cell is not None:
            found.setdefault(check.cell.place[:3], []).append(check)
    return found


def _worst(cell: Sequence[Check]) -> str:
    deciding = _deciding(cell)
    return str(min(deciding, key=_rank).verdict) if deciding else ""


def _reason(cell: Sequence[Check]) -> str:
    """Return why a cell was not tested: what its values say, or its invariances without them."""
    if _worst(cell) != Verdict.NOT_TESTED:
        return ""
    rows = [check for check in cell if check.verdict is Verdict.NOT_TESTED]
    values = [check for check in rows if check.kind is not Kind.INVARIANCE]
    return "; ".join(dict.fromkeys(check.note for check in values or rows))


def _rank(check: Check) -> tuple[int, bool]:
    """Return the place from bad to good; of equals what was found counts before what was not."""
    return RANK[check.verdict], check.verdict is Verdict.NOT_TESTED


def _deciding(cell: Sequence[Check]) -> Sequence[Check]:
    """Return the rows that decide a cell: of what was judged, no invariance that was not tested.

    One that no width follows for, or that an engine refuses, says nothing of values that hold.
    """
    if all(check.verdict not in JUDGED for check in cell):
        return cell
    return [c for c in cell if not (c.kind is Kind.INVARIANCE and c.verdict is Verdict.NOT_TESTED)]
