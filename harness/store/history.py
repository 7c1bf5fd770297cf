"""Keep the history of runs in one SQLite file, and query it for runs and what they measured.

It is safe under concurrent runs and kill -9: a run is inserted when it starts and completed when
it ends, and one that was killed, or still runs, has no end. Each change is one transaction of the
write-ahead log, so that readers and writers do not wait for each other.

``PRAGMA user_version`` holds the version of the tables. To change the schema, append the statements
that lead to the new one to :data:`MIGRATIONS`; those that are there stay as they are.
"""

from __future__ import annotations

import contextlib
import math
import shlex
import sqlite3
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path
from typing import Any, TypedDict

from harness.errors import RequestError
from harness.observables.row import Row, numbered

MIGRATIONS: tuple[tuple[str, ...], ...] = (
    (
        """CREATE TABLE run (
            id INTEGER PRIMARY KEY,
            started TEXT NOT NULL,
            finished TEXT,
            command TEXT NOT NULL,
            options TEXT NOT NULL,
            harness_version TEXT NOT NULL,
            harness_commit TEXT NOT NULL,
            engine TEXT NOT NULL DEFAULT '',
            engine_version TEXT NOT NULL DEFAULT '',
            how TEXT NOT NULL DEFAULT '',
            platform TEXT NOT NULL,
            status INTEGER,
            seconds REAL,
            cached INTEGER NOT NULL DEFAULT 0,
            folder TEXT NOT NULL DEFAULT '',
            note TEXT NOT NULL DEFAULT ''
        )""",
        """CREATE TABLE quantity (
            id INTEGER PRIMARY KEY,
            name TEXT NOT NULL,
            kind TEXT NOT NULL,
            unit TEXT NOT NULL,
            UNIQUE (name, kind, unit)
        )""",
        """CREATE TABLE measurement (
            run INTEGER NOT NULL REFERENCES run (id),
            quantity INTEGER NOT NULL REFERENCES quantity (id),
            value REAL,
            uncertainty REAL,
            expected REAL,
            tolerance REAL,
            verdict TEXT NOT NULL,
            PRIMARY KEY (run, quantity)
        ) WITHOUT ROWID""",
    ),
    (
        "ALTER TABLE measurement ADD COLUMN triage TEXT NOT NULL DEFAULT ''",
        "ALTER TABLE run ADD COLUMN judged INTEGER NOT NULL DEFAULT 0",
        "ALTER TABLE run ADD COLUMN failed INTEGER NOT NULL DEFAULT 0",
        """UPDATE run SET
            judged = (SELECT count(*) FROM measurement
                WHERE run = run.id AND verdict IN ('pass', 'fail')),
            failed = (SELECT count(*) FROM measurement WHERE run = run.id AND verdict = 'fail')""",
        "CREATE INDEX measurement_by_quantity ON measurement (quantity, run)",
        "CREATE INDEX run_by_start ON run (started)",
    ),
)
VERSION = len(MIGRATIONS)


def migrate(connection: sqlite3.Connection, name: str) -> None:
    """Bring a database to :data:`VERSION` in one transaction.

    Raise RequestError for one that a newer harness wrote.
    """
    if _version(connection) == VERSION:
        return
    connection.execute("BEGIN IMMEDIATE")
    try:
        version = _version(connection)  # another process may have been faster
        if version > VERSION:
            raise RequestError(
                f"history {name}: schema {version} is of a newer dem-harness (this one writes "
                f"{VERSION}); update it, or name another place in DEM_HARNESS_HOME"
            )
        for statements in MIGRATIONS[version:]:
            for statement in statements:
                connection.execute(statement)
        connection.execute(f"PRAGMA user_version = {VERSION}")
        connection.execute("COMMIT")
    except BaseException:
        connection.execute("ROLLBACK")
        raise


def _version(connection: sqlite3.Connection) -> int:
    return int(connection.execute("PRAGMA user_version").fetchone()[0])


BUSY_SECONDS = 30.0
"""How long one waits for another's write, which takes milliseconds."""


@dataclass(frozen=True)
class RunStart:
    """What is known of a run when it starts. ``options`` are the words after the command."""

    command: str
    options: Sequence[str]
    harness_version: str
    harness_commit: str
    platform: str


@dataclass(frozen=True)
class RunEnd:
    """What is known of a run when it ends; ``status`` is its exit status."""

    status: int
    seconds: float
    engine: str = ""
    engine_version: str = ""
    how: str = ""
    cached: bool = False
    folder: str = ""
    note: str = ""


