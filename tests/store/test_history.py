import math
import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing

import pytest

from harness.comparison.verdicts import Kind, Tolerance, judge
from harness.errors import RequestError
from harness.observables.row import Row
from harness.store import history as history_query
from harness.store.history import MIGRATIONS, VERSION, History, HistoryQuery, RunEnd, RunStart

KEPT = (
    "name",
    "kind",
    "unit",
    "value",
    "uncertainty",
    "expected",
    "tolerance",
    "verdict",
    "triage",
)
START = RunStart("verify", ["--quick"], "0.1.0", "abc", "Linux")
END = RunEnd(1, 2.5, "lammps", "22 Jul 2025 - Update 4", "in-process", folder="/runs/1")
WIDTH = Tolerance("deg", 3e-4, 0.0, "that of a test")
ANGLE = judge("angle", Kind.ANALYTIC, 10.2, 10.3, WIDTH, uncertainty=1e-4, triage="late")
RATIO = Row("ratio", 0.6, math.nan, "")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "below" / "history.sqlite"


def integrity(path):
    with closing(sqlite3.connect(path)) as database:
        return database.execute("PRAGMA integrity_check").fetchall()


def test_a_run_is_there_when_it_starts_and_complete_when_it_ends(path):
    with History(path) as history:
        number = history.begin(START)
        (row,) = history_query.runs(history, HistoryQuery())
        assert (row["status"], row["finished"], row["command"]) == (None, None, "verify")
        history.finish(number, END, [ANGLE, RATIO])
        (row,) = history_query.runs(history, HistoryQuery())
    assert row["status"] == 1
    assert (row["judged"], row["failed"]) == (1, 1)
    assert row["finished"] >= row["started"]
    assert (row["engine_version"], row["folder"]) == (END.engine_version, "/runs/1")


def test_quantities_come_back_as_they_were_and_what_is_missing_is_null(path):
    with History(path) as history:
        history.finish(history.begin(START), END, [ANGLE, RATIO])
        angle, ratio = history_query.quantities(history, HistoryQuery(quantity="*"))
    assert [angle[key] for key in KEPT] == [getattr(ANGLE, key) for key in KEPT]
    assert ratio["kind"] == "measured"
    assert (ratio["value"], ratio["uncertainty"], ratio["expected"]) == (0.6, None, None)
    assert math.isnan(RATIO.uncertainty)


def test_a_name_that_comes_twice_keeps_both(path):
    with History(path) as history:
        history.finish(history.begin(START), END, [RATIO, RATIO, ANGLE])
        rows = list(history_query.quantities(history, HistoryQuery(quantity="ratio*")))
    assert [row["name"] for row in rows] == ["ratio", "ratio (2)"]


def test_the_end_of_a_run_is_all_or_nothing(path):
    bad = Row("bad", object(), math.nan, "")
    with History(path) as history:
        number = history.begin(START)
        with pytest.raises(sqlite3.Error):
            history.finish(number, END, [ANGLE, bad])
        (row,) = history_query.runs(history, HistoryQuery())
        assert row["status"] is None
        assert list(history_query.quantities(history, HistoryQuery(quantity="*"))) == []
        history.finish(number, END, [ANGLE])
        assert len(list(history_query.quantities(history, HistoryQuery(quantity="*")))) == 1


def _version_1(path):
    """Write a history as version 1 of the schema had it, with a run in it."""
    path.parent.mkdir(parents=True)
    with closing(sqlite3.connect(path)) as database:
        for statement in MIGRATIONS[0]:
            database.execute(statement)
        database.executescript(
            """
            INSERT INTO run VALUES (1, '2026-01-01T00:00:00.000+00:00', NULL, 'verify',
                '--quick', '0.1.0', '', 'lammps', '2 Aug 2023', 'in-process', 'Linux', 1, 2.0, 0,
                '', '');
            INSERT INTO quantity VALUES (1, 'angle', 'analytic', 'deg');
            INSERT INTO quantity VALUES (2, 'ratio', 'analytic', '');
            INSERT INTO measurement VALUES (1, 1, 10.2, 1e-4, 10.3, 3e-4, 'fail');
            INSERT INTO measurement VALUES (1, 2, 0.6, NULL, 0.6, 1e-5, 'pass');
            PRAGMA user_version = 1;
            """
        )


