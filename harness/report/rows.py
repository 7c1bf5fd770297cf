"""Rows for pages: their texts, the causes of those that do not hold, and matrices of verdicts.

A known defect is one cause, whatever rows it breaks. Failures without a known cause are grouped by
case, engine and class; rows that were not tested are grouped by engine, with the reasons.
"""

from __future__ import annotations

import base64
import gzip
import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from shlex import quote
from typing import TYPE_CHECKING, Any, NamedTuple

from harness.report.text import SHORT, number, printable, value_text
from harness.results.rows import ENGINE_FAILURES, Failure, Kind, Row, Verdict, rows_of

if TYPE_CHECKING:
    import pandas as pd

Defects = Mapping[str, Mapping[str, Any]]  # tables of inputs/known-defects.toml, by name
ORDER = {str(verdict): place for place, verdict in enumerate(Verdict)}  # the gravest first
WITH_CAUSE = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)
FAILING = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED)
COLUMNS = ("verdict", "row", "kind", "engine", "value", "expected", "unit", "difference",
           "uncertainty", "tolerance", "used")  # fmt: skip
LOG_TAIL = 3_000  # characters of the log of a failed run
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


class Badge(NamedTuple):
    """A cell of a table, or a part of one, in the colours of a verdict, with a link."""

    text: str
    verdict: str = ""
    address: str = ""


@dataclass(frozen=True)
class Entry:
    """A row with its number in the order of reading, from 1, and its texts."""

    row: Row
    number: int

    @property
    def used(self) -> float:
        """Return the ratio of difference and tolerance [1], NaN without a tolerance."""
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
        """Return the reason of the verdict in a line: value against expected, or the note."""
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
    def cells(self) -> tuple[str, ...]:
        """Return the texts of the columns :data:`COLUMNS`."""
        row = self.row
        setup = ", ".join(filter(None, (row.setup, row.check)))
        name = f"{': '.join(filter(None, (row.case, setup)))}: {row.quantity}"
        short = (number(n, SHORT) for n in (row.difference, row.uncertainty, row.tolerance))
        return (str(row.verdict), name, str(row.kind), row.engine, number(row.value),
                number(row.expected), row.unit if row.unit != "1" else "", *short,
                self.percent)  # fmt: skip

    @property
    def details(self) -> tuple[str, ...]:
        """Return class of failure, note, reason of the tolerance and log, empty where missing."""
        row = self.row
        failure = f"{row.failure}. {MEANINGS[row.failure]}" if row.failure else ""
        reason = f"Tolerance: {row.reason}" if row.reason else ""
        return failure, row.note, reason, row.log[-LOG_TAIL:]


@dataclass(frozen=True)
class Cause:
    """Rows of one verdict and one cause, with its explanation and the commands that repeat it.

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
    kinds = {str(kind): place for place, kind in enumerate(Kind)}
    ordered = sorted(rows_of(rows), key=lambda row: (ORDER[row.verdict], kinds[row.kind]))
    return [Entry(row, place) for place, row in enumerate(ordered, 1)]


def packed(entries: Sequence[Entry], causes: Sequence[Cause]) -> str:
    """Return all rows as base64 of gzipped JSON, a list of texts for each column.

    The columns are :data:`COLUMNS`, the details of an entry, and the number of its cause from 1.
    """
    cause_numbers = {
        entry.number: str(place) for place, cause in enumerate(causes, 1) for entry in cause.entries
    }
    lines = [
        (*map(printable, (*entry.cells, *entry.details)), cause_numbers.get(entry.number, ""))
        for entry in entries
    ]
    text = json.dumps(list(zip(*lines, strict=True)), ensure_ascii=False, separators=(",", ":"))
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


# ---- causes


def causes(entries: Sequence[Entry], defects: Defects) -> list[Cause]:
    """Return the causes of rows that do not hold, the gravest verdict first."""
    groups: dict[tuple[str, ...], list[Entry]] = {}
    for entry in entries:
        if entry.row.verdict in WITH_CAUSE:
            groups.setdefault((entry.row.verdict, *_cause_key(entry.row)), []).append(entry)
    return [_cause(tuple(group), defects) for group in groups.values()]


def _cause_key(row: Row) -> tuple[str, ...]:
    if row.defect:
        return (row.defect,)
    if row.verdict is Verdict.NOT_TESTED:
        return (row.engine,)
    if row.failure in ENGINE_FAILURES:
        return (row.engine, row.failure, row.note)
    return (row.engine, row.failure, row.case)


def _cause(group: tuple[Entry, ...], defects: Defects) -> Cause:
    row = group[0].row
    if row.defect:
        defect = defects.get(row.defect, {})
        sentences = [defect_sentence(defect) if defect else row.note]
        sentences += [f"Upstream: {defect['upstream']}."] if defect.get("upstream") else []
        commands = (f"dem-harness defect {row.defect}",) if defect.get("script") else ()
        return Cause(row.verdict, row.defect, tuple(filter(None, sentences)), group, commands)
    if row.verdict is Verdict.NOT_TESTED:
        reasons = Counter(entry.row.note or "no reason" for entry in group).most_common()
        return Cause(row.verdict, row.engine, (), group, reasons=tuple(reasons))
    title = f"{row.failure or row.verdict}: {row.case}, {row.engine}"
    sentences = [MEANINGS.get(row.failure, ""), group[0].outcome, row.note]
    distinct = tuple(dict.fromkeys(filter(None, sentences)))
    return Cause(row.verdict, title, distinct, group, (verify_command(row),))


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


# ---- matrices


def matrix(rows: pd.DataFrame, index: str, columns: str) -> pd.DataFrame:
    """Return how many rows have each verdict, in cells of :class:`Badge`, the gravest first."""
    cells = rows.groupby([index, columns], sort=True)["verdict"].agg(verdict_badges)
    return cells.unstack(columns).astype(object).where(lambda frame: frame.notna(), "")


def verdict_badges(verdicts: Iterable[str]) -> tuple[Badge, ...]:
    """Return how many of the verdicts there are of each, the gravest first."""
    numbers = Counter(verdicts)
    return tuple(Badge(f"{numbers[name]} {name}", name) for name in ORDER if name in numbers)


def divided_setups(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the setups that fail in some engine: the gravest verdict in each engine."""
    verdicts = rows.groupby(["case", "setup", "engine"], sort=True)["verdict"]
    worst = verdicts.agg(lambda cell: min(cell, key=ORDER.__getitem__))
    cells = worst.unstack("engine").fillna("")
    return cells[cells.isin(list(FAILING)).any(axis="columns")]
