"""Tables of rows as CSV: sorted by their key, numbers exact, so that ``git diff`` is the review."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import pandas as pd

from harness.errors import RequestError
from harness.results.rows import COLUMNS, KEY, NUMBERS, Failure, Kind, Verdict, check_keys

_WORDS = {"kind": Kind, "verdict": Verdict, "failure": Failure}
_END = "\r\n"  # the writer quotes cells that hold a character of it


class _Lines(list[str]):
    """The lines of a CSV writer."""

    write = list.append


def rows_text(rows: pd.DataFrame) -> str:
    """Return rows as CSV, sorted by their key.

    Numbers have the digits that read back the same bits; NaN is an empty cell. Halves of
    surrogate pairs, which no file holds, become question marks.
    """
    ordered = cell_texts(rows[list(COLUMNS)].sort_values(list(KEY), kind="stable"))
    lines = _Lines()
    writer = csv.writer(lines, lineterminator=_END)
    writer.writerow(COLUMNS)
    writer.writerows(ordered.itertuples(index=False, name=None))
    text = "".join(line.removesuffix(_END) + "\n" for line in lines)
    return text.encode("utf-8", "replace").decode("utf-8")


def cell_texts(rows: pd.DataFrame) -> pd.DataFrame:
    """Return a table of rows whose numbers are text that reads back the same bits."""
    return rows.assign(**{name: list(map(_number_text, rows[name])) for name in NUMBERS})


def write_rows(rows: pd.DataFrame, file: Path) -> None:
    """Write rows into a file; see :func:`rows_text`."""
    file.write_bytes(rows_text(rows).encode("utf-8"))


def read_rows(file: Path) -> pd.DataFrame:
    """Return the rows of a file. Raise RequestError, naming file and line, where it is damaged."""
    try:
        text = file.read_bytes().decode("utf-8")
        return parsed_rows(text)
    except OSError as error:
        raise RequestError(f"{file}: cannot be read ({error.strerror})") from None
    except (ValueError, csv.Error) as error:
        raise RequestError(f"{file}: {error}") from None


def parsed_rows(text: str) -> pd.DataFrame:
    """Return the rows of a CSV text. Raise ValueError, naming the line, where it is damaged."""
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    if tuple(next(reader, ())) != COLUMNS:
        raise ValueError(f"line 1: the columns must be {', '.join(COLUMNS)}")
    if not text.endswith("\n"):
        raise ValueError(f"line {text.count(chr(10)) + 1}: is cut")
    records = [_record(cells, reader.line_num) for cells in reader]
    frame = pd.DataFrame(records, columns=list(COLUMNS)).astype(dict.fromkeys(NUMBERS, "float64"))
    check_keys(frame)
    return frame


def _record(cells: list[str], line: int) -> list[str | float]:
    if len(cells) != len(COLUMNS):
        raise ValueError(f"line {line}: has {len(cells)} of {len(COLUMNS)} cells")
    record: list[str | float] = []
    for name, cell in zip(COLUMNS, cells, strict=True):
        try:
            record.append(_number(cell) if name in NUMBERS else str(_WORDS.get(name, str)(cell)))
        except ValueError:
            words = ", ".join(_WORDS[name]) if name in _WORDS else "a number"
            raise ValueError(f"line {line}: {name} = {cell!r}: must be {words}") from None
    return record


def _number(cell: str) -> float:
    return float(cell) if cell else math.nan


def _number_text(value: float) -> str:
    return "" if math.isnan(value) else repr(float(value))
