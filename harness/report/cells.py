"""Render a page for each cell of the matrix: law, parameters, rows, plots, commands to repeat."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from harness.comparison.verification import Verification
from harness.report.gallery import Drawn, DrawnCell
from harness.report.matrix import Mark
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
            scripts=_scripts(cell, found),
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


def _by_place(rows: Sequence[Row]) -> dict[Place, list[Mark]]:
    found: dict[Place, list[Mark]] = {}
    for row in rows:
        cell = row.check.cell
        if cell is not None:
            place = (cell.case, cell.submodel, cell.engine)
            found.setdefault(place, []).append(Mark(row.check, row.id))
    for marks in found.values():
        marks.sort(key=lambda one: one.cell.system)
    return found


def _scripts(cell: DrawnCell, found: Verification) -> list[str]:
    """Return the scripts of its engine that the commands of a cell name.

    Those of an engine beside the main one stand in a folder of its name.
    """
    told = " ".join(command for _, command in cell.text.commands).split()
    main = found.provenance.engine if found.provenance is not None else cell.text.engine
    beside = {one.engine for one in found.engines} - {main}
    engines = {name: name.partition("/")[0] for name in found.scripts}
    own = [n for n, e in engines.items() if (e if e in beside else main) == cell.text.engine]
    return [name for name in own if name.rpartition("/")[2] in told]
