"""The report of a run: one HTML page that works offline, one Markdown page, and the figures.

``report_files(run, sections)`` returns them by their path in the folder of the run, which
``harness.store.runs.write_run`` writes. The HTML page has all rows as packed JSON, which its script
turns into a table; without a script it shows those to look at first.

A known defect is one cause, whatever rows it breaks. Failures without a known cause are grouped by
case, engine and class; rows that were not tested are grouped by engine, with the reasons.
"""

from __future__ import annotations

import base64
import gzip
import json
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from shlex import quote
from typing import TYPE_CHECKING, Any

import pandas as pd

from harness.files import safe_path
from harness.report.content import SHORT, Badge, Drawing, Section, number, printable, value_text
from harness.report.render import ORDER, html_page, markdown_page, matrix, template
from harness.results.compare import counts, counts_of_changes
from harness.results.rows import (
    ENGINE_FAILURES,
    KEY,
    Failure,
    Kind,
    Row,
    Verdict,
    defects_of,
    row_name,
    rows_of,
)

if TYPE_CHECKING:
    from harness.store.runs import Run

Defects = Mapping[str, Mapping[str, Any]]  # tables of inputs/known-defects.toml, by name
TITLE = "DEM verification"
MARKDOWN_LIMIT = 60_000  # characters: a comment on a pull request holds 65,536
MOST_FINDINGS = 20  # shown without unfolding
FEWEST_ROWS, MOST_ROWS = 25, 100  # of the table without a script
MOST_FILES = 60  # scripts and logs that the page names
EMBEDDED = 60_000  # characters of scripts and logs in the page; the others are links
LOG_TAIL = 3_000  # characters of a log
COLUMNS = ("verdict", "row", "kind", "engine", "value", "expected", "unit", "difference",
           "uncertainty", "tolerance", "used")  # fmt: skip
FAILING = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED)
WITH_CAUSE = (*FAILING, Verdict.NOT_TESTED)
KIND_TITLES = {
    Kind.ANALYTIC: "analytic: against a closed form",
    Kind.CROSS_CODE: "cross-code: against the reference, a solver or another code",
    Kind.FINDING: "finding: a difference between models, not judged",
    Kind.RECORDED: "recorded: against the accepted run alone",
}
HTML, MARKDOWN = "report.html.j2", "report.md.j2"
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
}


def report_files(
    run: Run,
    sections: Sequence[Section],
    *,
    defects: Defects | None = None,
    png: bool = False,
    title: str = TITLE,
    headline: str = "",
) -> dict[str, str | bytes]:
    """Return the files of a report by their path: report.html, report.md and figures.

    ``defects`` are the known defects by name, as in inputs/known-defects.toml, for their causes.
    With ``png`` figures are PNG, too. An error of a figure is text in its place. ``headline`` is
    the first sentence, that of the run unless given.
    """
    parts = list(_drawn_parts(sections, png=png))
    values = _values(run, parts, defects or {})
    values |= {"title": title, "headline": headline or run.headline}
    files: dict[str, str | bytes] = {
        "report.html": html_page(HTML, **values),
        "report.md": _shortened(markdown_page(MARKDOWN, **values)),
    }
    for picture in filter(None, (p for part in parts for p in (part.first, *part.pictures))):
        name = f"figures/{picture.drawing.name}"
        files |= {f"{name}.svg": picture.svg} if picture.svg else {}
        files |= {f"{name}.png": picture.png} if picture.png else {}
    return files


def load(*, figures: bool) -> None:
    """Load what the first report needs: templates, matplotlib with its fonts; a second or two."""
    if figures:
        from harness.report.figures import panels

        draw(Drawing("empty", "", "", partial(panels, 1, 1)))
    template(HTML, html=True)
    template(MARKDOWN, html=False)


def _shortened(text: str) -> str:
    """Return Markdown cut between two blocks below its limit, with a last sentence."""
    end = "\n\nThe rest is in report.html.\n"
    if len(text) <= MARKDOWN_LIMIT:
        return text
    return text[: MARKDOWN_LIMIT - len(end)].rpartition("\n\n")[0] + end


