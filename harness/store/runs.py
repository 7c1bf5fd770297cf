"""A run of ``verify`` and its folder.

    report.html, report.md    written by the room ``report``
    rows.csv                  the rows, exact and sorted by their key: ``git diff`` is the review
    run.json                  the request, the versions, when and where it ran
    junit.xml                 the rows for a CI service
    figures/, scripts/, logs/

A folder is filled under another name and renamed: it is complete or not there.
"""

from __future__ import annotations

import csv
import hashlib
import html
import io
import json
import math
import os
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cache, cached_property
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np
import pandas as pd

from harness.errors import RequestError
from harness.files import check_folder, safe_path, whole_folder
from harness.model.base import Parameters
from harness.results.compare import Change, Mask, compare, counts, counts_of_changes, regressions
from harness.results.rows import (
    COLUMNS,
    ENGINE_FAILURES,
    KEY,
    LEVELS,
    NUMBERS,
    Failure,
    Kind,
    Row,
    Verdict,
    check_keys,
    matches,
    rows_of,
    table,
)

FORMAT = 3  # of run.json and rows.csv; raised when a key or column changes its meaning
ROWS, META, JUNIT, LOGS, SCRIPTS = "rows.csv", "run.json", "junit.xml", "logs", "scripts"
SOLVERS = "harness"  # engine of the rows of this package's solvers: no test of a code
ABOUT_ENGINES = "engine"  # in place of a case: rows on an engine as a whole
UNJUDGED = (Verdict.NOT_TESTED, Verdict.FINDING, Verdict.RECORDED)
NOTEBOOK_COLUMNS = ("case", "setup", "quantity", "engine", "check", "value", "expected",
                    "tolerance", "unit", "verdict", "note")  # fmt: skip
NEWLINE = "\r\n"  # of the CSV writer, which quotes cells with one of its characters
WORDS: dict[str, type[StrEnum]] = {"kind": Kind, "verdict": Verdict, "failure": Failure}
NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
LOG_CHARACTERS = 2000  # of the end of a failed run's log


class Meta(Parameters):
    """The request of a run, and its versions.

    ``engines`` maps names to versions, empty for an engine that could not be run; ``left_out``
    are engines of this machine that were not requested. ``named`` are the cases and engines that
    were requested by name, and ``unqualified`` engines that failed a case which they must pass: no
    other was tested. ``started`` is ISO 8601 in UTC, ``seconds`` the wall time [s].
    """

    level: str
    cases: tuple[str, ...]
    engines: Mapping[str, str]
    left_out: tuple[str, ...] = ()
    named: tuple[str, ...] = ()
    unqualified: tuple[str, ...] = ()
    only: str = "*"
    strict: bool = False
    started: str = ""
    seconds: float = 0.0
    platform: str = ""
    harness_version: str = ""

    def of_engines_that_ran(self) -> Meta:
        """Return the request without the engines that ran no cases.

        They could not be run, or do not qualify.
        """
        versions = self.engines.items()
        ran = {name: v for name, v in versions if v and name not in self.unqualified}
        missing = tuple(name for name in self.engines if name not in ran)
        return self.replace(engines=ran, left_out=(*self.left_out, *missing))

    def covers(self, rows: pd.DataFrame) -> Mask:
        """Return which rows, by key and level, were requested, shape (rows,).

        The ``check`` of a row that compares two engines is or ends with the name of the second,
        as in "over Yade": such a row is covered where both were run. The word ``reference`` alone
        is a route.
        """
        checks = " " + rows["check"].str.lower()
        others = tuple(f" {name}" for name in self.left_out if name != "reference")
        levels = LEVELS[: LEVELS.index(self.level) + 1] if self.level in LEVELS else LEVELS
        inside = (
            rows["case"].isin(self.cases)
            & rows["engine"].isin(list(self.engines))
            & rows["level"].isin(["", *levels])
            & ~checks.str.endswith(others)
        )
        if self.only != "*":
            paths = rows["case"] + "/" + rows["setup"] + "/" + rows["quantity"]
            inside &= np.array([matches(path, self.only) for path in paths], bool)
        return inside.to_numpy(bool)


