"""Group what fails, is known or was not tested by its cause: a cause once, with its rows.

A known defect is one cause in whatever cells it shows, and so is a reason for which rows were not
tested. Failures without a known cause are grouped by their class, of what kind it is, and the cell
that they stand in; the first row of a group tells its numbers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from harness.comparison.known_defects import KnownDefect, defect_of
from harness.comparison.verdicts import Check, Verdict
from harness.comparison.verification import Verification
from harness.report import text
from harness.report.matrix import Place, address
from harness.report.plain import printable

APART = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)
"""Verdicts that need a cause, in the order of reading."""

COMMENT = re.compile(r"^(?:#|//|!)+ ?")
REMARK = re.compile(r" {3,}(?!#)")
"""What stands between a command and a remark on it."""


@dataclass(frozen=True)
class Cause:
    """Rows of one verdict and one cause.

    ``title`` names it, ``sentences`` explain it. ``commands`` run it again, each on a line;
    ``script`` is the address of the script that shows a known defect, empty without one. ``cells``
    are the cells that it stands in, in the order of the rows.
    """

    verdict: Verdict
    title: str
    sentences: tuple[str, ...]
    rows: tuple[Check, ...]
    commands: tuple[str, ...] = ()
    script: str = ""

    @property
    def cells(self) -> tuple[Place, ...]:
        """Return case, submodel and engine of each cell once."""
        places = (row.cell.place[:2] + row.cell.place[3:4] for row in self.rows if row.cell)
        return tuple(dict.fromkeys((case, name, engine) for case, name, engine in places))

    @property
    def count(self) -> str:
        """Return how many rows there are, in how many cells of the matrix."""
        rows, cells = len(self.rows), len(self.cells)
        counted = f"{rows} row{'s' * (rows != 1)}"
        return f"{counted} in {cells} cell{'s' * (cells != 1)} of the matrix" if cells else counted


def causes(verification: Verification, commands: Mapping[Place, Sequence[str]]) -> list[Cause]:
    """Return the causes of what does not hold, the most severe first.

    ``commands`` repeat a run of a cell, by the cell; those of its first cell stand with a failure.
    """
    groups: dict[tuple[str, ...], list[Check]] = {}
    for check in text.by_severity(verification.checks):
        if check.verdict in APART:
            groups.setdefault((check.verdict, *_key(check)), []).append(check)
    defects = {defect.name: (defect, script) for defect, script in verification.defects}
    return [_cause(rows, defects, commands) for rows in groups.values()]


def _key(check: Check) -> tuple[str, ...]:
    """Return what rows of one cause have in common."""
    if defect := defect_of(check):
        return (defect,)
    if check.verdict is Verdict.NOT_TESTED and check.cell and math.isnan(check.value):
        return (check.cell.engine,)
    if check.verdict is Verdict.NOT_TESTED:
        return (check.note,)
    cell = check.cell.place[:2] if check.cell else ()
    if check.engine_died:
        return (check.triage, check.note, *cell)
    return (check.kind, check.triage, *cell)


def _cause(
    rows: Sequence[Check],
    defects: Mapping[str, tuple[KnownDefect, str]],
    commands: Mapping[Place, Sequence[str]],
) -> Cause:
    first = rows[0]
    name = defect_of(first)
    if name in defects:
        return _of_defect(rows, *defects[name])
    sentences: tuple[str, ...] = ()
    if first.verdict is Verdict.NOT_TESTED:
        title = first.note or "no reason was given"
        if len({row.note for row in rows}) > 1 and first.cell:
            title = f"What {first.cell.engine} does not state, or left without a value"
    else:
        title = text.triage(first) or str(first.verdict)
        if first.cell:
            title = f"{title}: {first.cell.case}, {first.cell.submodel}"
        else:
            title = f"{title}: {first.name}"
        remarks = (text.explained(first), text.details(first), text.happened(first))
        sentences = tuple(dict.fromkeys(_sentence(remark) for remark in remarks if remark))
    cause = Cause(first.verdict, title, sentences, tuple(rows))
    again = next((commands[cell] for cell in cause.cells if cell in commands), ())
    repeated = first.verdict is Verdict.FAIL
    return replace(cause, commands=tuple(again) if repeated else ())


def _of_defect(rows: Sequence[Check], defect: KnownDefect, script: str) -> Cause:
    """Return a known defect with what its script says of itself."""
    releases = " ".join(
        f"{word} {release}"
        for word, release in (("from", defect.since), ("to", defect.until))
        if release
    )
    sentences = [f"{defect.kind.capitalize()}: {defect.cause}."]
    if releases:
        sentences.append(f"Releases {releases}.")
    sentences.append(f"Upstream: {defect.upstream}.")
    file = address(defect) if script else ""
    folder = file.rpartition("/")[0]
    lines = (f"cd {folder}", *runs_of_script(script)) if script else ()
    return Cause(rows[0].verdict, defect.name, tuple(sentences), tuple(rows), lines, file)


def runs_of_script(script: str) -> Iterator[str]:
    """Yield the commands that a script gives in its opening comment: its indented lines."""
    for line in printable(script).splitlines():
        text = COMMENT.sub("", line, count=1)
        if text == line:
            return
        if text.startswith("    "):
            yield REMARK.sub("   # ", text.strip())


def _sentence(words: str) -> str:
    return f"{words.rstrip('.')}."
