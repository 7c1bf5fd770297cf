"""Write the pages of a run: its report, as one page and as Markdown, and a page for each cell."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import PurePosixPath
from typing import Any

from harness.comparison.known_defects import KnownDefect, defect_of
from harness.comparison.verdicts import Check, Kind, Verdict
from harness.comparison.verification import Verification
from harness.report import text
from harness.report.gallery import Drawn, DrawnCell, commands, titles
from harness.report.matrix import (
    Cause,
    Mark,
    Place,
    address,
    causes,
    matrices,
    stands_in_cell,
    values,
)
from harness.report.plain import safe_path
from harness.report.render import html_page, markdown_page
from harness.report.sections import CellText, Label, Table, TableCell
from harness.report.text import SEVERITY, by_severity, headline, summaries
from harness.shown import in_words, number

NUMERIC = ("value", "expected", "difference", "uncertainty", "tolerance", "used")
COLUMNS = ("verdict", "check", "kind", "value", "expected", "unit", *NUMERIC[2:])


@dataclass(frozen=True)
class Row:
    """A check as the page shows it."""

    check: Check
    id: str

    @property
    def severity(self) -> int:
        """Return the place of the verdict in the order of reading."""
        return SEVERITY.index(self.check.verdict)

    @property
    def used(self) -> float:
        """Return how much of the tolerance the difference takes; 1 is the limit."""
        difference, tolerance = abs(self.check.difference), self.check.tolerance
        if tolerance > 0.0:
            return difference / tolerance
        return 0.0 if difference == 0.0 == tolerance else math.nan

    @property
    def percent(self) -> str:
        """Return that share in per cent; empty where there is none."""
        share = 100.0 * self.used
        return "" if math.isnan(share) else f"{share:.3g} %" if share < 1e4 else "> 1e4 %"

    @property
    def width(self) -> str:
        """Return the length of the bar [%]."""
        return f"{min(100.0, 100.0 * self.used):.0f}"


def rows_of(verification: Verification) -> list[Row]:
    """Return the checks as rows, the most severe first."""
    ordered = by_severity(verification.checks)
    return [Row(check, f"check-{n}") for n, check in enumerate(ordered, 1)]


def report_page(
    verification: Verification, drawn: Sequence[Drawn], cells: Mapping[Place, str] | None = None
) -> str:
    """Return the page; figures, scripts and style are inside it, so that it can be sent alone.

    ``cells`` are the pages of the matrix's cells beside it, by case, submodel and engine.
    """
    outcome = headline(verification.checks, verification.untested_cases)
    frame = {"name": TITLE, "who": _run_label(verification), "columns": COLUMNS}
    return html_page(
        "report.md.j2",
        f"{TITLE}: {outcome}",
        frame=frame,
        **_values(verification, drawn, cells or {}),
    )


TITLE = "DEM verification"

LIMIT = 60_000
"""Characters of the Markdown report: a comment on GitHub holds 65,536."""

KEPT = 2
"""Lines of a table's head, and as many rows are kept at least."""


def report_markdown(verification: Verification, drawn: Sequence[Drawn]) -> str:
    """Return the report as Markdown, below :data:`LIMIT` characters; all text in it is escaped."""
    values = _values(verification, drawn, {})
    return shortened(markdown_page("report.md.j2", TITLE, **values), LIMIT)