@dataclass(frozen=True, repr=False)
class Run:
    """The result of ``verify``.

    ``rows`` have the columns ``COLUMNS``; ``changes`` are those against the accepted runs, None
    where there are none. ``scripts`` are the exact inputs that ran, and ``logs`` the log of one
    finished run of each, by name.
    """

    rows: pd.DataFrame
    meta: Meta
    changes: pd.DataFrame | None = None
    scripts: Mapping[str, str] = field(default_factory=dict)
    logs: Mapping[str, str] = field(default_factory=dict)

    @property
    def status(self) -> int:
        """Return the exit status.

        3: an engine could not be run or died, or something is :attr:`untested`; 1: a verdict
        failed, a row is worse than accepted, or in a strict run a row was not tested; else 0.
        """
        if self.died or self.untested or not all(self.meta.engines.values()):
            return 3
        failing = [Verdict.FAIL, Verdict.NOT_TESTED] if self.meta.strict else [Verdict.FAIL]
        return int(self.rows["verdict"].isin(failing).any() or not self.regressions.empty)

    @property
    def died(self) -> int:
        """Return the number of rows in which an engine failed."""
        failed = self.rows["verdict"] == Verdict.FAIL
        return int((failed & self.rows["failure"].isin(ENGINE_FAILURES)).sum())

    @property
    def _judged(self) -> pd.DataFrame:
        """Return the rows with a verdict."""
        return self.rows[~self.rows["verdict"].isin(UNJUDGED)]

    @cached_property
    def untested(self) -> list[str]:
        """Return the cases that were named and have no judged row of an engine.

        The engines as well, where no row of any engine was tested.
        """
        judged = {*self._judged[self._judged["engine"] != SOLVERS]["case"]}
        cases = [name for name in self.meta.named if name not in judged]
        return cases + (self._idle_engines if {*self._tested} <= {SOLVERS} else [])

    @property
    def _tested(self) -> list[str]:
        """Return the engines with a row that was tested."""
        tested = self.rows["verdict"] != Verdict.NOT_TESTED
        return list(self.rows[tested & (self.rows["case"] != ABOUT_ENGINES)]["engine"].unique())

    @property
    def _idle_engines(self) -> list[str]:
        """Return the engines that ran, and whose rows all are not tested."""
        idle = {*self.rows["engine"]}.difference(self._tested)
        return [name for name, version in self.meta.engines.items() if version and name in idle]

    @cached_property
    def regressions(self) -> pd.DataFrame:
        """Return the changes against the accepted runs that fail this run."""
        return regressions(_no_changes() if self.changes is None else self.changes)

    @cached_property
    def headline(self) -> str:
        """Return the outcome in a few words, with known defects and what was not tested."""
        number = Counter(self.rows["verdict"])
        failed = self.rows[self.rows["verdict"] == Verdict.FAIL]["kind"].value_counts()
        failures = [f"{failed[kind]} {kind}" for kind in Kind if kind in failed.index]
        changed = self.regressions[self.regressions["verdict_after"] != Verdict.FAIL]
        moves = [f"{n} {change}" for change, n in counts_of_changes(changed).items()]
        parts = [f"Failed: {', '.join(failures)}"] if failures else []
        parts += [f"Against the accepted run: {', '.join(moves)}"] if moves else []
        parts += [f"Nothing was tested in {', '.join(self.untested)}"] if self.untested else []
        is_judged, idle = not self._judged.empty, self._idle_engines
        holding = "All verdicts hold" if is_judged else "Nothing was judged"
        incomplete = self.meta.strict and number[Verdict.NOT_TESTED]
        parts = parts or ["Not all was tested" if incomplete else holding]
        parts += [f"{name} could not be run" for name, v in self.meta.engines.items() if not v]
        parts += [f"{name} does not qualify" for name in self.meta.unqualified]
        parts += [f"{name} tested nothing" for name in idle if name not in self.untested]
        about = self.rows[self.rows["case"] == ABOUT_ENGINES].set_index("engine")
        digits = about["value"].dropna().items()
        parts += [f"{name} is held to its {number:g} digits" for name, number in digits]
        defects, untested = number[Verdict.KNOWN_DEFECT], number[Verdict.NOT_TESTED]
        parts += [f"{defects} known defect{'s' * (defects > 1)}"] if defects else []
        parts += [f"{untested} not tested"] if untested else []
        return "; ".join(parts)

    def against(self, accepted: pd.DataFrame) -> Run:
        """Return the run with its changes from accepted rows."""
        return replace(self, changes=self.changes_from_accepted(accepted))

    def changes_from_accepted(self, accepted: pd.DataFrame) -> pd.DataFrame:
        """Return what changed from accepted rows.

        Those that were not requested are no change, and those of an engine that could not be run or
        does not qualify neither: the headline names it once.
        """
        covers = self.meta.of_engines_that_ran().covers
        changes = compare(accepted, self.rows, covers_after=covers)
        is_here = changes["verdict_after"].notna()
        return changes[is_here | (changes["change"] != Change.NOT_COMPARABLE)]

    def changes_from(self, before: Run) -> pd.DataFrame:
        """Return what changed from another run to this one."""
        covers = {"covers_before": before.meta.covers, "covers_after": self.meta.covers}
        return compare(before.rows, self.rows, **covers)

    def to_frame(self) -> pd.DataFrame:
        """Return the rows."""
        return self.rows

    def to_json(self) -> dict[str, Any]:
        """Return ``status``, ``headline``, metadata, ``rows`` and ``regressions``, JSON-ready."""
        return {
            "status": self.status,
            "headline": self.headline,
            **self.meta.model_dump(),
            "rows": json_records(self.rows),
            "regressions": json_records(self.regressions),
        }

    def summary(self) -> dict[str, str]:
        """Return the outcome in a few lines, by name."""
        kinds = [f"{kind}: {_counted(row)}" for kind, row in counts(self.rows).iterrows()]
        lines = {"outcome": self.headline, "verdicts": "; ".join(kinds)}
        if self.changes is not None:
            lines["accepted run"] = _counted(counts_of_changes(self.changes))
        engines = [f"{name} {version or '-'}" for name, version in self.meta.engines.items()]
        lines["cases"] = f"{', '.join(self.meta.cases)}; {self.meta.level}"
        return {**lines, "engines": ", ".join(engines)}

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {text}" for name, text in self.summary().items())

    def _repr_html_(self) -> str:
        rows = self.rows[self.rows["verdict"] != Verdict.PASS][list(NOTEBOOK_COLUMNS)]
        return f"<p>{html.escape(self.headline)}</p>{rows.to_html(index=False, na_rep='')}"


