"""Render a page for each cell of the matrix: law, parameters, rows, plots, commands to repeat."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import PurePosixPath

from harness.comparison.known_defects import KnownDefect, defect_of
from harness.comparison.verdicts import Verdict
from harness.comparison.verification import Verification
from harness.report.gallery import Drawn, DrawnCell
from harness.report.matrix import Mark, address
from harness.report.page import Row, look, rows_of
from harness.report.plain import safe_path
from harness.report.sections import CellText
from harness.report.templating import environment
from harness.shown import in_words

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

Place = tuple[str, str, str]


@dataclass(frozen=True)
class Group:
    """Plots that stand together under a name: title, caption and picture, empty without points."""

    name: str
    plots: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True)
class Rows:
    """A table of rows: its title, what is noted of them, and the reasons of their tolerances.

    Those of an ``invariance`` have other columns.
    """

    title: str
    rows: tuple[Mark, ...]
    notes: tuple[str, ...]
    reasons: tuple[str, ...]
    invariance: bool

    @property
    def ordered(self) -> bool:
        """Return whether an error of any row falls with the step at an order that is known."""
        return any(row.order != "-" for row in self.rows)


@dataclass(frozen=True)
class Shown:
    """A known defect as a page shows it; ``address`` of its script is empty without one."""

    defect: KnownDefect
    address: str
    gone: bool


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


def cell_pages(found: Verification, drawn: Sequence[Drawn]) -> Iterator[tuple[str, str]]:
    """Yield address and page of each cell."""
    rows = _by_place(rows_of(found))
    template = environment().get_template("cell.html.j2")
    places = addresses(drawn)
    for cell in (cell for part in drawn for cell in part.cells):
        text, groups = cell.text, _groups(cell)
        own = _in_order(rows.get(text.place, []), [group.name for group in groups])
        told = template.render(
            text=text,
            drawn=cell,
            groups=groups,
            tables=_tables(own, found),
            said=partial(_said, verification=found),
            defects=_defects(own, found),
            scripts=_scripts(cell, found),
            look=look,
            changed=CHANGED,
            who=_who(text, found),
        )
        yield places[text.place], told


def _groups(cell: DrawnCell) -> list[Group]:
    """Return the plots of a cell, those of each system together."""
    return [
        Group(name, tuple((plot.title, plot.caption, picture) for plot, picture in plots))
        for name, plots in groupby(cell.plots, key=lambda pair: pair[0].group)
    ]


def _defects(rows: Sequence[Mark], verification: Verification) -> list[Shown]:
    """Return the known defects that rows are marked with."""
    named = {defect_of(row.check): row.check.verdict for row in rows}
    return [
        Shown(one, f"../{address(one)}" if script else "", named[one.name] is Verdict.FIXED)
        for one, script in verification.defects
        if one.name in named
    ]


def _said(row: Mark, verification: Verification) -> str:
    """Return what is noted of a row, without what is said of its known defect."""
    name = defect_of(row.check)
    known = next((one.note for one, _ in verification.defects if name and one.name == name), "")
    return row.check.note.replace(known, "").strip("; ").removeprefix(GONE).strip("; ")


def _who(text: CellText, verification: Verification) -> str:
    """Return the engine's title with its version."""
    versions = {engine.engine: engine.version for engine in verification.engines}
    if verification.provenance is not None:
        versions[verification.provenance.engine] = verification.provenance.engine_version
    return " ".join(filter(None, (text.who, versions.get(text.engine, ""))))


def _by_place(rows: Sequence[Row]) -> dict[Place, list[Mark]]:
    found: dict[Place, list[Mark]] = {}
    for row in rows:
        cell = row.check.cell
        if cell is not None:
            place = (cell.case, cell.submodel, cell.engine)
            found.setdefault(place, []).append(Mark(row.check, row.id))
    return found


def _in_order(rows: Sequence[Mark], systems: Sequence[str]) -> list[Mark]:
    """Return rows by their systems, those that have plots in the order of these."""

    def order(row: Mark) -> tuple[int, str]:
        name = row.cell.system
        return systems.index(name) if name in systems else len(systems), name

    return sorted(rows, key=order)


def _tables(rows: Sequence[Mark], verification: Verification) -> list[Rows]:
    """Return the rows of values, and those of what must not change a run."""
    found_rows = []
    for title, invariance in ((VALUES, False), (INVARIANCES, True)):
        own = [row for row in rows if bool(row.cell.invariance) is invariance]
        reasons = dict.fromkeys(row.check.why for row in own if row.check.why and not invariance)
        notes = [*_notes(own, verification)]
        if any(row.check.uncertainty > abs(row.check.value) for row in own):
            notes.append(UNCERTAIN)
        found_rows.append(Rows(title, tuple(own), tuple(notes), tuple(reasons), invariance))
    return [one for one in found_rows if one.rows]


def _notes(rows: Sequence[Mark], verification: Verification) -> Iterator[str]:
    """Yield what is said of rows with a value, each once, after the rows that it is said of."""
    said: dict[str, list[str]] = {}
    valued = [row for row in rows if row.quantity]
    for row in valued:
        place = f"{row.cell.system}, {in_words(row.quantity, row.check.unit)}"
        said.setdefault(_said(row, verification), []).append(place)
    for note, places in said.items():
        if note:
            yield note if len(places) == len(valued) else f"{'; '.join(places)}: {note}"


def _scripts(cell: DrawnCell, verification: Verification) -> list[str]:
    """Return the scripts of its engine that the commands of a cell name and run.

    Those of an engine beside the main one stand in a folder of its name.
    """
    told = " ".join(command for _, command in cell.text.commands).split()
    main = (
        verification.provenance.engine if verification.provenance is not None else cell.text.engine
    )
    beside = {engine.engine for engine in verification.engines} - {main}
    engines = {name: name.partition("/")[0] for name in verification.scripts}
    own = [n for n, e in engines.items() if (e if e in beside else main) == cell.text.engine]
    inputs = cell.text.inputs
    if not inputs:
        return [name for name in own if PurePosixPath(name).name in told]
    return [
        name
        for name in own
        # all files of an input that is a folder
        if PurePosixPath(name).parent.name in inputs
        or (PurePosixPath(name).name in told and PurePosixPath(name).stem in inputs)
    ]
