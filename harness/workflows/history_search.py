"""Ask which runs there were, and how a quantity went over date or release."""

from __future__ import annotations

import difflib
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from harness.errors import RequestError
from harness.files import history_place
from harness.report import plain
from harness.shown import Result
from harness.store import history as history_query
from harness.store.history import History, HistoryQuery

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.figures import Against
    from harness.shown.figure import Figure


UNFINISHED = "unfinished"
VERDICTS = ("pass", "fail", "known defect", "fixed", "not tested", "finding")
NEAR = 3
BLOCK = 1000
"""Rows of a CSV that are in memory at a time."""


@dataclass(frozen=True, repr=False)
class HistoryAnswer(Result):
    """What the history holds on a question: runs, or quantities of runs, newest first.

    Each row is a JSON-ready mapping; in a row of ``quantities`` the columns of
    the run come first.
    """

    file: Path
    runs: tuple[dict[str, Any], ...] = ()
    quantities: tuple[dict[str, Any], ...] | None = None

    @property
    def rows(self) -> tuple[dict[str, Any], ...]:
        """Return the quantities where they were asked for, else the runs."""
        return self.runs if self.quantities is None else self.quantities

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a table, as :func:`table` does."""
        return table(self.rows, quantities=self.quantities is not None)

    def summary(self) -> dict[str, str]:
        """Return how much was found, and where."""
        kind = "runs" if self.quantities is None else "measurements"
        return {kind: str(len(self.rows)), "history": str(self.file)}

    def draw(self, against: Against = "date") -> Figure:
        """Return the one quantity over date or release, or the rows that failed."""
        from harness.report.figures import recorded

        return recorded(self.to_frame(), against)

    def plot(self, against: Against = "date") -> Figure:
        """Return a figure of the one quantity over date or release, or of rows that failed."""
        from harness.shown.figure import house_style

        with house_style():
            return self.draw(against)


_TYPES = {
    "run": "int64",
    "started": "datetime64[us, UTC]",
    "finished": "datetime64[us, UTC]",
    **dict.fromkeys(("command", "options", "engine", "engine_version", "how"), "string"),
    "status": "Int64",
    "seconds": "float64",
    "cached": "bool",
    "judged": "int64",
    "failed": "int64",
    **dict.fromkeys(("folder", "harness_version", "harness_commit", "platform", "note"), "string"),
}

_QUANTITY_TYPES = {
    "name": "string",
    "kind": "string",
    "unit": "string",
    **dict.fromkeys(("value", "uncertainty", "expected", "tolerance"), "float64"),
    "verdict": "string",
    "triage": "string",
}


def table(rows: Iterable[Mapping[str, Any]], *, quantities: bool) -> pd.DataFrame:
    """Return rows as a table with one type a column, as Parquet wants it.

    Times are UTC; what is missing is NA or NaN.
    """
    import pandas as pd

    types = {**_TYPES, **_QUANTITY_TYPES} if quantities else _TYPES
    frame = pd.DataFrame(list(rows), columns=list(types))
    for name in ("started", "finished"):
        frame[name] = pd.to_datetime(frame[name], utc=True, format="ISO8601")
    return frame.astype(types)


def history(file: Path | None = None, **wanted: Unpack[HistoryQuery]) -> HistoryAnswer:
    """Return the recorded runs that fit, or with ``quantity`` those quantities of them.

    :class:`~harness.store.history.HistoryQuery` says what may be asked. Nothing recorded yet
    is an empty answer. Raise RequestError for what is not allowed, and for a quantity that was
    never recorded, with the names nearest to it.
    """
    with open_history(file, **wanted) as (path, rows):
        recorded = tuple(rows)
    if wanted.get("quantity") is None:
        return HistoryAnswer(path, recorded)
    return HistoryAnswer(path, quantities=recorded)


@contextmanager
def open_history(
    file: Path | None = None, **wanted: Unpack[HistoryQuery]
) -> Iterator[tuple[Path, Iterator[dict[str, Any]]]]:
    """Yield the file and the rows of :func:`history`, read one by one; raise as it does."""
    path, quantity = file or history_place().path, wanted.get("quantity")
    question: HistoryQuery = {
        **wanted,
        "since": _time(wanted.get("since")),
        "verdict": _one_of("verdict", wanted.get("verdict"), VERDICTS),
        "status": _status(wanted.get("status")),
        "limit": _count(wanted.get("limit")),
    }
    if not path.is_file():
        yield path, iter(())
        return
    try:
        with _opened(path) as opened:
            query = history_query.runs if quantity is None else history_query.quantities
            rows = map(_record, query(opened, question))
            first = next(rows, None)
            if first is None and quantity is not None:
                _check_known(quantity, history_query.names(opened))
            yield path, chain([] if first is None else [first], rows)
    except sqlite3.Error as error:
        raise RequestError(f"history {path}: cannot be read ({error})") from None


def write_csv(file: Path, **wanted: Unpack[HistoryQuery]) -> None:
    """Write the rows that :func:`history` returns into a file, a block at a time.

    There may be millions. Raise RequestError as it does, OSError where none can be written.
    """
    with open_history(**wanted) as (_, rows), file.open("w", encoding="utf-8") as stream:
        block = list(islice(rows, BLOCK))
        while block or not stream.tell():
            frame = table(block, quantities=wanted.get("quantity") is not None)
            plain.write_csv(frame, stream, header=not stream.tell())
            block = list(islice(rows, BLOCK))


def _opened(path: Path) -> History:
    try:
        return History(path)
    except OSError as error:
        raise RequestError(f"history {path}: cannot be read ({error})") from None


def _record(row: dict[str, Any]) -> dict[str, Any]:
    row["cached"] = bool(row["cached"])
    return row


def _check_known(pattern: str, names: list[str]) -> None:
    """Raise RequestError where no quantity of this name was ever recorded."""
    from fnmatch import fnmatchcase

    if any(fnmatchcase(name, pattern) for name in names) or not names:
        return
    words = pattern.strip("*").lower()
    near = [name for name in names if words and words in name.lower()]
    near += [n for n in difflib.get_close_matches(pattern, names, NEAR, 0.4) if n not in near]
    hint = "; near it: " + ", ".join(repr(name) for name in near[:NEAR]) if near else ""
    raise RequestError(f"--quantity {pattern!r}: no such quantity was recorded{hint}")


def _time(since: datetime | str | None) -> datetime | None:
    if since is None:
        return None
    try:
        time = datetime.fromisoformat(since) if isinstance(since, str) else since
    except ValueError:
        raise RequestError(
            f"--since {since!r}: must be a date or time as 2025-07-22 or 2025-07-22T14:30"
        ) from None
    try:
        return time.astimezone(UTC)
    except (OverflowError, ValueError):
        raise RequestError(
            f"--since {str(since)!r}: is beyond the years 1 to 9999 in UTC"
        ) from None


def _one_of(option: str, value: str | None, allowed: tuple[str, ...]) -> str | None:
    if value is not None and value not in allowed:
        raise RequestError(f"--{option} {value!r}: must be one of {', '.join(allowed)}")
    return value


def _status(status: int | str | None) -> str | None:
    if status is None or str(status) == UNFINISHED:
        return None if status is None else UNFINISHED
    if not str(status).isascii() or not str(status).isdigit() or int(status) > 255:
        raise RequestError(
            f"--status {status!r}: must be an exit status, 0 to 255, or {UNFINISHED}"
        )
    return str(status)


def _count(limit: int | None) -> int | None:
    if limit is not None and limit < 1:
        raise RequestError(f"--limit {limit}: must be at least 1")
    return limit
