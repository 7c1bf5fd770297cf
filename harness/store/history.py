"""Record runs in one SQLite file, safe under concurrent runs and kill -9.

A run is inserted when it starts and completed when it ends; one that was
killed, or still runs, has no end. Each change is one transaction of the
write-ahead log, so that readers and writers do not wait for each other.
"""

from __future__ import annotations

import contextlib
import math
import shlex
import sqlite3
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from harness.errors import RequestError
from harness.store.schema import migrate

BUSY_SECONDS = 30.0
"""How long one waits for another's write, which takes milliseconds."""


@dataclass(frozen=True)
class Start:
    """What is known of a run when it starts. ``options`` are the words after the command."""

    command: str
    options: Sequence[str]
    harness_version: str
    harness_commit: str
    platform: str


@dataclass(frozen=True)
class End:
    """What is known of a run when it ends; ``status`` is its exit status."""

    status: int
    seconds: float
    engine: str = ""
    engine_version: str = ""
    how: str = ""
    cached: bool = False
    folder: str = ""
    note: str = ""


@dataclass(frozen=True)
class Quantity:
    """One quantity of a run. What it does not have is NaN, or empty."""

    name: str
    kind: str
    unit: str
    value: float
    uncertainty: float = math.nan
    expected: float = math.nan
    tolerance: float = math.nan
    verdict: str = ""
    triage: str = ""


class History:
    """The database at a path, made if need be. Use it as a context manager.

    Raise RequestError for a file that is no history, or one of a newer
    dem-harness; OSError or sqlite3.OperationalError where none can be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        self._db = sqlite3.connect(path, timeout=BUSY_SECONDS, isolation_level=None)
        try:
            _write_ahead(self._db)
            self._db.execute("PRAGMA foreign_keys = ON")
            migrate(self._db, str(path))
        except BaseException as error:
            self._db.close()
            if _is_no_database(error):
                raise RequestError(
                    f"history {path}: is not a database ({error}); move it away, or name another "
                    "place in DEM_HARNESS_HOME"
                ) from None
            raise

    def begin(self, start: Start) -> int:
        """Insert a run that starts now and return its number."""
        facts = {**vars(start), "options": shlex.join(start.options), "started": _now()}
        cursor = self._db.execute(
            "INSERT INTO run (started, command, options, harness_version, harness_commit, platform)"
            " VALUES (:started, :command, :options, :harness_version, :harness_commit, :platform)",
            facts,
        )
        assert cursor.lastrowid is not None
        return cursor.lastrowid

    def finish(self, run: int, end: End, quantities: Iterable[Quantity] = ()) -> None:
        """Complete a run with how it ended and its quantities, all or nothing."""
        found = _distinct(quantities)
        verdicts = Counter(one.verdict for one in found)
        facts = {
            **vars(end),
            "finished": _now(),
            "judged": verdicts["pass"] + verdicts["fail"],
            "failed": verdicts["fail"],
        }
        columns = ", ".join(f"{name} = :{name}" for name in facts)
        with self._transaction():
            self._db.execute(f"UPDATE run SET {columns} WHERE id = :run", {**facts, "run": run})
            for one in found:
                self._add({**vars(one), "run": run})

    def rows(self, query: str, values: Iterable[Any] = ()) -> list[dict[str, Any]]:
        """Return the rows of a query, columns by name."""
        return list(self.each(query, values))

    def each(self, query: str, values: Iterable[Any] = ()) -> Iterator[dict[str, Any]]:
        """Yield the rows of a query, columns by name, each read when it is asked for."""
        cursor = self._db.execute(query, tuple(values))
        names = [column[0] for column in cursor.description or ()]
        for row in cursor:
            yield dict(zip(names, row, strict=True))

    def close(self) -> None:
        """Close the database."""
        self._db.close()

    def __enter__(self) -> History:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _add(self, facts: dict[str, Any]) -> None:
        self._db.execute(
            "INSERT OR IGNORE INTO quantity (name, kind, unit) VALUES (:name, :kind, :unit)", facts
        )
        self._db.execute(
            "INSERT INTO measurement (run, quantity, value, uncertainty, expected, tolerance,"
            " verdict, triage) SELECT :run, id, :value, :uncertainty, :expected, :tolerance,"
            " :verdict, :triage FROM quantity"
            " WHERE name = :name AND kind = :kind AND unit = :unit",
            facts,
        )

    @contextlib.contextmanager
    def _transaction(self) -> Iterator[None]:
        """Hold the right to write from the start: to wait for it later could fail halfway."""
        self._db.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            self._db.execute("ROLLBACK")
            raise
        self._db.execute("COMMIT")


def _write_ahead(db: sqlite3.Connection) -> None:
    """Switch to the write-ahead log; SQLite does not itself wait for others to do the same."""
    deadline = time.monotonic() + BUSY_SECONDS
    while True:
        try:
            db.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > deadline:
                raise
            time.sleep(0.01)
        else:
            return


def _is_no_database(error: BaseException) -> bool:
    return isinstance(error, sqlite3.DatabaseError) and not isinstance(
        error, sqlite3.OperationalError
    )


def _distinct(quantities: Iterable[Quantity]) -> list[Quantity]:
    """Return the quantities, a name that comes again with its number: none replaces another."""
    seen: Counter[tuple[str, str, str]] = Counter()
    found = []
    for one in quantities:
        key = (one.name, one.kind, one.unit)
        seen[key] += 1
        again = seen[key] > 1
        found.append(replace(one, name=f"{one.name} ({seen[key]})") if again else one)
    return found


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
