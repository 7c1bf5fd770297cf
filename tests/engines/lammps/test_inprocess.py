"""LAMMPS as a library in workers: what happens to one costs its run alone, nothing is left."""

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from harness.cases.drop import CASE, TEMPLATE, values_of
from harness.engines.base import Job
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.inprocess import InProcess, Worker
from harness.engines.process import Limits
from harness.engines.scripts import Script, Task
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineMemoryError,
    EngineOutputError,
    EngineTimeoutError,
)

pytestmark = [pytest.mark.live, pytest.mark.usefixtures("lammps_here")]

FAT = """
region box block 0 400 0 400 0 400
create_box 1 box
lattice sc 1
create_atoms 1 box
"""


def task_of(text):
    """Return a run of a script that ends well unless its text does not."""
    script = Script("test.in", text + '\nprint "RESULT verdict = moves_on"\n', frozenset())
    return Task(Job(TEMPLATE, {}), script, {})


def drop(**changes):
    """Return a run of a drop."""
    values = {**values_of(CASE.default), "series_every": 1000, **changes}
    return Task(Job(TEMPLATE, values), Lammps.script(TEMPLATE), values)


def run(runner, *tasks):
    """Return the log of each task, or the error of its run."""
    return runner.run(tasks, lambda *finished: finished[1])


GOOD = drop()
ENDLESS = drop(steps=2_000_000_000, series_every=1_000_000_000)


FAULTS = {  # a run, the limits, its error and words of it
    "SEGV": (task_of("shell 'kill -SEGV $PPID'"), {}, EngineCrashError, "SIGSEGV"),
    "KILL": (task_of("shell 'kill -KILL $PPID'"), {}, EngineMemoryError, "SIGKILL"),
    "hang": (ENDLESS, {"seconds": 1.0}, EngineTimeoutError, "within 1 s"),
    "memory": (task_of(FAT), {"memory": 2 * 1024**3}, EngineMemoryError, "allocate"),
    "refused": (task_of("units furlongs"), {}, EngineInputError, "units"),
}


@pytest.fixture
def runner():
    with contextlib.ExitStack() as stack:
        yield lambda workers=1, **limits: stack.enter_context(
            contextlib.closing(InProcess(workers, Limits(**limits)))
        )


@pytest.mark.parametrize("name", FAULTS)
def test_a_run_that_fails_is_named_and_costs_only_itself(runner, name):
    task, limits, error, words = FAULTS[name]
    before, failed, after = run(runner(**limits), GOOD, task, GOOD)
    assert type(failed) is error
    assert words in str(failed)
    assert isinstance(before, str)
    assert isinstance(after, str)


def test_a_bad_output_has_its_log_and_does_not_end_the_process(tmp_path):
    def read(*_):
        raise EngineOutputError("cannot be read")

    worker = Worker(tmp_path, Limits())
    worker.identify()
    process = working_below(tmp_path)
    with pytest.raises(EngineOutputError, match="cannot be read") as error:
        worker.run(GOOD, read)
    assert "RESULT verdict" in error.value.log
    assert working_below(tmp_path) == process != []
    worker.end()


def test_a_process_starts_without_pydantic():
    code = "import sys, harness.engines.lammps.inprocess; sys.exit('pydantic' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_runs_do_not_see_the_variables_of_earlier_ones(runner):
    steep = drop(stiffness=4e6)
    other = task_of("variable gravity equal 3\nvariable mine index 7")
    ends = run(runner(), GOOD, steep, other, GOOD)
    plain, changed, _, again = (
        [line for line in end.splitlines() if line.startswith("RESULT")] for end in ends
    )
    assert plain == again
    assert changed != plain
    assert len(changed) == len(plain)


OWNER = """
import sys, threading, time
from harness.engines.lammps.inprocess import InProcess
from harness.engines.process import Limits
from tests.engines.lammps.test_inprocess import ENDLESS, GOOD, run
runner = InProcess(2, Limits())
run(runner, GOOD, GOOD)
threading.Thread(target=run, args=(runner, ENDLESS, ENDLESS), daemon=True).start()
time.sleep(0.5)
print("at work", flush=True)
if sys.stdin.read() == "close":
    runner.close()
"""


@pytest.mark.parametrize("way", ["kill", "close"])
def test_workers_and_their_files_end_with_the_harness(tmp_path, way):
    owner = subprocess.Popen(
        [sys.executable, "-c", OWNER],
        cwd=Path(__file__).parents[3],
        env={**os.environ, "TMPDIR": str(tmp_path)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert owner.stdout.readline() == b"at work\n"
    assert len(working_below(tmp_path)) == 2
    if way == "kill":
        owner.kill()
    owner.communicate(b"close")
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline and (any(tmp_path.iterdir()) or working_below(tmp_path)):
        time.sleep(0.1)
    assert list(tmp_path.iterdir()) == []
    assert working_below(tmp_path) == []


def test_a_closed_runner_starts_nothing():
    runner = InProcess(1, Limits())
    runner.close()
    (error,) = run(runner, GOOD)
    assert str(error) == "LAMMPS (in-process) was closed"


def working_below(folder):
    """Return the processes that work in a folder, also in one that is gone by now."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if str((process / "cwd").readlink()).startswith(f"{folder}/"):
                found.append(process.name)
    return found