MEASURED = "measured"
"""Kind of a row that was held against nothing."""


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
            busy = isinstance(error, sqlite3.OperationalError)
            if isinstance(error, sqlite3.DatabaseError) and not busy:
                raise RequestError(
                    f"history {path}: is not a database ({error}); move it away, or name another "
                    "place in DEM_HARNESS_HOME"
                ) from None
            raise

    def begin(self, start: RunStart) -> int:
        """Insert a run that starts now and return its number."""
        facts = {**vars(start), "options": shlex.join(start.options), "started": _now()}
        values = ", ".join(f":{name}" for name in facts)
        cursor = self._db.execute(f"INSERT INTO run ({', '.join(facts)}) VALUES ({values})", facts)
        assert cursor.lastrowid is not None
        return cursor.lastrowid

    def finish(self, run: int, end: RunEnd, rows: Iterable[Row] = ()) -> None:
        """Complete a run with how it ended and what it measured, all or nothing."""
        distinct = _distinct(rows)
        verdicts = Counter(row["verdict"] for row in distinct)
        facts = {
            **vars(end),
            "finished": _now(),
            "judged": verdicts["pass"] + verdicts["fail"],
            "failed": verdicts["fail"],
        }
        columns = ", ".join(f"{name} = :{name}" for name in facts)
        with self._transaction():
            self._db.execute(f"UPDATE run SET {columns} WHERE id = :run", {**facts, "run": run})
            for row in distinct:
                self._add({**row, "run": run})

    def rows(self, query: str, values: Iterable[Any] = ()) -> list[dict[str, Any]]:
        """Return the rows of a query, columns by name."""
        return list(self.each(query, values))

    def each(self, query: str, values: Iterable[Any] = ()) -> Iterator[dict[str, Any]]:
        """Yield the rows of a query, columns by name, each read when it is asked for.

        Raise RequestError for a value that is no text.
        """
        try:
            cursor = self._db.execute(query, tuple(values))
        except UnicodeEncodeError as error:
            raise RequestError(f"{error.object!r}: must be UTF-8 text") from None
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


def _distinct(rows: Iterable[Row]) -> list[dict[str, Any]]:
    unjudged = {"kind": MEASURED, "tolerance": math.nan, "verdict": "", "triage": ""}
    distinct = []
    for _, before, row in numbered(rows, lambda r: (r.name, getattr(r, "kind", MEASURED), r.unit)):
        name = f"{row.name} ({before + 1})" if before else row.name
        distinct.append({**unjudged, **vars(row), "name": name})
    return distinct


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


RUN_COLUMNS = (
    "run.id AS run, started, finished, command, options, engine, engine_version, how, status,"
    " seconds, cached, judged, failed, folder, harness_version, harness_commit, platform, note"
)
QUANTITY_COLUMNS = "name, kind, unit, value, uncertainty, expected, tolerance, verdict, triage"


class HistoryQuery(TypedDict, total=False):
    """What is asked of the history; None asks for nothing.

    ``quantity`` is a pattern as in file names (``*``, ``?``), ``engine_version``
    the beginning of a release, ``since`` a date or time (ISO 8601, local unless
    it has a zone), ``status`` an exit status or ``unfinished``. ``limit`` keeps
    the newest.
    """

    command: str | None
    engine: str | None
    engine_version: str | None
    quantity: str | None
    since: datetime | str | None
    verdict: str | None
    status: int | str | None
    limit: int | None


def runs(history: History, question: HistoryQuery) -> Iterator[dict[str, Any]]:
    """Yield the runs that fit, newest first, one row each.

    With a quantity or a verdict, those that have such a one.
    """
    where, inner = _of_run(question), _of_quantity(question)
    if inner:
        measured = "SELECT run FROM measurement JOIN quantity ON quantity.id = quantity"
        where[f"id IN ({measured}{_where(inner)})"] = [*chain(*inner.values())]
    query = f"SELECT {RUN_COLUMNS} FROM run{_where(where)} ORDER BY started DESC, id DESC"
    return history.each(query + _limit(question), chain(*where.values()))


def quantities(history: History, question: HistoryQuery) -> Iterator[dict[str, Any]]:
    """Yield the quantities that fit with the columns of their runs, newest first."""
    where = _of_run(question) | _of_quantity(question)
    query = (
        f"SELECT {RUN_COLUMNS}, {QUANTITY_COLUMNS} FROM measurement"
        " JOIN quantity ON quantity.id = quantity JOIN run ON run.id = measurement.run"
        f"{_where(where)} ORDER BY started DESC, run.id DESC, quantity.id"
    )
    return history.each(query + _limit(question), chain(*where.values()))


def names(history: History) -> list[str]:
    """Return the names of all quantities ever recorded, sorted."""
    return [row["name"] for row in history.rows("SELECT DISTINCT name FROM quantity ORDER BY name")]


Conditions = dict[str, list[Any]]
"""Conditions in SQL with the values of their question marks."""


def _of_run(question: HistoryQuery) -> Conditions:
    where: Conditions = {}
    for column in ("command", "engine"):
        if question.get(column) is not None:
            where[f"{column} = ?"] = [question[column]]
    if (version := question.get("engine_version")) is not None:
        where["substr(engine_version, 1, length(?)) = ?"] = [version] * 2
    if (since := question.get("since")) is not None:
        assert isinstance(since, datetime)
        where["started >= ?"] = [since.astimezone(UTC).isoformat(timespec="milliseconds")]
    if (status := question.get("status")) == "unfinished":
        where["status IS NULL"] = []
    elif status is not None:
        where["status = ?"] = [int(status)]
    return where


def _of_quantity(question: HistoryQuery) -> Conditions:
    values = {
        "quantity.name GLOB ?": question.get("quantity"),
        "verdict = ?": question.get("verdict"),
    }
    return {condition: [value] for condition, value in values.items() if value is not None}


def _where(conditions: Iterable[str]) -> str:
    text = " AND ".join(conditions)
    return f" WHERE {text}" if text else ""


def _limit(question: HistoryQuery) -> str:
    limit = question.get("limit")
    return "" if limit is None else f" LIMIT {int(limit)}"
