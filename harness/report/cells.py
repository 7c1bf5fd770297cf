"""Render a page for each cell of the matrix: law, parameters, rows, plots, commands to repeat."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import PurePosixPath

from harness.comparison.known_defects import KnownDefect, defect_of
from harness.comparison.verdicts import Kind, Verdict
from harness.comparison.verification import Verification
from harness.report.gallery import Drawn, DrawnCell
from harness.report.matrix import Mark, Place, address
from harness.report.page import Row, rows_of
from harness.report.plain import safe_path
from harness.report.render import html_page
from harness.report.sections import CellText, Label, Table, TableCell
from harness.shown import in_words, number

FOLDER = "cells"
GONE = "no longer there:"
"""With which the note of a row begins whose known defect is gone."""
CHANGED = (
    "Each row repeats a run with one thing changed that must not matter. The number is the largest "
    "difference of the two motions, over the size of what differs; allowed is what round-off can "
    "make of it, for the reason given."
)
"""What an invariance is."""
UNCERTAIN = (
    "Where the uncertainty is larger than the value, the value is 0 as far as can be told: "
    "the uncertainty is how far the limit of a small step may still move."
)

VALUES, INVARIANCES = "Limits of a small step", "What must not change a run"

HEAD = ("system", "verdict", "quantity", "value", "uncertainty", "reference", "by", "error",
        "tolerance", "order (95 %)")  # fmt: skip
CHANGES = ("system", "verdict", "changed", "difference", "allowed", "what was done",
           "what may differ")  # fmt: skip
REPORT = "../report.html#"
BY = {Kind.ANALYTIC: "closed form", Kind.INVARIANCE: "the same run"}
"""What a value is held against; any other is an integration."""


def addresses(drawn: Sequence[Drawn]) -> dict[Place, str]:
    """Return the file of each cell's page below the report, by case, submodel and engine."""
    places: dict[Place, str] = {}
    for cell in (cell for part in drawn for cell in part.cells):
        words = "-".join((cell.text.engine, cell.text.case, cell.text.submodel))
        stem = safe_path(words.replace("/", "-").lower())
        taken, number = set(places.values()), 1
        while f"{FOLDER}/{stem}.html" in taken:
            number += 1
            stem = f"{stem.rstrip('0123456789')}{number}"
        places[cell.text.place] = f"{FOLDER}/{stem}.html"
    return places


def cell_pages(verification: Verification, drawn: Sequence[Drawn]) -> Iterator[tuple[str, str]]:
    """Yield address and page of each cell."""
    rows = _by_place(rows_of(verification))
    places = addresses(drawn)
    for cell in (cell for part in drawn for cell in part.cells):
        text = cell.text
        systems = [
            (name, [(plot.title, plot.caption, picture) for plot, picture in plots])
            for name, plots in groupby(cell.plots, key=lambda pair: pair[0].group)
        ]
        marks = _in_order(rows.get(text.place, []), [name for name, _ in systems])
        yield (
            places[text.place],
            html_page(
                "cell.md.j2",
                f"{text.case}, {text.submodel}: {text.who}",
                frame={
                    "name": f"{text.case}: {text.submodel}",
                    "who": _who(text, verification),
                    "above": f"{REPORT}matrix",
                    "sheet": "style.css",
                    "look": "cell",
                },
                text=text,
                systems=systems,
                tables=list(_tables(marks, text, verification)),
                defects=_defects(marks, verification),
                failures=cell.failures,
                scripts=[f"scripts/{safe_path(name)}" for name in _scripts(cell, verification)],
            ),
        )


def _defects(
    rows: Sequence[Mark], verification: Verification
) -> list[tuple[KnownDefect, str, bool]]:
    """Return known defects that rows are marked with, address of the script, whether it is gone."""
    named = {defect_of(row.check): row.check.verdict for row in rows}
    return [
        (defect, address(defect) if script else "", named[defect.name] is Verdict.FIXED)
        for defect, script in verification.defects
        if defect.name in named
    ]


def _said(row: Mark, verification: Verification) -> str:
    """Return what is noted of a row, without what is said of its known defect."""
    name = defect_of(row.check)
    cause = next(
        (defect.note for defect, _ in verification.defects if name and defect.name == name), ""
    )
    return row.check.note.replace(cause, "").strip("; ").removeprefix(GONE).strip("; ")


def _who(text: CellText, verification: Verification) -> str:
    """Return the engine's title with its version."""
    versions = {engine.engine: engine.version for engine in verification.engines}
    if verification.provenance is not None:
        versions[verification.provenance.engine] = verification.provenance.engine_version
    return " ".join(filter(None, (text.who, versions.get(text.engine, ""))))