def test_a_history_of_version_1_is_brought_up_to_date_with_its_runs(path):
    _version_1(path)
    with History(path) as history:
        (row,) = history_query.runs(history, HistoryQuery())
        assert (row["judged"], row["failed"], row["engine_version"]) == (2, 1, "2 Aug 2023")
        angle, ratio = history_query.quantities(history, HistoryQuery(quantity="*"))
        assert (angle["value"], angle["triage"], ratio["verdict"]) == (10.2, "", "pass")
        history.finish(history.begin(START), END, [ANGLE])
        assert history.rows("PRAGMA user_version") == [{"user_version": VERSION}]
    assert integrity(path) == [("ok",)]


def test_the_same_schema_is_reached_from_version_1_and_from_nothing(path, tmp_path):
    _version_1(path)
    schemas = []
    for file in (path, tmp_path / "new.sqlite"):
        with History(file) as history:
            rows = history.rows("SELECT type, name, sql FROM sqlite_master ORDER BY name")
            schemas.append(rows)
    assert schemas[0] == schemas[1]


def test_a_history_of_a_newer_harness_is_refused_and_left_alone(path):
    History(path).close()
    with closing(sqlite3.connect(path)) as database:
        database.execute(f"PRAGMA user_version = {VERSION + 1}")
    with pytest.raises(RequestError, match=rf"schema {VERSION + 1} is of a newer dem-harness"):
        History(path)
    with closing(sqlite3.connect(path)) as database:
        assert database.execute("PRAGMA user_version").fetchone() == (VERSION + 1,)


def test_a_file_that_is_no_database_is_named_and_left_alone(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("notes on the history of granular flow\n" * 50)
    with pytest.raises(RequestError, match=r"notes\.txt: is not a database"):
        History(path)
    assert path.read_text().startswith("notes on")


WRITER = """
import sys
from pathlib import Path
from harness.observables.row import Row
from harness.store.history import History, RunEnd, RunStart
for n in range(int(sys.argv[2])):
    with History(Path(sys.argv[1])) as history:
        run = history.begin(RunStart("tower", [str(n)], "0", "", ""))
        history.finish(run, RunEnd(0, 1.0), [Row(f"q{i}", n, 0.0, "") for i in range(20)])
    print(n, flush=True)
"""


def _writer(path, runs):
    return subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path), str(runs)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_processes_that_make_and_write_one_history_at_once_lose_nothing(path):
    writers = [_writer(path, 10) for _ in range(6)]
    for writer in writers:
        _, said = writer.communicate(timeout=120)
        assert writer.returncode == 0, said
    with History(path) as history:
        assert len(list(history_query.runs(history, HistoryQuery(status="0")))) == 60
        assert len(list(history_query.quantities(history, HistoryQuery(quantity="*")))) == 60 * 20
    assert integrity(path) == [("ok",)]


def test_writers_killed_at_random_moments_lose_no_run_that_they_reported(path):
    reported = 0
    for delay in (0.0, 0.01, 0.02, 0.03, 0.05, 0.08):
        writer = _writer(path, 10_000)
        assert writer.stdout.readline() == "0\n"
        time.sleep(delay)
        os.kill(writer.pid, signal.SIGKILL)
        rest, _ = writer.communicate()
        reported += 1 + rest.count("\n")
    assert integrity(path) == [("ok",)]
    with History(path) as history:
        finished = list(history_query.runs(history, HistoryQuery(status="0")))
        assert len(finished) >= reported
        rows = list(history_query.quantities(history, HistoryQuery(quantity="*")))
        assert len(rows) == 20 * len(finished)


def test_a_value_that_is_no_text_is_refused(tmp_path):
    with History(tmp_path / "h.sqlite") as history, pytest.raises(RequestError, match="UTF-8"):
        history.rows("SELECT id FROM run WHERE engine = ?", ["\udcff"])
