"""A run of layers that is cut goes on from its restart file, with the same numbers to the bit."""

import os
import signal
import subprocess
import sys
import time

import pytest

from harness.cases.layers.case import CASE
from harness.cases.layers.system import Layers, job_of, restart_steps
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.restarts import END, STATE, RestartFolder
from harness.engines.process import Limits
from harness.errors import EngineCrashError, EngineInputError, EngineTimeoutError

SMALL = Layers(layers=1, length=6, width=3, stiffness_over_weight=1e3, flow_time=10.0)
EVERY = 3000


def job(case=SMALL, every=EVERY):
    one = job_of(case)
    return type(one)(one.template, {**one.values, "restart_every": every})


def state_in(place):
    return next(place.glob(f"*/{STATE}"), None)


def results(output):
    assert not isinstance(output, Exception), output
    return output.results


def test_restart_files_are_part_of_a_long_run_and_not_of_the_committed_ones():
    assert job_of(SMALL).values["restart_every"] == restart_steps(SMALL) > 1e8
    large = SMALL.replace(layers=8, length=72, width=36, stiffness_over_weight=3e4)
    assert restart_steps(large) * (large.grains + large.base_spheres) == pytest.approx(
        1e10, rel=1e-5
    )
    assert "restart_every" not in job_of(SMALL, every=100).values  # a series is not cut


@pytest.fixture(scope="module")
def whole(lammps_here):  # noqa: ARG001
    """The results of the run that is not cut, of one process."""
    with Lammps(workers=1) as engine:
        (output,) = engine.run([job()])
    return results(output)


CUT = """
import sys
from harness.engines.lammps.engine import Lammps
from tests.engines.lammps.test_restarts import job
with Lammps(workers=1, restarts=sys.argv[1]) as engine:
    engine.run([job()])
"""


def cut_after_a_restart_file(place):
    """Kill a run that has left a restart file.

    Again where it was over before it was killed: what is left of it takes a third of a second,
    which a busy machine lets pass.
    """
    for _ in range(20):
        process = subprocess.Popen([sys.executable, "-c", CUT, str(place)], process_group=0)
        until = time.monotonic() + 60.0
        while state_in(place) is None and process.poll() is None:
            assert time.monotonic() < until
            time.sleep(0.002)
        process.kill()
        process.wait()
        if state_in(place) is not None:
            return
        assert process.returncode in (0, -signal.SIGKILL)
    pytest.fail("20 runs were over before they were cut")


@pytest.mark.live
def test_a_run_that_is_killed_goes_on_with_the_same_numbers(whole, tmp_path):
    place = tmp_path / "with a space"
    cut_after_a_restart_file(place)
    state = state_in(place)
    assert state is not None
    with Lammps(workers=1, restarts=str(place)) as engine:
        assert engine.resumes(job())
        (output,) = engine.run([job()])
    assert results(output) == whole
    log = output.log
    assert "\nread_restart restarts-" in log  # it went on, and did not begin again
    assert "create_atoms" not in log.partition("read_restart")[2]
    assert not state.exists()


@pytest.mark.slow
@pytest.mark.live
def test_the_executable_goes_on_from_what_the_library_left(whole, lmp, tmp_path):
    cut_after_a_restart_file(tmp_path)
    (state,) = [state_in(tmp_path)]
    with Lammps(workers=1, restarts=str(tmp_path)) as library, Lammps(lmp=lmp) as there:
        # another LAMMPS is another run: files are its own
        task = there.task(job())
        with RestartFolder(tmp_path, task, there.fingerprint()) as other:
            assert other.path != state.parent
        assert not there.resumes(job())
        assert library.resumes(job())
    with Lammps(lmp=lmp, restarts=str(tmp_path)) as there:
        (output,) = there.run([job()])
    assert results(output) == whole


@pytest.mark.slow
@pytest.mark.live
def test_the_limit_of_time_holds_between_two_restart_files(lammps_here, tmp_path):  # noqa: ARG001
    slow = SMALL.replace(rate=0.01)
    with Lammps(workers=1, limits=Limits(seconds=0.5)) as engine:
        (output,) = engine.run([job(slow)])
    assert isinstance(output, EngineTimeoutError)
    with Lammps(workers=1, restarts=str(tmp_path), limits=Limits(seconds=0.5)) as engine:
        (output,) = engine.run([job(slow, every=500)])
    results(output)
    assert output.seconds > 0.5


def test_two_processes_do_not_write_into_one_folder_and_the_time_of_parts_is_summed(tmp_path):
    engine = Lammps.__new__(Lammps)
    engine._restart_every = None
    task = engine.task(job())
    with RestartFolder(tmp_path, task, {}) as first, RestartFolder(tmp_path, task, {}) as second:
        assert (first.held, second.held) == (True, False)
        assert "restart_files" not in second.task.values
        assert first.task.values["resume"] == "no"
        (first.path / STATE).write_text("variable turn equal 1\n", encoding="utf-8")
        (first.path / "run.1").write_bytes(END)
        os.utime(first.path / STATE, (time.time() + 100.0,) * 2)
        assert isinstance(first.ended(EngineCrashError("killed")), EngineCrashError)
    with RestartFolder(tmp_path, task, {}) as again:
        assert again.task.values["resume"] == "yes"
        assert again.seconds == pytest.approx(100.0, abs=5.0)
        # what LAMMPS refuses to go on with is not tried again
        again.ended(EngineInputError("bad restart file"))
    assert state_in(tmp_path) is None


@pytest.mark.slow
@pytest.mark.live
@pytest.mark.parametrize(
    ("every", "rise", "stages"),
    [(3000, 0.0, "settling"), (1100, 0.0, "loosening"), (3000, 0.05, "moving"),
     (170, 0.05, "leaving")],
)  # fmt: skip
def test_it_goes_on_from_every_stage(every, rise, stages, lmp, tmp_path):
    script = tmp_path / "layers.in"
    script.write_text(Lammps.script(CASE.template).text, encoding="utf-8")
    values = {**job(SMALL.replace(rise=rise), every).values, "restart_files": "mine"}
    words = [lmp, "-in", str(script), "-log", "none"]
    for name, value in values.items():
        words += ["-var", name, str(value)]

    def told(*more):
        done = subprocess.run([*words, *more], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout[-500:]
        return [line for line in done.stdout.splitlines() if line.startswith("RESULT")]

    uncut = told()
    # the last restart file is as if it had been cut after it; on another processor it may be at
    # another stage than those named, which are what is meant
    stage = (tmp_path / "mine.state").read_text(encoding="utf-8").split()[3]
    assert stage in {stages, "slowing", "loosening", "settling", "moving", "leaving"}
    assert told("-var", "resume", "yes") == uncut
