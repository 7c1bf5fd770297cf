"""What does not hold, by its cause.

A known defect is one cause, whatever rows it breaks. Failures without a known cause are grouped by
case, engine and class; what was not tested is grouped by engine, with the reasons.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from shlex import quote
from typing import TYPE_CHECKING, Any

from harness.report.text import SHORT, number, value_text
from harness.results.rows import ENGINE_FAILURES, Failure, Kind, Row, Verdict, rows_of

if TYPE_CHECKING:
    import pandas as pd

Defects = Mapping[str, Mapping[str, Any]]  # tables of inputs/known-defects.toml, by name
VERDICTS, KINDS = tuple(Verdict), tuple(Kind)
WITH_CAUSE = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)
MEANINGS = {
    Failure.OUT_OF_TOLERANCE: "The difference is larger than the tolerance.",
    Failure.NOT_A_NUMBER: "A value is not a number.",
    Failure.FROM_FIRST_STEP: "The two differ from the first step: another law, parameter or "
    "initial state, not an accumulated error.",
    Failure.LATE: "The two agree at first and differ later: a contact opened or closed at another "
    "step, or an error grew.",
    Failure.WRONG_INPUT: "The engine refused its input.",
    Failure.ENGINE: "The engine ended with an error of its own.",
    Failure.TIMEOUT: "The run did not finish within its time limit.",
    Failure.MEMORY: "The run exceeded its memory limit.",
    Failure.HARNESS: "The harness failed, not the engine.",
    Failure.MISSING: "The accepted run has the row, this run does not.",
}


@dataclass(frozen=True)
class Entry:
    """A row of a run with its id in the page."""

    row: Row
    id: str

    @property
    def used(self) -> float:
        """Return the part of the tolerance that the difference uses [1], NaN without one."""
        difference, tolerance = abs(self.row.difference), self.row.tolerance
        if tolerance > 0.0:
            return difference / tolerance
        return 0.0 if difference == tolerance == 0.0 else math.nan

    @property
    def percent(self) -> str:
        """Return :attr:`used` in per cent, empty without a tolerance."""
        if math.isnan(self.used):
            return ""
        return f"{100.0 * self.used:.3g} %" if self.used < 100.0 else "> 1e4 %"

    @property
    def outcome(self) -> str:
        """Return why the row has its verdict, in a line: value against expected, or the note."""
        row = self.row
        if math.isnan(row.value):
            return row.note
        unit = "" if row.unit == "1" else row.unit
        value = value_text(row.value, row.uncertainty, unit)
        against = f"{value} against {number(row.expected)} {unit}".rstrip()
        limit = f"difference {number(row.difference, SHORT)}"
        if row.kind is not Kind.FINDING:
            limit += f", tolerance {number(row.tolerance, SHORT)}"
        return f"{against}, {limit}"

    @property
    def meaning(self) -> str:
        """Return what the class of a failure means."""
        return MEANINGS.get(self.row.failure, "")


@dataclass(frozen=True)
class Cause:
    """Rows of one verdict and one cause, with what explains it and the commands that repeat it.

    ``reasons`` are those of rows that were not tested, with their numbers.
    """

    verdict: Verdict
    title: str
    sentences: tuple[str, ...]
    entries: tuple[Entry, ...]
    commands: tuple[str, ...] = ()
    reasons: tuple[tuple[str, int], ...] = ()


def entries_of(rows: pd.DataFrame) -> list[Entry]:
    """Return the rows of a run in the order of reading: the gravest verdict first, then by kind."""
    ordered = sorted(
        rows_of(rows), key=lambda row: (VERDICTS.index(row.verdict), KINDS.index(row.kind))
    )
    return [Entry(row, f"row-{number}") for number, row in enumerate(ordered, 1)]


def causes(entries: Sequence[Entry], defects: Defects) -> list[Cause]:
    """Return the causes of what does not hold, the gravest verdict first."""
    groups: dict[tuple[str, ...], list[Entry]] = {}
    for entry in entries:
        if entry.row.verdict in WITH_CAUSE:
            groups.setdefault((entry.row.verdict, *_cause_key(entry.row)), []).append(entry)
    return [_cause(group, defects) for group in groups.values()]


def _cause_key(row: Row) -> tuple[str, ...]:
    if row.defect:
        return (row.defect,)
    if row.verdict is Verdict.NOT_TESTED:
        return (row.engine,)
    if row.failure in ENGINE_FAILURES:
        return (row.engine, row.failure, row.note)
    return (row.engine, row.failure, row.case)


def _cause(group: Sequence[Entry], defects: Defects) -> Cause:
    row = group[0].row
    if row.defect:
        return _defect_cause(group, defects.get(row.defect, {}))
    if row.verdict is Verdict.NOT_TESTED:
        reasons = Counter(entry.row.note or "no reason" for entry in group).most_common()
        return Cause(row.verdict, row.engine, (), tuple(group), reasons=tuple(reasons))
    title = f"{row.failure or row.verdict}: {row.case}, {row.engine}"
    sentences = (group[0].meaning, group[0].outcome, row.note)
    shown = tuple(dict.fromkeys(sentence for sentence in sentences if sentence))
    return Cause(row.verdict, title, shown, tuple(group), (verify_command(row),))


def _defect_cause(group: Sequence[Entry], defect: Mapping[str, Any]) -> Cause:
    row = group[0].row
    sentences = [defect_sentence(defect)] if defect else [row.note]
    if upstream := defect.get("upstream"):
        sentences.append(f"Upstream: {upstream}.")
    script = defect.get("script", "")
    commands = (f"dem-harness defect {row.defect}",) if script else ()
    return Cause(row.verdict, row.defect, tuple(filter(None, sentences)), tuple(group), commands)


def defect_releases(defect: Mapping[str, Any]) -> str:
    """Return the first and the last release that is known to have a defect, empty for all."""
    words = (("from", "since"), ("to", "until"))
    return " ".join(f"{word} {defect[key]}" for word, key in words if defect.get(key))


def defect_sentence(defect: Mapping[str, Any]) -> str:
    """Return the cause of a known defect with its releases."""
    releases = defect_releases(defect)
    cause = f"{defect['cause'][:1].upper()}{defect['cause'][1:]}."
    return f"{cause} Releases {releases}." if releases else cause


def verify_command(row: Row) -> str:
    """Return the command that makes a row again."""
    path = quote("/".join((row.case, row.setup, row.quantity)))
    engines = "" if row.engine == "harness" else f" --engines {quote(row.engine)}"
    return f"dem-harness verify --only {path}{engines}"