@cache
def _no_changes() -> pd.DataFrame:
    return compare(table(()), table(()))


def write_run(run: Run, folder: Path, files: Mapping[str, str | bytes] | None = None) -> None:
    """Write a run into a new folder, complete or not at all.

    ``files`` are pages and figures by their path in the folder. Raise RequestError for a folder
    that is not empty or cannot be written.
    """
    check_folder(folder)
    names = {text: f"{hashlib.sha256(_bytes(text)).hexdigest()[:16]}.log" for text in run.rows.log}
    stored = run.rows.assign(log=[names[text] if text else "" for text in run.rows.log])
    record = {"format": FORMAT, "row_count": len(stored), **run.meta.model_dump()}
    contents: dict[str, str | bytes] = {
        ROWS: rows_text(stored),
        META: json.dumps(record, indent=1),
        JUNIT: junit(run.rows, run.meta.seconds, run.headline if run.status else ""),
        **{f"{LOGS}/{name}": text for text, name in names.items() if text},
        **{f"{LOGS}/{safe_path(name)}": text for name, text in run.logs.items()},
        **{f"{SCRIPTS}/{safe_path(name)}": text for name, text in run.scripts.items()},
        **(files or {}),
    }
    with whole_folder(folder) as aside:
        for name, content in contents.items():
            (aside / name).parent.mkdir(parents=True, exist_ok=True)
            (aside / name).write_bytes(_bytes(content))