def shortened(text: str, limit: int) -> str:
    """Return Markdown of less than ``limit`` characters: the longest tables lose their last rows.

    A sentence below such a table counts them. What is too long without tables ends early.
    """
    blocks = text.rstrip("\n").split("\n\n")
    left_out: Counter[int] = Counter()
    tables = {n: block.split("\n") for n, block in enumerate(blocks) if block.startswith("|")}
    while sum(len(block) + 2 for block in blocks) >= limit:
        long = {n: lines for n, lines in tables.items() if len(lines) > 2 * KEPT}
        if not long:
            end = "\n\nThe rest is in report.html.\n"
            return text[: limit - len(end) - 1].rpartition("\n\n")[0] + end
        longest = max(long, key=lambda n: len(blocks[n]))
        lines = tables[longest]
        kept = max(2 * KEPT, len(lines) // 2)
        left_out[longest] += len(lines) - kept
        tables[longest] = lines[:kept]
        rest = f"{left_out[longest]} more rows are left out; results.csv has every check."
        blocks[longest] = "\n".join(lines[:kept]) + f"\n\n{rest}"
    return "\n\n".join(blocks) + "\n"


def _values(
    verification: Verification, drawn: Sequence[Drawn], cells: Mapping[Place, str]
) -> dict[str, Any]:
    """Return what the template is filled with."""
    rows, engines = rows_of(verification), titles(drawn)
    present = [v for v in SEVERITY if any(c.verdict is v for c in verification.checks)]
    gallery = [part for part in drawn if not part.section.title and part.section.opening is None]
    return {
        "headline": headline(verification.checks, verification.untested_cases),
        "outcome": _outcome(verification),
        "counts": _counts(rows, present),
        "kind_counts": text.summary(verification)[1],
        "severe": _severe(verification),
        "headlines": [(h.name, text.expected(h), text.measured(h)) for h in verification.headlines],
        "verdicts": _verdicts(verification, present),
        "rows": rows,
        "openings": [part for part in drawn if part.section.opening],
        "causes": [
            (cause, rows_in(cause, rows)) for cause in causes(verification, commands(drawn))
        ],
        "findings": [row for row in rows if row.check.verdict is Verdict.FINDING],
        "titles": engines,
        "names": COLUMNS,
        "numeric": NUMERIC,
        "kinds": [s.kind for s in summaries(verification.checks)],
        "present": present,
        "kind_tables": list(_kind_tables(verification)),
        "matrices": [
            matrix.table(cells)
            for matrix in matrices([(row.check, row.id) for row in rows], engines)
        ],
        "values": values(verification.checks, engines),
        "defects": [
            (defect, address(defect) if script else "") for defect, script in verification.defects
        ],
        "cells": cells,
        "parts_of_report": [part for part in drawn if part.section.title],
        "pictures": [picture for part in gallery for picture in part.pictures],
        "failures": [failure for part in gallery for failure in part.failures],
        "scripts": verification.scripts,
        "logs": verification.logs,
        "provenance": text.provenance(verification),
    }


def rows_in(cause: Cause, rows: Sequence[Row]) -> list[Row]:
    """Return the rows of a cause as the page shows them."""
    checks = {id(check) for check in cause.rows}
    return [row for row in rows if id(row.check) in checks]


NAMES = {Verdict.PASS: "holds", Verdict.FAIL: "fails", Verdict.FINDING: "reported"}
"""Of verdicts as heads of a column; the others as they are."""


def _counts(rows: Sequence[Row], present: Sequence[Verdict]) -> list[str]:
    """Return how many rows have each verdict, and of how many."""
    plural = {Verdict.PASS: "hold", Verdict.FAIL: "fail"}
    counts = [
        f"{sum(row.check.verdict is v for row in rows)} {plural.get(v, NAMES.get(v, v))}"
        for v in present
    ]
    return [*counts[:-1], f"{counts[-1]} of {len(rows)} rows"] if counts else []


SEVERE = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)


def _severe(verification: Verification) -> Table:
    """Return the rows that do not hold, failures first, with what happened."""
    rows = []
    for check in by_severity(verification.checks):
        if check.verdict in SEVERE:
            about = "" if check.engine_died else text.triage(check)
            note = "" if math.isnan(check.value) else check.note
            happened = (text.happened(check), about, text.details(check), note)
            words = "; ".join(filter(None, happened))[:600]
            rows.append((f"{check.verdict}: {check.name}", str(check.kind), words))
    return Table("", "", ("check", "kind", "what happened"), tuple(rows))