def _values(run: Run, parts: Sequence[Part], defects: Defects) -> dict[str, Any]:
    """Return the values of both templates by name."""
    entries = entries_of(run.rows)
    causes_ = causes(entries, defects)
    numbers = Counter(str(entry.row.verdict) for entry in entries)
    present = [verdict for verdict in ORDER if verdict in numbers]
    attention = sum(numbers[verdict] for verdict in WITH_CAUSE)
    versions = ", ".join(f"{name} {version}".strip() for name, version in run.meta.engines.items())
    started = run.meta.started[:16].replace("T", " ")
    times = f"{started} UTC · {run.meta.level} · {run.meta.seconds:.0f} s"
    undecided = numbers[Verdict.KNOWN_DEFECT] or numbers[Verdict.NOT_TESTED]
    return {
        "who": f"{versions or 'no engine'} · {times}",
        # green only where every row was judged and none fails
        "outcome": "fail" if run.status else "partial" if undecided else "",
        "counts": [f"{numbers[verdict]} {verdict}" for verdict in present],
        "openings": [part for part in parts if part.section.opening],
        "verdicts": _verdict_table(run.rows),
        "causes": causes_,
        **_changes(run),
        "findings": [entry for entry in entries if entry.row.verdict is Verdict.FINDING],
        "most": MOST_FINDINGS,
        "count": len(entries),
        "first_rows": entries[: min(max(attention, FEWEST_ROWS), MOST_ROWS)],
        "packed": _packed(entries, causes_),
        "columns": COLUMNS,
        "choices": {
            "verdict": present,
            "kind": [kind for kind in map(str, Kind) if (run.rows["kind"] == kind).any()],
            "engine": sorted(set(run.rows["engine"])),
        },
        "matrices": _matrices(run.rows),
        "parts": parts,
        "files": _script_files(run),
        "facts": _facts(run),
    }


# ---- sections with their figures


@dataclass(frozen=True)
class Picture:
    """A drawn figure: SVG, PNG where it was requested, or the error of its function."""

    drawing: Drawing
    svg: str = field(default="", repr=False)
    png: bytes = field(default=b"", repr=False)
    error: str = ""

    @property
    def size(self) -> tuple[float, float]:
        """Return width and height [pt]."""
        width, height = re.findall(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', self.svg)[0]
        return float(width), float(height)


@dataclass(frozen=True)
class Part:
    """A section with its id in the page and its figures: that of the opening, and the others."""

    id: str
    section: Section
    first: Picture | None
    pictures: Sequence[Picture]

    @property
    def has_body(self) -> bool:
        """Return whether the section has more than its opening."""
        return bool(self.section.text or self.section.tables or self.pictures)


def draw(drawing: Drawing, *, png: bool = False) -> Picture:
    """Return a drawn figure, or the error of its function."""
    from harness.report.figures import figure_files  # slow to load: matplotlib

    try:
        return Picture(drawing, *figure_files(drawing.draw, png=png))
    except Exception as error:  # the function may be a plug-in's
        return Picture(drawing, error=" ".join(f"{type(error).__name__}: {error}".split()))


def _drawn_parts(sections: Sequence[Section], *, png: bool) -> Iterator[Part]:
    """Yield sections with their figures drawn; names of figures are made unique file names."""
    numbers = Counter[str]()

    def drawn(drawing: Drawing) -> Picture:
        return draw(replace(drawing, name=_file_name(drawing, numbers)), png=png)

    for place, section in enumerate(sections, 1):
        figure = section.opening.figure if section.opening else None
        first = drawn(figure) if figure else None
        yield Part(f"section-{place}", section, first, [drawn(d) for d in section.drawings])


def _file_name(drawing: Drawing, numbers: Counter[str]) -> str:
    name = re.sub(r"[^A-Za-z0-9._+-]+", "-", drawing.name).strip(".-") or "figure"
    numbers[name] += 1
    return name if numbers[name] == 1 else f"{name}-{numbers[name]}"


# ---- rows


@dataclass(frozen=True)
class Entry:
    """A row with its number in the order of reading, from 1, and its texts."""

    row: Row
    number: int

    @property
    def used(self) -> str:
        """Return the difference as a part of the tolerance, empty without a tolerance."""
        difference, tolerance = abs(self.row.difference), self.row.tolerance
        if tolerance > 0.0:
            used = difference / tolerance
        else:
            used = 0.0 if difference == tolerance == 0.0 else math.nan
        if math.isnan(used):
            return ""
        return f"{100.0 * used:.3g} %" if used < 100.0 else "> 1e4 %"

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
                self.used)  # fmt: skip

    @property
    def details(self) -> tuple[str, ...]:
        """Return class of failure, note, reason of the tolerance and log, empty where missing."""
        row = self.row
        failure = f"{row.failure}. {MEANINGS[row.failure]}" if row.failure else ""
        reason = f"Tolerance: {row.reason}" if row.reason else ""
        return failure, row.note, reason, row.log[-LOG_TAIL:]


