import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from harness.cases.drop.case import CASE
from harness.cases.drop.system import TEMPLATE, values_of
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.workers import FinishedRun, InProcess, Order
from harness.engines.process import Limits
from harness.engines.scripts import Script
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineTimeoutError,
)

pytestmark = [pytest.mark.live, pytest.mark.usefixtures("lammps_here")]

SCRIPT = Lammps.script(TEMPLATE)


def order(script, variables=()):
    """Return a run of a script, without the variables of the run before."""
    return Order(script, dict(variables), sampled=False)


def drop(**changes):
    """Return a run of a drop."""
    values = {**values_of(CASE.default), "series_every": 1000, **changes}
    return order(SCRIPT, {name: Lammps.literal(value) for name, value in values.items()})


GOOD = drop()
ENDLESS = drop(steps=2_000_000_000, series_every=1_000_000_000)


@pytest.fixture(scope="module")
def shared():
    with_two = InProcess(2, Limits())
    yield with_two
    with_two.close()


@pytest.fixture
def runner():
    made = []

    def make(workers=1, **limits):
        made.append(InProcess(workers, Limits(**limits)))
        return made[-1]

    yield make
    for one in made:
        one.close()


def children():
    """Return the process ids of the children of this process."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(words[1]) == os.getpid() and words[0] != "Z":
            found.append(int(stat.parent.name))
    return set(found)


@pytest.mark.parametrize("name", ["SEGV", "KILL", "ABRT"])
def test_lammps_killed_by_a_signal_costs_its_job_only(shared, suicide, name):
    before, dead, after = shared.run([GOOD, order(suicide(name)), GOOD])
    assert type(dead) is (EngineMemoryError if name == "KILL" else EngineCrashError)
    assert f"SIG{name}" in str(dead)
    assert isinstance(before, FinishedRun)
    assert isinstance(after, FinishedRun)


def test_run_out_of_time_is_ended_and_the_next_one_works(runner):
    one = runner(seconds=1.0)
    start = time.monotonic()
    late, good = one.run([ENDLESS, GOOD])
    assert type(late) is EngineTimeoutError
    assert "within 1 s" in str(late)
    assert isinstance(good, FinishedRun)
    assert time.monotonic() - start < 15


def test_runaway_memory_is_stopped_at_the_limit_and_the_next_run_works(runner, runaway_memory):
    one = runner(memory=2 * 1024**3)
    fat, good = one.run([order(runaway_memory), GOOD])
    assert type(fat) is EngineMemoryError
    assert "allocate" in str(fat)
    assert isinstance(good, FinishedRun)


def test_lost_atom_and_refused_input_are_told_apart(shared, lost_atom):
    refused = Script("refused.in", "units furlongs\n", frozenset())
    lost, wrong, good = shared.run([order(lost_atom), order(refused), GOOD])
    assert type(lost) is EngineLostAtomsError
    assert type(wrong) is EngineInputError
    assert "units" in str(wrong)
    assert isinstance(good, FinishedRun)


def test_runs_do_not_see_the_variables_of_earlier_ones(runner):
    one = runner()
    plain, steep, again = one.run([GOOD, order(GOOD.script, {"stiffness": "4e6"}), GOOD])
    result = [
        [line for line in out.log.splitlines() if line.startswith("RESULT")]
        for out in (plain, steep, again)
    ]
    assert result[0] == result[2]
    assert result[1] != result[0]
    assert len(result[1]) == len(result[0])


def test_provenance_names_release_packages_and_library(shared):
    who = shared.identify()
    assert who.how == "in-process"
    assert "GRANULAR" in who.packages
    assert Path(who.executable).name == "__init__.py"
    assert who.engine_version.split()[2].isdigit()


def test_close_ends_the_workers_and_removes_their_files(runner):
    others = children()
    one = runner(workers=2)
    one.run([GOOD, GOOD])
    born = children() - others
    folder = Path(f"/proc/{min(born)}/cwd").readlink().parent
    assert folder.is_dir()
    one.close()
    assert not children() & born
    assert not folder.exists()


OWNER = """
import sys, threading, time
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.workers import InProcess
from harness.engines.lammps.workers import FinishedRun, Order
from harness.engines.process import Limits
from harness.engines.scripts import Script
from tests.engines.lammps.test_inprocess import ENDLESS, GOOD
runner = InProcess(2, Limits())
runner.run([GOOD, GOOD])
threading.Thread(target=runner.run, args=([ENDLESS, ENDLESS],), daemon=True).start()
time.sleep(0.5)
print("at work", flush=True)
sys.stdin.read()
"""


def test_workers_clear_away_what_a_killed_harness_cannot(tmp_path):
    owner = subprocess.Popen(
        [sys.executable, "-c", OWNER],
        cwd=Path(__file__).parents[3],
        env={**os.environ, "TMPDIR": str(tmp_path)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert owner.stdout.readline() == b"at work\n"
    (folder,) = tmp_path.glob(".dem-harness-*")
    owner.kill()
    owner.communicate()
    deadline = time.monotonic() + 30
    while folder.exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    assert list(tmp_path.iterdir()) == []
    while working_below(tmp_path) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert working_below(tmp_path) == []


def working_below(folder):
    """Return the processes that work in a folder, also in one that is gone by now."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if str((process / "cwd").readlink()).startswith(f"{folder}/"):
                found.append(process.name)
    return found
