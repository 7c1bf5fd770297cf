"""kill -9 of ``verify``: its folder is whole or not there, and the next run completes it."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from harness.files import PREFIX
from harness.store.entries import Entries

pytestmark = [pytest.mark.live, pytest.mark.slow]

CASES = "incline,drop"
"""Two cases are enough: what is kept of a run is written in the same way in all of them."""


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


@pytest.mark.parametrize("part", [0.3, 0.6, 0.9])
def test_the_run_after_a_kill_completes(undisturbed, part, tmp_path, home):
    record, seconds = undisturbed
    killed = _start(tmp_path, home, "killed")
    time.sleep(part * seconds)
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
    # of a verification that was done there is one entry more, its report
    whole = again["cached"] or kept > record["engine_runs"]
    assert made == (0 if whole else record["engine_runs"] - kept)
