"""What a kept verification and a long history cost, with the start of Python in it.

Run with ``pytest -m benchmark -s tests/benchmarks``. Times are CPU time, of all
processes started: what one waits for on a machine with nothing else to do. What is
asserted are ratios to something else in the same run: a slower machine is slower in both.
"""

import json
import resource
import subprocess
import sys

import pytest

from harness.comparison.verdicts import Kind, Tolerance, judge
from harness.store.history import History, RunEnd, RunStart

pytestmark = pytest.mark.benchmark

HARNESS = ("-m", "harness")

RUNS = 10_000
QUANTITIES = 60
"""About as many as a verification has."""


def _timed(folder, *arguments):
    """Return what Python prints and the CPU time [s] it takes, given these arguments."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


@pytest.mark.live
def test_a_kept_verification_costs_a_tenth_of_a_quick_one_at_most(tmp_path):
    _, first = _timed(tmp_path, *HARNESS, "verify", "--quick", "--output", "first")
    times = []
    for n in range(3):
        out, seconds = _timed(
            tmp_path, *HARNESS, "verify", "--quick", "--json", "--output", f"again-{n}"
        )
        assert json.loads(out)["cached"] is True
        times.append(seconds)
    files = [sorted(p.name for p in (tmp_path / n).rglob("*")) for n in ("first", "again-0")]
    assert files[0] == files[1]
    print(f"\nverify --quick: {first:.1f} s; kept: {', '.join(f'{t:.2f} s' for t in times)}")
    assert min(times) < first / 10.0


@pytest.fixture(scope="module")
def long_history(tmp_path_factory):
    path = tmp_path_factory.mktemp("long") / "history.sqlite"
    width = Tolerance("deg", 3e-4, 0.0, "that of a test")
    found = [
        judge(f"incline: check {n}", Kind.ANALYTIC, 10.2, 10.2, width, uncertainty=1e-4)
        for n in range(QUANTITIES)
    ]
    end = RunEnd(0, 12.0, "lammps", "22 Jul 2025 - Update 4", "in-process", folder="/runs/1")
    with History(path) as history:
        # as fast as a disk allows: durability is not what is measured here
        history.rows("PRAGMA synchronous = OFF")
        for _ in range(RUNS):
            start = RunStart("verify", ["--quick"], "0.1.0", "abc", "Linux")
            history.finish(history.begin(start), end, found)
    return path


PANDAS = """
import sqlite3, sys
import pandas
with sqlite3.connect(sys.argv[1]) as history:
    frame = pandas.read_sql("SELECT * FROM run ORDER BY started DESC", history)
print(frame.to_string())
"""
"""The same list as the first tool at hand would make it."""


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--limit", str(RUNS)],
        ["--engine-version", "22 Jul", "--verdict", "pass", "--quantity", "incline: check 7"],
    ],
)
def test_ten_thousand_runs_are_listed_in_less_time_than_pandas_takes(
    long_history, tmp_path, monkeypatch, options
):
    monkeypatch.setenv("DEM_HARNESS_HOME", str(long_history.parent))
    turns = [
        (
            _timed(tmp_path, *HARNESS, "history", *options),
            _timed(tmp_path, "-c", PANDAS, str(long_history)),
        )
        for _ in range(3)
    ]
    lines = turns[0][0][0].count("\n") - 1
    seconds, pandas = (min(turn[i][1] for turn in turns) for i in (0, 1))
    print(f"\nhistory {' '.join(options)}: {lines} lines in {seconds:.2f} s; pandas {pandas:.2f} s")
    assert lines == (RUNS if "--limit" in options else 30)
    # 0.3 of it for 30 lines, 0.48 for all: half has no margin
    assert seconds < pandas
