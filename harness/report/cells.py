"""A page for each cell of the matrix: law, parameters, rows, plots, and how to run it again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from harness.comparison.verdicts import Cell
from harness.comparison.verification import Verification
from harness.report.gallery import Drawn, DrawnCell
from harness.report.page import Row, look, rows_of
from harness.report.plain import safe_path
from harness.report.sections import CellText
from harness.report.templating import environment

FOLDER = "cells"
HEAD = (
    "system",
    "quantity",
    "value",
    "reference",
    "by",
    "unit",
    "error",
    "tolerance",
    "order",
    "95 % interval",
    "verdict",
)
NUMERIC = frozenset({2, 3, 6, 7, 8, 9})

Place = tuple[str, str, str]


@dataclass(frozen=True)
class Judged(Row):
    """A row of the cell, as it stands in the report."""

    @property
    def cell(self) -> Cell:
        """Return its place in the matrix."""
        assert self.check.cell is not None
        return self.check.cell

    @property
    def quantity(self) -> str:
        """Return what was measured; empty for a row that says that nothing was."""
        words = self.check.name.rpartition(": ")
        return words[2] if math.isfinite(self.check.expected) else ""

    @property
    def order(self) -> str:
        """Return the observed order; a dash where there is none to be told."""
        return "-" if math.isnan(self.cell.order) else f"{self.cell.order:.2f}"

    @property
    def interval(self) -> str:
        """Return the interval of the order."""
        if math.isnan(self.cell.order):
            return "-"
        return f"{self.cell.order_low:.2f} to {self.cell.order_high:.2f}"


def addresses(drawn: Sequence[Drawn]) -> dict[Place, str]:
    """Return the file of each cell's page below the report, by case, submodel and engine."""
    found: dict[Place, str] = {}
    for cell in (cell for part in drawn for cell in part.cells):
        words = "-".join((cell.text.engine, cell.text.case, cell.text.submodel))
        stem = safe_path(words.replace("/", "-").lower())
        taken, number = set(found.values()), 1
        while f"{FOLDER}/{stem}.html" in taken:
            number += 1
            stem = f"{stem.rstrip('0123456789')}{number}"
        found[cell.text.place] = f"{FOLDER}/{stem}.html"
    return found


def cell_pages(found: Verification, drawn: Sequence[Drawn]) -> Iterator[tuple[str, str]]:
    """Yield address and page of each cell."""
    rows = _by_place(rows_of(found))
    template = environment().get_template("cell.html.j2")
    places = addresses(drawn)
    for cell in (cell for part in drawn for cell in part.cells):
        text = cell.text
        told = template.render(
            text=text,
            drawn=cell,
            rows=rows.get(text.place, ()),
            head=HEAD,
            numeric=NUMERIC,
            scripts=_scripts(cell, found.scripts),
            look=look,
            who=_who(text, found),
        )
        yield places[text.place], told


def _who(text: CellText, found: Verification) -> str:
    """Return the engine's title with its version."""
    versions = {one.engine: one.version for one in found.engines}
    if found.provenance is not None:
        versions[found.provenance.engine] = found.provenance.engine_version
    return " ".join(filter(None, (text.who, versions.get(text.engine, ""))))


def _by_place(rows: Sequence[Row]) -> dict[Place, list[Judged]]:
    found: dict[Place, list[Judged]] = {}
    for row in rows:
        cell = row.check.cell
        if cell is not None:
            place = (cell.case, cell.submodel, cell.engine)
            found.setdefault(place, []).append(Judged(row.check, row.id))
    for judged in found.values():
        judged.sort(key=lambda one: one.cell.system)
    return found


def _scripts(cell: DrawnCell, scripts: Mapping[str, str]) -> list[str]:
    """Return the scripts that the commands of a cell name."""
    told = " ".join(command for _, command in cell.text.commands).split()
    return [name for name in scripts if name.rpartition("/")[2] in told]
