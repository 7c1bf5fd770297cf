"""Rows as files: CSV, exact and sorted, so that ``git diff`` is the review; JUnit XML for CI."""

from __future__ import annotations

import csv
import io
import math
import re
from enum import StrEnum
from pathlib import Path
from xml.etree import ElementTree as Xml

import pandas as pd

from harness.errors import RequestError
from harness.results.rows import (
    COLUMNS,
    ENGINE_FAILURES,
    KEY,
    NUMBERS,
    Failure,
    Kind,
    Row,
    Verdict,
    check_keys,
    rows_of,
)

NEWLINE = "\r\n"  # of the CSV writer, which quotes cells with one of its characters
WORDS: dict[str, type[StrEnum]] = {"kind": Kind, "verdict": Verdict, "failure": Failure}


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
    try:
        return parsed_rows(file.read_bytes().decode("utf-8"))
    except OSError as error:
        raise RequestError(f"{file}: cannot be read ({error.strerror})") from None
    except (ValueError, csv.Error) as error:
        raise RequestError(f"{file}: {error}") from None


def parsed_rows(text: str) -> pd.DataFrame:
    """Return the rows of a CSV text. Raise ValueError, naming the line, where it is damaged."""
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


# ---- JUnit XML

NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
LOG_CHARACTERS = 2000  # of the end of a failed run's log


def junit(rows: pd.DataFrame, seconds: float = 0.0) -> str:
    """Return a suite for each kind of rows, with a test case for each row.

    A failed verdict is a ``failure``, a failed run of an engine an ``error``; rows without a
    verdict and known defects are ``skipped`` with the reason.
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
