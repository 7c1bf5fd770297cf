"""Bulk runs that are cut go on from their restart files, with the same numbers to the bit."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from harness.cases.bulk.restarts import LONG, WORK, longest_part, restart_values
from harness.cases.bulk.series import check_rows
from harness.cases.registry import get_case
from harness.engines.contract import RESTART_EVERY, Job
from harness.engines.lammps.engine import Lammps
from harness.engines.lammps.language import check_log
from harness.engines.lammps.restarts import BEFORE, END, STATE, RestartFolder, check_restored
from harness.engines.output import results_in
from harness.engines.registry import engine_class
from harness.errors import EngineOutputError

PENETRATION, SILO, DRUM = (get_case(name) for name in ("penetration", "silo", "drum"))
ALL = pytest.mark.parametrize("case", [PENETRATION, SILO, DRUM], ids=lambda case: case.name)
SMALL = {
    "penetration": PENETRATION.default.replace(
        along=6, across=5, layers=3, start_height=0.0115, settle_time=0.02, duration=0.02
    ),
    "silo": SILO.default.replace(
        layers=3, silo_radius=0.016, cone_height=0.008, settle_time=0.12, duration=0.2
    ),
    "drum": DRUM.default.replace(
        small_layers=1, large_layers=-2, drum_radius=0.016, drum_length=0.014,
        settle_time=0.05, turn=20.0,
    ),
}  # fmt: skip
PARTS = 4
"""Of each of the two stages of a small run."""


def job(case, **changes):
    """Return the job of a small run with restart files, which begins anew some times."""
    p = SMALL[case.name]
    every = p.every * max(1, round(p.steps / p.every / PARTS))
    return Job(case.template, {**case.job(p).values, RESTART_EVERY: every, **changes}, "", True)


def words(case, lmp, folder, **more):
    """Return the command of a small run by hand, in a folder."""
    script = folder / f"{case.name}.in"
    script.write_text(Lammps.script(case.template).text, encoding="utf-8")
    values = {**job(case).values, "record": "yes", "series": "series", **more}
    sets = (word for name, value in values.items() for word in ("-var", name, str(value)))
    return [lmp, "-in", str(script), "-log", "log", "-screen", "none", *sets]


def results(folder):
    """Return the results in a log, each once: those of the release come with each part."""
    lines = (folder / "log").read_text("utf-8").splitlines()
    return sorted({line for line in lines if line.startswith("RESULT")})


# ---- which runs leave restart files ---------------------------------------------------------


@ALL
def test_a_long_run_leaves_restart_files_and_a_short_one_pays_nothing(case):
    assert RESTART_EVERY not in case.job(case.default).values
    p = case.presets["published"]
    values = case.job(p).values
    every = values[RESTART_EVERY]
    assert every % p.every == 0
    assert WORK <= every * p.grains < WORK + p.every * p.grains
    work = p.grains * (p.settle_steps + p.steps)
    assert longest_part(values) == pytest.approx(every * p.grains / work)


@pytest.mark.parametrize(("short", "long"), [(LONG - 1, LONG)])
def test_the_limit_is_the_work(short, long):
    class Run:
        grains, settle_steps, every = 1, 0, 10

    one, other = Run(), Run()
    one.steps, other.steps = short, long
    assert restart_values(one) == {}
    assert restart_values(other) == {RESTART_EVERY: WORK}


@pytest.mark.parametrize("name", ["liggghts", "yade", "kratos"])
def test_codes_without_restart_files_leave_the_value_out(name):
    kind = engine_class(name)
    engine = kind.__new__(kind)
    engine._scheme = "none"
    published = SILO.job(SILO.presets["published"])
    assert RESTART_EVERY in published.values
    assert RESTART_EVERY not in kind.script(SILO.template).variables
    assert super(kind, engine).refuses(published) == ""
    assert RESTART_EVERY not in engine.task(published).values


# ---- which restart file is taken ------------------------------------------------------------


def leave(folder, turn, text=b"", end=END):
    (folder / f"run.{turn}").write_bytes(text + end)
    return f"variable turn equal {turn}\nvariable part equal 3\n"


def test_a_restart_file_that_is_cut_short_is_not_taken_but_the_one_before(tmp_path):
    task = Lammps.__new__(Lammps)
    task._restart_every = None
    task = task.task(job(SILO))
    with RestartFolder(tmp_path, task, {}) as first:
        assert first.task.values["resume"] == "no"
        state, before = first.path / STATE, first.path / BEFORE
        before.write_text(leave(first.path, 0, b"older"), "utf-8")
        state.write_text(leave(first.path, 1, b"newer"), "utf-8")
    with RestartFolder(tmp_path, task, {}) as again:
        assert again.task.values["resume"] == "yes"
        assert "turn equal 1" in state.read_text("utf-8")
    leave(first.path, 1, b"newer", END[:-1])
    with RestartFolder(tmp_path, task, {}) as again:
        assert again.task.values["resume"] == "yes"
        assert "turn equal 0" in state.read_text("utf-8")
    # killed between the moves of the two states
    state.replace(before)
    with RestartFolder(tmp_path, task, {}) as again:
        assert again.task.values["resume"] == "yes"
    leave(first.path, 0, end=b"")
    with RestartFolder(tmp_path, task, {}) as again:  # none is left: it begins anew
        assert again.task.values["resume"] == "no"


def test_the_files_of_other_parameters_are_another_folder(tmp_path):
    engine = Lammps.__new__(Lammps)
    engine._restart_every = None
    task, other = (engine.task(job(SILO, friction=friction)) for friction in (0.3, 0.30001))
    with RestartFolder(tmp_path, task, {}) as one, RestartFolder(tmp_path, other, {}) as two:
        assert one.path != two.path
    with RestartFolder(tmp_path, task, {"lmp": 1}) as three:  # another LAMMPS
        assert three.path != one.path


# ---- runs that are killed -------------------------------------------------------------------


def killed(command, folder, stage, after):
    """Start a run and kill it ``after`` s in a stage; return whether it was still at work."""
    state = folder / f"{stage[0]}.state"
    # lmp of the Python package is a child of what is started: the group is killed
    with subprocess.Popen(command, cwd=folder, process_group=0) as running:
        until = time.monotonic() + 60.0
        while running.poll() is None:
            assert time.monotonic() < until
            with contextlib.suppress(FileNotFoundError):  # it is replaced now and then
                if f"released string {stage[1]}" in state.read_text("utf-8"):
                    time.sleep(after)
                    break
            time.sleep(0.002)
        if running.poll() is None:
            os.killpg(running.pid, signal.SIGKILL)
    return running.returncode != 0


@pytest.mark.live
@ALL
def test_a_run_that_is_killed_at_any_time_goes_on_with_the_same_numbers(case, lmp, tmp_path):
    uncut, cut = tmp_path / "uncut", tmp_path / "cut"
    for folder in (uncut, cut):
        folder.mkdir()
    subprocess.run(words(case, lmp, uncut), cwd=uncut, check=True)
    began = words(case, lmp, cut)
    kills = 0
    for stage, after in (("no", 0.0), ("no", 0.05), ("yes", 0.0), ("yes", 0.05), ("yes", 0.1)):
        kills += killed(began, cut, (case.name, stage), after)
        began = words(case, lmp, cut, resume="yes")
    assert kills >= 2  # a busy machine may let a run end before it is killed
    subprocess.run(began, cwd=cut, check=True)
    assert results(cut) == results(uncut)
    assert (cut / "series").read_bytes() == (uncut / "series").read_bytes()
    log = (cut / "log").read_text("utf-8")
    assert "\nread_restart" in log
    check_log(log)
    check_restored(log, "LAMMPS")
    rows = (cut / "series").read_text("utf-8").count("\n")
    if case is not DRUM:  # a header, and a row of the release
        p = SMALL[case.name]
        assert rows == 2 + p.steps // p.every


CUT = """
import sys
from harness.engines.lammps.engine import Lammps
from tests.cases.bulk.test_restarts import SILO, job
with Lammps(workers=1, restarts=sys.argv[1]) as engine:
    engine.run([job(SILO)])