def read_run(folder: Path) -> Run:
    """Return the run of a folder. Raise RequestError, naming folder and file, for anything else."""
    file = folder / META
    if not file.is_file():
        raise RequestError(f"{folder}: is not a run of dem-harness: it has no {META}")
    _check_parts(folder)
    text = _text_of(file)
    try:
        record = json.loads(text)
    except (ValueError, RecursionError) as error:  # also of digits or nesting
        raise RequestError(f"{file}: is cut or damaged ({error})") from None
    if not isinstance(record, dict) or "format" not in record:
        raise RequestError(f"{file}: is not the file of a run")
    if (version := record.pop("format")) != FORMAT:
        text = f"has format {version}, this version of dem-harness reads {FORMAT}"
        raise RequestError(f"{file}: {text}")
    count = record.pop("row_count", None)
    try:
        meta = Meta(**record)
    except RequestError as error:
        raise RequestError(f"{file}: {error}") from None
    rows = read_rows(folder / ROWS)
    if len(rows) != count:
        raise RequestError(f"{folder / ROWS}: has {len(rows)} of {count} rows: it is cut")
    logs = _texts_below(folder / LOGS)
    failed = {name: logs.pop(name, "") for name in set(rows["log"])}
    rows["log"] = rows["log"].map(failed)
    return Run(rows, meta, scripts=_texts_below(folder / SCRIPTS), logs=logs)