def _verdicts(verification: Verification, present: Sequence[Verdict]) -> Table:
    """Return the verdicts counted kind by kind, as different kinds are never added up."""
    rows = []
    for summary in summaries(verification.checks):
        counts = [(verdict, summary.count(verdict)) for verdict in present]
        cells = [(Label(str(count), verdict),) if count else "" for verdict, count in counts]
        rows.append((text.KINDS[summary.kind], *cells))
    head = ("kind", *(NAMES.get(verdict, str(verdict)) for verdict in present))
    return Table("Verdicts by kind", "", head, tuple(rows))


CHECKS = ("check", "value", "expected", "difference", "uncertainty", "tolerance", "unit", "verdict")


def _kind_tables(verification: Verification) -> Iterator[Table]:
    """Yield the rows of each kind but those that stand with the cells of the matrix."""
    for summary in summaries(verification.checks):
        rows = [_check(check) for check in summary.checks if not stands_in_cell(check)]
        others = len(summary.checks) - len(rows)
        note = f"{others} rows stand with the cells of the matrix, below." if others else ""
        yield Table(text.KINDS[summary.kind], note, CHECKS, tuple(rows))


def _check(check: Check) -> tuple[str, ...]:
    remarks = ": ".join(text for text in (check.triage, check.note) if text)
    numbers = (check.difference, check.uncertainty, check.tolerance)
    return (
        f"{check.name} ({remarks})" if remarks else check.name,
        *map(number, (check.value, check.expected)),
        *(number(value, 2) for value in numbers),
        check.unit,
        str(check.verdict),
    )


def _outcome(verification: Verification) -> str:
    """Return the class of the headline: green only where each row was judged and holds."""
    verdicts = {check.verdict for check in verification.checks}
    if Verdict.FAIL in verdicts or verification.status:
        return "fail"
    return "apart" if verdicts & {Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED} else ""


def _run_label(verification: Verification) -> str:
    provenance = verification.provenance.label if verification.provenance else "no engine"
    started = verification.started[:16].replace("T", " ")
    return f"{provenance} · {started} UTC · {verification.level} · {verification.seconds:.0f} s"


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
                f"{text.case}, {text.submodel}: {text.engine_title}",
                frame={
                    "name": f"{text.case}: {text.submodel}",
                    "who": _cell_title(text, verification),
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


def _note_text(row: Mark, verification: Verification) -> str:
    """Return the note of a row, without the cause of its known defect."""
    name = defect_of(row.check)
    cause = next(
        (defect.note for defect, _ in verification.defects if name and defect.name == name), ""
    )
    return row.check.note.replace(cause, "").strip("; ").removeprefix(GONE).strip("; ")


def _cell_title(text: CellText, verification: Verification) -> str:
    """Return the engine's title with its version."""
    versions = {engine.engine: engine.version for engine in verification.engines}
    if verification.provenance is not None:
        versions[verification.provenance.engine] = verification.provenance.engine_version
    return " ".join(filter(None, (text.engine_title, versions.get(text.engine, ""))))


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
        return (*first, (Label(_note_text(row, verification), address=link),))
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
        return (*first, _note_text(row, verification))
    numbers = (number(check.value, 2), number(check.tolerance, 2))
    return (*first, *numbers, text.invariances.get(changed, ""), check.why)


def _uncertain(rows: Sequence[Mark]) -> list[str]:
    return [UNCERTAIN] if any(r.check.uncertainty > abs(r.check.value) for r in rows) else []


def _notes(rows: Sequence[Mark], verification: Verification) -> Iterator[str]:
    """Yield the notes of rows with a value, each once, led by the names of its rows."""
    noted: dict[str, list[str]] = {}
    valued = [row for row in rows if row.quantity]
    for row in valued:
        place = f"{row.cell.system}, {in_words(row.quantity, row.check.unit)}"
        noted.setdefault(_note_text(row, verification), []).append(place)
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
