"""Create the tables of the history's database, and migrate those of earlier versions.

``PRAGMA user_version`` holds the version. To change the schema, append the
statements that lead to the new one; those that are there stay as they are.
"""

from __future__ import annotations

import sqlite3

from harness.errors import RequestError

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
        found = _version(connection)  # another process may have been faster
        if found > VERSION:
            raise RequestError(
                f"history {name}: schema {found} is of a newer dem-harness (this one writes "
                f"{VERSION}); update it, or name another place in DEM_HARNESS_HOME"
            )
        for statements in MIGRATIONS[found:]:
            for statement in statements:
                connection.execute(statement)
        connection.execute(f"PRAGMA user_version = {VERSION}")
        connection.execute("COMMIT")
    except BaseException:
        connection.execute("ROLLBACK")
        raise


def _version(connection: sqlite3.Connection) -> int:
    return int(connection.execute("PRAGMA user_version").fetchone()[0])
