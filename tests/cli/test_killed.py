"""kill -9 at random moments of ``verify``: nothing is lost, nothing half-written."""

import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing

import pytest

from harness.files import PREFIX
from harness.store.entries import Entries

pytestmark = [pytest.mark.live, pytest.mark.slow]

MOMENTS = 10
CASES = "incline,drop"
"""Two cases are enough: what is kept of a run is written in the same way in all of them."""

SEED = 6


def _start(folder, home, output):
    return subprocess.Popen(
        [
            *(sys.executable, "-m", "harness", "verify", "--quick", "--json"),
            *("--cases", CASES, "--output", output),
        ],
        cwd=folder,
        env={**os.environ, "DEM_HARNESS_HOME": str(home)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def _verified(folder, home, output):
    process = _start(folder, home, output)
    out, said = process.communicate(timeout=600)
    assert process.returncode == 0, said
    return json.loads(out)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """What a verification finds that nobody kills, and how long it takes."""
    folder, home = tmp_path_factory.mktemp("undisturbed"), tmp_path_factory.mktemp("home")
    clock = time.monotonic()
    record = _verified(folder, home, "run")
    return record, time.monotonic() - clock


def _entries_are_whole(cache):
    damaged = []
    entries = Entries(cache, tell=damaged.append)
    keys = [path.name for path in cache.glob("??/*")]
    payloads = [entries.get(key) for key in keys]
    assert damaged == []
    assert None not in payloads
    return len(keys)


@pytest.mark.parametrize("moment", range(MOMENTS))
def test_the_run_after_a_kill_completes(undisturbed, moment, tmp_path, home):
    record, seconds = undisturbed
    after = random.Random(SEED * MOMENTS + moment).uniform(0.0, seconds)
    killed = _start(tmp_path, home, "killed")
    time.sleep(after)
    killed.send_signal(signal.SIGKILL)
    killed.communicate(timeout=60)
    cache = home / "cache"
    kept = _entries_are_whole(cache) if cache.is_dir() else 0
    if (tmp_path / "killed").exists():  # there whole, or not at all
        there = {path.name for path in (tmp_path / "killed").iterdir()}
        assert there >= {"results.json", "results.csv", "report.md", "report.html", "figures"}

    again = _verified(tmp_path, home, "run")
    assert again["checks"] == record["checks"]
    assert not list(tmp_path.glob(f"{PREFIX}*"))
    made = again["engine_runs"]
    print(f"killed after {after:.1f} s, {kept} entries kept; then {made} engine runs made")
    # of a verification that was done there is one entry more, its report
    whole = again["cached"] or kept > record["engine_runs"]
    assert made == (0 if whole else record["engine_runs"] - kept)
    with closing(sqlite3.connect(home / "history.sqlite")) as database:
        assert database.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        statuses = database.execute("SELECT status FROM run ORDER BY id").fetchall()
    assert statuses[-1] == (0,)
    assert statuses[:-1] in ([], [(None,)], [(0,)])
