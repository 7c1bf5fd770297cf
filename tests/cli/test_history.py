import csv
import json
import math
import os
import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace

import pytest

from harness.comparison.verdicts import Kind, Tolerance, judge
from harness.observables.row import Row
from harness.store.history import History, RunEnd, RunStart
from harness.workflows.history_search import VERDICTS

WIDTH = Tolerance("deg", 3e-4, 0.0, "that of a test")


@pytest.fixture
def file(home):
    """Two verifications of two releases, a cached one, and one that was killed."""
    path = home / "history.sqlite"
    with History(path) as history:
        for n, release in enumerate(("2 Aug 2023", "22 Jul 2025 - Update 4", "22 Jul 2025")):
            run = history.begin(RunStart("verify", ["--quick"], "0.1.0", "", "Linux"))
            angle = judge("angle", Kind.ANALYTIC, 10.2, 10.2, WIDTH, uncertainty=1e-4)
            angle = replace(angle, value=10.2 + n)
            other = Row("ratio", 0.6, math.nan, "")
            end = RunEnd(0, 9.0, "lammps", release, "in-process", cached=n == 2, folder="/r")
            history.finish(run, end, [angle, other])
        history.begin(RunStart("impulse", [], "0.1.0", "", "Linux"))
    return path


def test_nothing_recorded_yet_is_said_and_is_no_error(harness, answer, home):
    assert "no run is recorded yet" in harness("history").stdout
    assert answer("history")["runs"] == []
    assert list(home.iterdir()) == []


@pytest.mark.usefixtures("file")
def test_one_line_a_run_oldest_first(harness):
    lines = harness("history").stdout.splitlines()
    assert len(lines) == 5
    assert "verify --quick" in lines[1]
    assert "2 Aug 2023" in lines[1]
    assert "1 of 1" in lines[1]
    assert "cached" in lines[3]
    assert "unfinished" in lines[4]
    assert "no such run" in harness("history", "--engine", "mfix").stdout


@pytest.mark.usefixtures("file")
def test_quantities(harness, answer):
    lines = harness("history", "--quantity", "a*").stdout.splitlines()
    assert "10.2 ± 0.0001" in lines[1]
    found = answer("history", "--quantity", "*", "--limit", "1")["quantities"]
    assert [(row["name"], row["value"]) for row in found] == [("angle", 12.2)]


def test_exported_rows_are_those_of_the_list(harness, file, tmp_path):
    assert file.is_file()
    harness("history", "--quantity", "angle", "--csv", "angles.csv")
    with (tmp_path / "angles.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["value"]) for row in rows] == [12.2, 11.2, 10.2]
    assert rows[0]["engine_version"] == "22 Jul 2025"


@pytest.mark.usefixtures("file")
@pytest.mark.parametrize("against", [pytest.param("date", marks=pytest.mark.slow), "version"])
def test_a_quantity_is_drawn(harness, tmp_path, against):
    harness("history", "--quantity", "angle", "--plot", "a.svg", "--against", against)
    drawn = (tmp_path / "a.svg").read_bytes()
    assert b"<svg" in drawn
    harness("history", "--quantity", "angle", "--plot", "b.svg", "--against", against)
    assert (tmp_path / "b.svg").read_bytes() == drawn


@pytest.mark.usefixtures("file")
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--plot", "a.svg"], ["--plot", "--quantity"]),
        (["--plot", "a.gif", "--quantity", "angle"], ["a.gif", ".svg"]),
        (["--plot", "a.svg", "--quantity", "*"], ["fits 2 quantities"]),
        (["--plot", "a.svg", "--quantity", "angle", "--engine", "mfix"], ["no run in"]),
        (["--quantity", "angel"], ["'angel'", "near it: 'angle'"]),
        (["--since", "soon"], ["--since 'soon'"]),
        (["--csv", "no/such/a.csv"], ["--csv"]),
    ],
)
def test_bad_requests_leave_nothing(harness, tmp_path, options, words):
    said = harness("history", *options, status=2).stderr
    assert all(word in said for word in words)
    assert list(tmp_path.iterdir()) == []


def test_each_command_is_recorded_with_what_it_measured(harness, answer, home):
    harness("tower", "--height", "2")
    harness("impulse", "--heights", "1,2", "--stiffness", "1e6", "--speed", "2", "--law", "overlap")
    impulse, tower = answer("history")["runs"]
    assert (tower["command"], tower["options"]) == ("tower", "--height 2")
    assert (tower["engine"], tower["status"]) == ("rk4", 0)
    assert impulse["command"] == "impulse"
    ratios = answer("history", "--quantity", "impulse ratio alpha(2)*")["quantities"]
    assert [row["value"] for row in ratios] == [pytest.approx(0.6263, abs=1e-4)]
    assert not (home / "cache").exists()


def test_a_request_that_fails_is_recorded_with_its_error(harness, answer):
    harness("critical-angle", "--engine", "granoo", status=2)
    (run,) = answer("history")["runs"]
    assert run["status"] == 2
    assert "--engine 'granoo'" in run["note"]


def test_a_named_place_that_cannot_be_used_is_an_error(harness, home, monkeypatch):
    (home / "file").write_text("")
    monkeypatch.setenv("DEM_HARNESS_HOME", str(home / "file"))
    said = harness("tower", status=2).stderr
    assert "DEM_HARNESS_HOME" in said
    assert "cannot be used" in said


def test_a_default_place_that_cannot_be_used_costs_a_note(tmp_path, home):
    (home / "file").write_text("")
    environment = {k: v for k, v in os.environ.items() if k != "DEM_HARNESS_HOME"}
    environment |= {f"XDG_{name}_HOME": str(home / "file") for name in ("CACHE", "DATA")}
    done = subprocess.run(
        [sys.executable, "-m", "harness", "tower", "--json"],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout)["height"] == 1
    assert "no record of this run" in done.stderr


def test_a_history_of_a_newer_harness_ends_the_command_before_it_runs(harness, file):
    with closing(sqlite3.connect(file)) as database:
        database.execute("PRAGMA user_version = 99")
    assert "newer dem-harness" in harness("tower", status=2).stderr
    assert "newer dem-harness" in harness("history", status=2).stderr


def test_the_help_names_every_verdict(harness, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    told = harness("history", "--help").stdout
    assert all(verdict in told for verdict in VERDICTS)