"""


@pytest.mark.slow
@pytest.mark.live
def test_the_engine_takes_a_run_up_where_its_process_was_killed(lammps_here, tmp_path):  # noqa: ARG001
    with Lammps(workers=1) as engine:
        (uncut,) = engine.run([job(SILO)])
    for _ in range(20):
        process = subprocess.Popen([sys.executable, "-c", CUT, str(tmp_path)], process_group=0)
        until = time.monotonic() + 120.0
        while process.poll() is None and not list(tmp_path.glob(f"*/{STATE}")):
            assert time.monotonic() < until
            time.sleep(0.002)
        process.kill()
        process.wait()
        if list(tmp_path.glob(f"*/{STATE}")):
            break
    else:
        pytest.fail("twenty runs were over before they were cut")
    with Lammps(workers=1, restarts=str(tmp_path)) as engine:
        assert engine.resumes(job(SILO))
        (output,) = engine.run([job(SILO)])
    assert "create_atoms" not in output.log
    assert dict(output.results) == dict(uncut.results)
    for name, column in uncut.tables["series"].items():
        np.testing.assert_array_equal(output.tables["series"][name], column)
    assert SILO.read(SMALL["silo"], output, Lammps.traits)["bed_coordination"] > 0.0
    assert not list(tmp_path.glob(f"*/{STATE}"))  # it has ended


# ---- planted faults -------------------------------------------------------------------------


@pytest.mark.live
def test_by_hand_the_files_of_other_parameters_are_refused(lmp, tmp_path):
    subprocess.run(words(SILO, lmp, tmp_path), cwd=tmp_path, check=True)
    other = words(SILO, lmp, tmp_path, resume="yes", friction=0.31)
    assert subprocess.run(other, cwd=tmp_path, check=False).returncode == 1
    log = (tmp_path / "log").read_text("utf-8")
    assert "\nERROR: restart_files = silo: are those of a run with other parameters" in log


def settled(lmp, folder, every, plant=lambda text: text, case=SILO, **values):
    """Return the results of a bed, with a restart file a row before its release or not; the log."""
    folder.mkdir()
    p = SMALL[case.name]
    steps = p.every * (p.settle_steps // p.every)
    more = {"settle_steps": steps, "steps": p.every, RESTART_EVERY: every and steps - p.every}
    command = words(case, lmp, folder, **more, **values)
    script = folder / f"{case.name}.in"
    script.write_text(plant(script.read_text("utf-8")), "utf-8")
    subprocess.run(command, cwd=folder, check=True)
    log = (folder / "log").read_text("utf-8")
    return {name: float(text) for name, text in results_in(log) if text != "finished"}, log


def in_two_runs(text):
    """Cut the settling at the restart file in two runs, as LAMMPS sets forces up in each."""
    run = "run $(v_stretch:%.0f) post no"
    two = "run $(v_settle_steps-v_series_every) post no\nrun ${series_every} post no"
    return text.replace(run, two, 1)


def forgets(fix):
    """Return a fault: a fix has another name when the run goes on, so that its history is lost."""

    def plant(text):
        line = re.search(rf"^fix {fix} .*$", text, re.MULTILINE)[0]
        renamed = (
            f'variable its string {fix}\nif "${{going}} == yes" then "variable its string other"'
        )
        text = text.replace(line, f"{renamed}\n{line.replace(f'fix {fix}', 'fix ${its}', 1)}")
        return re.sub(rf"f_{fix}\b", "f_${its}", text).replace(f"unfix {fix}", "unfix ${its}")

    return plant


@pytest.mark.slow
@pytest.mark.live
def test_what_contacts_and_walls_remember_comes_through_and_its_loss_is_noticed(lmp, tmp_path):
    plain, log = settled(lmp, tmp_path / "plain", every=0, plant=in_two_runs)
    assert "\nread_restart" not in log
    again, log = settled(lmp, tmp_path / "again", every=1)
    assert "\nread_restart" in log
    check_log(log)
    check_restored(log, "LAMMPS")
    off = {name: abs(again[name] / value - 1.0) for name, value in plain.items() if value}
    print(off)
    # ten digits are printed; sums over particles that are sorted anew are rounded in another order
    assert max(off.values()) < 1e-9
    lost, log = settled(lmp, tmp_path / "lost", every=1, plant=forgets("floor"))
    with pytest.raises(EngineOutputError, match="lost what a restart file holds: fix style: wall"):
        check_restored(log, "LAMMPS")
    with Lammps(workers=1) as engine:
        task = engine.task(job(SILO))
        with pytest.raises(EngineOutputError, match="lost what a restart file holds: fix style"):
            engine.output(task, log, "", 1.0)
    print(lost)
    assert abs(lost["bed_kinetic_J"] / plain["bed_kinetic_J"] - 1.0) > 1e-6


@pytest.mark.live
def test_springs_of_rolling_come_through_a_restart_in_a_drum_that_is_not_sorted(lmp, tmp_path):
    """A planted fault: sorting turns them round, which it does with a restart file as without."""

    def energy(name, every, plant=lambda text: text, rolling_friction=0.1):
        folder, more = tmp_path / name, {"case": DRUM, "rolling_friction": rolling_friction}
        found, log = settled(lmp, folder, every, plant, **more)
        assert ("\nread_restart" in log) == (every > 0)
        assert ("\natom_modify sort 0 0" in log) == (rolling_friction > 0.0 and name != "sorted")
        check_log(log)
        return found["bed_kinetic_J"]

    def sort(text):
        never = '"atom_modify sort 0 0"'
        assert never in text
        return in_two_runs(text.replace(never, '"atom_modify sort 50 0"'))

    plain = energy("plain", 0, in_two_runs)
    assert energy("again", 1) == pytest.approx(plain, rel=1e-9)
    assert energy("sorted", 0, sort) != pytest.approx(plain, rel=1e-6)
    assert energy("sliding", 0, in_two_runs, 0.0) != pytest.approx(plain, rel=1e-3)


def test_a_series_that_lacks_rows_is_an_error():
    times = np.arange(1, 101) * 0.01
    check_rows(times, 1.0, "LAMMPS")
    check_rows(np.concatenate([[0.0], times]), 1.0, "LAMMPS")
    for kept in (times[:-2], times[2:], np.delete(times, 50), times[:1]):
        with pytest.raises(EngineOutputError, match="LAMMPS left a series that lacks rows"):
            check_rows(kept, 1.0, "LAMMPS")