def json_records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the lines of a table, JSON-ready: None for numbers that are not finite."""
    records = frame.astype(object).to_dict("records")
    return [{str(name): _finite(value) for name, value in record.items()} for record in records]


def _check_parts(folder: Path) -> None:
    """Raise RequestError for a part that cannot be read, as a FIFO that nobody writes."""
    for path in folder.rglob("*"):
        mode = os.R_OK | os.X_OK if path.is_dir() else os.R_OK
        is_readable = (path.is_file() or path.is_dir()) and os.access(path, mode)
        if path.exists() and not is_readable:  # a link that leads nowhere is left out
            raise RequestError(f"{path}: must be a file or a folder that can be read")


def _texts_below(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): _text_of(path) for path in files}


def _text_of(file: Path) -> str:
    try:
        return file.read_bytes().decode("utf-8")
    except OSError as error:
        raise RequestError(f"{file}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise RequestError(f"{file}: is not UTF-8 text") from None


def _bytes(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode("utf-8", "replace")


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _counted(numbers: Mapping[Any, int] | pd.Series[Any]) -> str:
    return ", ".join(f"{number} {name}" for name, number in numbers.items() if number)


# ---- rows as CSV


class _Lines(list[str]):
    write = list.append


def rows_text(rows: pd.DataFrame) -> str:
    """Return rows as CSV, sorted by their key.

    Numbers have the digits that read back the same bits; NaN is an empty cell. Halves of
    surrogate pairs, which no file can have, become question marks.
    """
    lines = _Lines()
    writer = csv.writer(lines, lineterminator=NEWLINE)
    writer.writerow(COLUMNS)
    ordered = exact_texts(rows[list(COLUMNS)].sort_values(list(KEY), kind="stable"))
    writer.writerows(ordered.itertuples(index=False, name=None))
    text = "".join(line.removesuffix(NEWLINE) + "\n" for line in lines)
    return text.encode("utf-8", "replace").decode("utf-8")


def exact_texts(rows: pd.DataFrame) -> pd.DataFrame:
    """Return a table of rows whose numbers are text that reads back the same bits."""

    def text(value: float) -> str:
        return "" if math.isnan(value) else repr(float(value))

    return rows.assign(**{name: list(map(text, rows[name])) for name in NUMBERS})


def read_rows(file: Path) -> pd.DataFrame:
    """Return the rows of a file. Raise RequestError, naming the file, where it is damaged."""
    text = _text_of(file)
    try:
        return parsed_rows(text)
    except (ValueError, csv.Error) as error:
        raise RequestError(f"{file}: {error}") from None


def parsed_rows(text: str) -> pd.DataFrame:
    """Return the rows of a CSV text.

    Raise ValueError, naming the line, or the column and its value, where it is damaged.
    """
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    if tuple(next(reader, ())) != COLUMNS:
        raise ValueError(f"line 1: the columns must be {', '.join(COLUMNS)}")
    lines = []
    for cells in reader:
        if len(cells) != len(COLUMNS):
            raise ValueError(f"line {reader.line_num}: has {len(cells)} of {len(COLUMNS)} cells")
        lines.append(cells)
    if not text.endswith("\n"):
        raise ValueError(f"line {reader.line_num}: is cut")
    frame = pd.DataFrame(lines, columns=list(COLUMNS), dtype=object)
    for name in NUMBERS:
        frame[name] = _numbers(frame[name])
    for name, words in WORDS.items():
        for cell in frame.loc[~frame[name].isin(list(words)), name]:
            raise ValueError(f"{name} = {cell!r}: must be {', '.join(filter(None, words))}")
    check_keys(frame)
    return frame


def _numbers(column: pd.Series[str]) -> pd.Series[float]:
    """Return the numbers of cells, NaN for an empty one."""
    try:
        return column.replace("", "nan").astype(float)
    except ValueError as error:
        raise ValueError(f"{column.name}: {error}") from None


# ---- rows as JUnit XML


def junit(rows: pd.DataFrame, seconds: float = 0.0, failure: str = "") -> str:
    """Return a suite for each kind of rows, with a test case for each row.

    A failed verdict is a ``failure``, a failed run of an engine an ``error``; rows without a
    verdict and known defects are ``skipped`` with the reason. ``failure`` is the outcome of a run
    that fails: where no row does, it is a test case of its own.
    """
    root = Xml.Element("testsuites", name="dem-harness", time=f"{seconds:.3f}")
    every = rows_of(rows)
    for kind in Kind:
        cases = [_test_case(row) for row in every if row.kind is kind]
        tags = [outcome.tag for case in cases for outcome in case]
        if cases:
            numbers = {"tests": len(cases), "failures": tags.count("failure"),
                       "errors": tags.count("error"), "skipped": tags.count("skipped")}  # fmt: skip
            attributes = {name: str(number) for name, number in numbers.items()}
            suite = Xml.SubElement(root, "testsuite", {"name": f"dem-harness.{kind}", **attributes})
            suite.extend(cases)
    if failure and not [*root.iter("failure"), *root.iter("error")]:
        attributes = {"tests": "1", "failures": "1", "errors": "0", "skipped": "0"}
        suite = Xml.SubElement(root, "testsuite", {"name": "dem-harness.outcome", **attributes})
        case = Xml.SubElement(suite, "testcase", classname="dem-harness.outcome", name="outcome")
        Xml.SubElement(case, "failure", message=failure)
    Xml.indent(root)
    text = NOT_XML.sub("?", Xml.tostring(root, "unicode"))
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _test_case(row: Row) -> Xml.Element:
    case = Xml.Element("testcase", classname=f"dem-harness.{row.kind}", name=row.name)
    if row.verdict in (Verdict.PASS, Verdict.RECORDED, Verdict.FIXED):
        return case
    numbers = f"{row.value:.10g}, expected {row.expected:.10g} ± {row.tolerance:.2g} {row.unit}"
    message = f"{row.verdict}: {row.note or numbers}"
    if row.verdict is not Verdict.FAIL:
        Xml.SubElement(case, "skipped", message=message)
        return case
    tag = "error" if row.failure in ENGINE_FAILURES else "failure"
    outcome = Xml.SubElement(case, tag, message=message, type=str(row.failure))
    outcome.text = "\n".join(filter(None, (numbers, row.reason, row.log[-LOG_CHARACTERS:])))
    return case
