"""LAMMPS as a library in workers: what happens to one costs its run alone, nothing is left."""

import contextlib
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from harness.cases.drop import CASE, TEMPLATE, values_of
from harness.engines.base import SCENE, Job
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

BOX = "region box block 0 999 0 999 0 999\ncreate_box 1 box\nmass 1 1.0\n"
FAT = f"""{BOX}create_atoms 1 single 1 1 1
pair_style zero 1.0
pair_coeff * *
atom_modify sort 0 0
neigh_modify binsize 1.0
run 0"""
ENDLESS = f"{BOX}run 2000000000"


def task_of(text, seconds=60.0):
    """Return a run of a script that ends well unless its text does not."""
    script = Script("test.in", text + '\nprint "RESULT verdict = moves_on"\n', frozenset())
    return Task(Job(SCENE, {}, seconds=seconds), script, {})


def run(runner, *tasks):
    """Return the log of each task, or the error of its run."""
    return runner.run(tasks, lambda *finished: finished[1])


GOOD = task_of("print hello")
FAULTS = {  # a run, its error and words of it
    "SEGV": (task_of("shell 'kill -SEGV $PPID'"), EngineCrashError, "SIGSEGV"),
    "KILL": (task_of("shell 'kill -KILL $PPID'"), EngineMemoryError, "SIGKILL"),
    "hang": (task_of(ENDLESS, seconds=0.0), EngineTimeoutError, "within 0.3 s"),
    "memory": (task_of(FAT), EngineMemoryError, "allocate"),
    "refused": (task_of("units furlongs"), EngineInputError, "units"),
}


@pytest.fixture
def runner():
    with contextlib.closing(InProcess(1, Limits(seconds=0.3, memory=2 * 1024**3))) as one:
        yield one


def test_a_run_that_fails_is_named_and_costs_only_itself(runner):
    tasks = [task for failing, _, _ in FAULTS.values() for task in (failing, GOOD)]
    ends = run(runner, *tasks)
    for (_, error, words), failed in zip(FAULTS.values(), ends[::2], strict=True):
        assert type(failed) is error
        assert words in str(failed)
    assert all("hello" in good for good in ends[1::2])


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


def drop(**changes):
    """Return a run of a drop."""
    values = {**values_of(CASE.default), "series_every": 1000, **changes}
    return Task(Job(TEMPLATE, values, seconds=60.0), Lammps.script(TEMPLATE), values)


def test_runs_do_not_see_the_variables_of_earlier_ones(runner):
    other = task_of("variable gravity equal 3\nvariable mine index 7")
    ends = run(runner, drop(), drop(stiffness=4e6), other, drop())
    plain, changed, _, again = (
        [line for line in end.splitlines() if line.startswith("RESULT")] for end in ends
    )
    assert plain == again
    assert changed != plain
    assert len(changed) == len(plain)


OWNER = f"""
from harness.engines.base import SCENE, Job
from harness.engines.lammps.inprocess import InProcess
from harness.engines.process import Limits
from harness.engines.scripts import Script, Task
task = Task(Job(SCENE, {{}}), Script("test.in", {ENDLESS!r}, frozenset()), {{}})
InProcess(2, Limits()).run([task, task], print)
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the folder of temporary files, also of processes that the test starts."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def wait_until(holds):
    """Wait until something holds, and return whether it does."""
    end = time.monotonic() + 120
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    return holds()


def at_work(folder):
    return len([*folder.glob("*/*/log")]) == len(working_below(folder)) == 2


def nothing_is_left(folder):
    return not any(folder.iterdir()) and not working_below(folder)


def test_workers_and_their_files_end_with_a_harness_that_is_killed(folder):
    owner = subprocess.Popen([sys.executable, "-c", OWNER])
    assert wait_until(lambda: at_work(folder))
    owner.kill()
    owner.wait()
    assert wait_until(lambda: nothing_is_left(folder))


def test_a_closed_runner_ends_its_workers_and_starts_nothing(folder):
    runner = InProcess(2, Limits())
    with ThreadPoolExecutor(1) as pool:
        endless = pool.submit(run, runner, *2 * [task_of(ENDLESS)])
        assert wait_until(lambda: at_work(folder))
        runner.close()
        ends = [*endless.result(), *run(runner, GOOD)]
    assert {str(end) for end in ends} == {"LAMMPS (in-process) was closed"}
    assert nothing_is_left(folder)


def working_below(folder):
    """Return the processes that work in a folder, also in one that is gone by now."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if str((process / "cwd").readlink()).startswith(f"{folder}/"):
                found.append(process.name)
    return found