def entries_of(rows: pd.DataFrame) -> list[Entry]:
    """Return the rows of a run in the order of reading: the gravest verdict first, then by kind."""
    kinds = {str(kind): place for place, kind in enumerate(Kind)}
    ordered = sorted(rows_of(rows), key=lambda row: (ORDER[row.verdict], kinds[row.kind]))
    return [Entry(row, place) for place, row in enumerate(ordered, 1)]


def _packed(entries: Sequence[Entry], causes: Sequence[Cause]) -> str:
    """Return all rows as base64 of gzipped JSON, a list of texts for each column.

    The columns are :data:`COLUMNS`, the details of an entry, and the number of its cause from 1.
    """
    places = {
        entry.number: str(place) for place, cause in enumerate(causes, 1) for entry in cause.entries
    }
    lines = [
        (*map(printable, (*entry.cells, *entry.details)), places.get(entry.number, ""))
        for entry in entries
    ]
    text = json.dumps(list(zip(*lines, strict=True)), ensure_ascii=False, separators=(",", ":"))
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


# ---- causes


@dataclass(frozen=True)
class Cause:
    """Rows of one verdict and one cause, with its explanation and the command that repeats it.

    ``reasons`` are those of rows that were not tested, with their numbers.
    """

    verdict: Verdict
    title: str
    sentences: Sequence[str]
    entries: Sequence[Entry]
    command: str = ""
    reasons: Sequence[tuple[str, int]] = ()


def causes(entries: Sequence[Entry], defects: Defects) -> list[Cause]:
    """Return the causes of rows that do not hold, the gravest verdict first."""
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
        tables = {name: defects[name] for name in defects_of(row.defect) if name in defects}
        sentences = [" ".join(map(defect_sentence, tables.values())) or row.note]
        for defect in tables.values():
            sentences += [f"Upstream: {defect['upstream']}."] if defect.get("upstream") else []
            if defect.get("undetermined"):
                sentences.append(
                    f"Not computed, so that other faults may hide here: {defect['undetermined']}."
                )
        scripts = (name for name, defect in tables.items() if defect.get("script"))
        command = "\n".join(f"dem-harness defect {name}" for name in scripts)
        return Cause(row.verdict, row.defect, [*filter(None, sentences)], group, command)
    if row.verdict is Verdict.NOT_TESTED:
        reasons = Counter(entry.row.note or "no reason" for entry in group).most_common()
        return Cause(row.verdict, row.engine, (), group, reasons=reasons)
    title = f"{row.failure or row.verdict}: {row.case}, {row.engine}"
    sentences = [MEANINGS.get(row.failure, ""), group[0].outcome, row.note]
    distinct = list(dict.fromkeys(filter(None, sentences)))
    return Cause(row.verdict, title, distinct, group, _verify_command(row))


def defect_releases(defect: Mapping[str, Any]) -> str:
    """Return the first and the last release that is known to have a defect, empty for all."""
    words = (("from", "since"), ("to", "until"))
    return " ".join(f"{word} {defect[key]}" for word, key in words if defect.get(key))


def defect_sentence(defect: Mapping[str, Any]) -> str:
    """Return the cause of a known defect with its releases."""
    releases = defect_releases(defect)
    cause = f"{defect['cause'][:1].upper()}{defect['cause'][1:]}."
    return f"{cause} Releases {releases}." if releases else cause