def _by_place(rows: Sequence[Row]) -> dict[Place, list[Mark]]:
    marks: dict[Place, list[Mark]] = {}
    for row in rows:
        cell = row.check.cell
        if cell is not None:
            place = (cell.case, cell.submodel, cell.engine)
            marks.setdefault(place, []).append(Mark(row.check, row.id))
    return marks


def _in_order(rows: Sequence[Mark], systems: Sequence[str]) -> list[Mark]:
    """Return rows by their systems, those that have plots in the order of these."""

    def order(row: Mark) -> tuple[int, str]:
        name = row.cell.system
        return systems.index(name) if name in systems else len(systems), name

    return sorted(rows, key=order)


def _tables(
    rows: Sequence[Mark], text: CellText, verification: Verification
) -> Iterator[tuple[Table, list[str]]]:
    """Yield the rows of values, and those of what must not change a run, each with notes."""
    values = [row for row in rows if not row.cell.invariance]
    changed = [row for row in rows if row.cell.invariance]
    if values:
        ordered = any(row.order != "-" for row in values)
        head = HEAD if ordered else HEAD[:-1]
        cells = tuple(_value(row, verification)[: len(head)] for row in values)
        reasons = dict.fromkeys(f"Tolerance: {row.check.why}." for row in values if row.check.why)
        notes = [*_notes(values, verification), *_uncertain(values), *reasons]
        yield Table(VALUES, "", head, cells), notes
    if changed:
        cells = tuple(_change(row, text, verification) for row in changed)
        notes = [*_notes(changed, verification), *_uncertain(changed)]
        yield Table(INVARIANCES, CHANGED, CHANGES, cells), notes


def _value(row: Mark, verification: Verification) -> tuple[TableCell, ...]:
    check, link = row.check, REPORT + row.place
    first = (row.cell.system, (Label(check.verdict, check.verdict),))
    if not row.quantity:
        return (*first, (Label(_said(row, verification), address=link),))
    unit = f" ({check.unit})" if check.unit not in ("", "1") else ""
    return (
        *first,
        (Label(in_words(row.quantity, check.unit) + unit, address=link),),
        number(check.value, 9),
        number(check.uncertainty, 2),
        number(check.expected, 9),
        BY.get(check.kind, "integration"),
        number(check.difference, 2),
        number(check.tolerance, 2),
        row.order + (f" ({row.interval})" if row.order != "-" else ""),
    )


def _change(row: Mark, text: CellText, verification: Verification) -> tuple[TableCell, ...]:
    check, changed = row.check, row.cell.invariance
    first = (
        row.cell.system,
        (Label(check.verdict, check.verdict),),
        (Label(changed, address=REPORT + row.place),),
    )
    if not row.quantity:
        return (*first, _said(row, verification))
    numbers = (number(check.value, 2), number(check.tolerance, 2))
    return (*first, *numbers, text.invariances.get(changed, ""), check.why)


def _uncertain(rows: Sequence[Mark]) -> list[str]:
    return [UNCERTAIN] if any(r.check.uncertainty > abs(r.check.value) for r in rows) else []


def _notes(rows: Sequence[Mark], verification: Verification) -> Iterator[str]:
    """Yield what is said of rows with a value, each once, after the rows that it is said of."""
    noted: dict[str, list[str]] = {}
    valued = [row for row in rows if row.quantity]
    for row in valued:
        place = f"{row.cell.system}, {in_words(row.quantity, row.check.unit)}"
        noted.setdefault(_said(row, verification), []).append(place)
    for note, places in noted.items():
        if note:
            yield note if len(places) == len(valued) else f"{'; '.join(places)}: {note}"


def _scripts(cell: DrawnCell, verification: Verification) -> list[str]:
    """Return the scripts of its engine that the commands of a cell name and run.

    Those of an engine beside the main one stand in a folder of its name.
    """
    words = " ".join(command for _, command in cell.text.commands).split()
    main = (
        verification.provenance.engine if verification.provenance is not None else cell.text.engine
    )
    others = {engine.engine for engine in verification.engines} - {main}
    engines = {name: name.partition("/")[0] for name in verification.scripts}
    names = [n for n, e in engines.items() if (e if e in others else main) == cell.text.engine]
    inputs = cell.text.inputs
    if not inputs:
        return [name for name in names if PurePosixPath(name).name in words]
    return [
        name
        for name in names
        # all files of an input that is a folder
        if PurePosixPath(name).parent.name in inputs
        or (PurePosixPath(name).name in words and PurePosixPath(name).stem in inputs)
    ]