def _verify_command(row: Row) -> str:
    path = quote("/".join((row.case, row.setup, row.quantity)))
    engines = "" if row.engine == "harness" else f" --engines {quote(row.engine)}"
    return f"dem-harness verify{' --full' * (row.level == 'full')} --only {path}{engines}"


# ---- tables and facts


def _verdict_table(rows: pd.DataFrame) -> pd.DataFrame:
    """Return how many rows of each kind have each verdict; kinds are never added up."""
    table = counts(rows)
    cells = {
        verdict: [Badge(str(n), str(verdict)) if n else "" for n in table[verdict]]
        for verdict in table.columns
    }
    return pd.DataFrame({"kind": [KIND_TITLES[Kind(kind)] for kind in table.index], **cells})


def _changes(run: Run) -> dict[str, Any]:
    """Return the changes against the accepted run: their numbers, and those that fail the run."""
    if run.changes is None:
        return {"changed": None, "regressions": None}
    numbers = [f"{count} {change}" for change, count in counts_of_changes(run.changes).items()]
    frame = run.regressions.fillna(dict.fromkeys(KEY, ""))
    verdicts = zip(frame["verdict_before"], frame["verdict_after"], strict=True)
    table = pd.DataFrame({
        "change": list(frame["change"]),
        "row": [row_name(*key) for key in frame[list(KEY)].itertuples(index=False)],
        "accepted": list(frame["value_before"]),
        "now": list(frame["value_after"]),
        "in tolerances": [number(moved, SHORT) for moved in frame["in_tolerances"]],
        "verdict": [[v for v in dict.fromkeys(pair) if isinstance(v, str)] for pair in verdicts],
    })  # fmt: skip
    return {
        "changed": ", ".join(numbers) or "no row in common",
        "regressions": None if table.empty else table,
    }


def _matrices(rows: pd.DataFrame) -> list[tuple[str, str, pd.DataFrame]]:
    """Return title, caption and table of cases by engines, and of setups that fail in some."""
    if rows["engine"].nunique() < 2 or rows["case"].nunique() < 2:
        return []
    caption = "Setups that fail or show a known defect: the gravest verdict in each engine."
    tables = [
        ("Matrix", "Rows of each case by engine and verdict.", matrix(rows, "case", "engine")),
        ("Setups", caption, divided_setups(rows)),
    ]
    return [table for table in tables if not table[2].empty]


def divided_setups(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the setups that fail in some engine: the gravest verdict in each engine."""
    verdicts = rows.groupby(["case", "setup", "engine"], sort=True)["verdict"]
    worst = verdicts.agg(lambda cell: min(cell, key=ORDER.__getitem__))
    cells = worst.unstack("engine").fillna("")
    return cells[cells.isin(list(FAILING)).any(axis="columns")]


def _script_files(run: Run) -> list[tuple[str, str, str]]:
    """Return name, address and text of scripts and logs; no text beyond the size of a page."""
    scripts = [(name, f"scripts/{safe_path(name)}", text) for name, text in run.scripts.items()]
    logs = [(f"log: {n}", f"logs/{safe_path(n)}", t[-LOG_TAIL:]) for n, t in run.logs.items()]
    files, size = [], 0
    for title, address, text in [*scripts[:MOST_FILES], *logs[:MOST_FILES]]:
        size += len(text)
        files.append((title, address, text if size <= EMBEDDED else ""))
    if len(scripts) > MOST_FILES:
        files.append((f"all {len(scripts)} scripts", "scripts/", ""))
    return files


def _facts(run: Run) -> list[tuple[str, str]]:
    meta = run.meta
    engines = {f"engine {name}": v or "could not be run" for name, v in meta.engines.items()}
    facts = {
        "started": f"{meta.started} (UTC)",
        "duration": f"{meta.seconds:.1f} s",
        "level": meta.level,
        "cases": ", ".join(meta.cases),
        "only": "" if meta.only == "*" else meta.only,
        **engines,
        "dem-harness": meta.harness_version,
        "platform": meta.platform,
    }
    return [(name, text) for name, text in facts.items() if text]
