"""What would hardly end is refused before it begins; what runs long hears Ctrl-C."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from harness.cases.bulk.places import PUBLISHED
from harness.cases.incline.levels import (
    RUNS_BY_PASSAGE,
    angle_seconds,
    extrapolation_seconds,
    run_seconds,
)
from harness.cases.incline.system import Incline
from harness.cases.registry import all_cases
from harness.cases.tower.case import tower_seconds
from harness.cli.engine_options import LongRunOptions
from harness.engines.cost import MOST_SECONDS, check_duration, engine_seconds
from harness.engines.reference import Reference
from harness.engines.registry import ENGINES, engine_class
from harness.errors import RequestError
from harness.parameters.tower import Tower
from harness.workflows.estimate import OTHER_SECONDS, SECONDS_BY_LEVEL, verification_seconds

ENDLESS = [
    ("impulse", "--heights", "1-10000"),
    ("critical-angle", "--stiffness", "1e308"),
    ("critical-angle", "--stiffness", "1e308", "--engine", "reference"),
    ("critical-angle", "--diameter", "1e-15", "--engine", "lammps"),
    ("critical-angle", "--stiffness", "1e13", "--extrapolate"),
    ("critical-angle", "--method", "steady", "--wells", "10000", "--stiffness", "1e11"),
    ("tower", "--height", "10000000"),
    ("tower", "--duration", "1e7"),
    ("tower", "--height", "1000", "--duration", "30000", "--solver", "exact"),
    ("verify", "--cases", "penetration"),
    ("verify", "--full", "--cases", "all"),
    ("tower", "--height", "1000000", "--law", "overlap", "--solver", "lammps"),
    ("run", "incline", "--set", "stiffness=1e300"),
    ("run", "drop", "--set", "steps_per_contact=1e5", "--set", "duration=1e4"),
    ("run", "tower", "--set", "height=4000", "--set", "duration=3000"),
    ("run", "incline-roll", "--set", "duration=1e6"),
    ("run", "penetration", "--set", "preset=published"),
    ("run", "silo", "--set", "preset=published"),
    ("run", "drum", "--set", "preset=published"),
    ("sweep", "incline", "--over", "stiffness=1e6,1e300"),
    ("sweep", "tower", "--over", "height=4000:4400:401", "--engines", "exact"),
]


@pytest.mark.parametrize("words", ENDLESS, ids=" ".join)
def test_what_would_hardly_end_is_refused_with_the_cost(command, words):
    said = command(*words, status=2).err
    assert "would take" in said
    assert re.search(r"\d minutes are the limit", said)
    assert "--force" in said
    assert said.count("\n") == 1


def test_an_engine_that_is_not_here_is_missing_whatever_a_run_would_cost(harness, monkeypatch):
    # --force, which a refusal for the cost proposes, would not help
    monkeypatch.setenv("PATH", "")
    words = ("critical-angle", "--engine", "liggghts", "--contact", "plastic")
    said = [harness(*words, *more, status=3).stderr for more in ((), ("--diameter", "1e-15"))]
    assert said[0] == said[1]
    assert "would take" not in said[0]


def test_force_runs_it_all_the_same(answer):
    words = ("tower", "--height", "3", "--duration", "0.1", "--force")
    assert answer(*words)["height"] == 3
    with pytest.raises(RequestError, match="more than 1000 years"):
        check_duration(float("nan"), "it")


def test_a_long_run_is_said_beforehand(capsys):
    cost = LongRunOptions()
    cost.check_duration(50.0, "it")
    assert capsys.readouterr().err == ""
    cost.check_duration(90.0, "it")
    assert capsys.readouterr().err == "dem-harness: it: an estimated 1.5 minutes on one core\n"
    with pytest.raises(RequestError, match=r"it would take .* 15 minutes .* 10 minutes are the"):
        cost.check_duration(900.0, "it")
    LongRunOptions(force=True).check_duration(1e9, "it")
    assert "31.7 years" in capsys.readouterr().err


def test_the_usual_is_below_the_limit_in_every_engine():
    for name in ENGINES:
        rules = engine_class(name).traits
        assert angle_seconds(Incline(), "passage", rules) < MOST_SECONDS / 10
        assert angle_seconds(Incline(), "steady", rules) < MOST_SECONDS
        assert extrapolation_seconds(Incline(), rules) < MOST_SECONDS
    lammps = engine_class("lammps").traits
    for case in all_cases().values():
        for name, parameters in case.presets.items():
            if name.startswith(PUBLISHED):
                longest = (6 if case.name == "penetration" else 300) * MOST_SECONDS
                assert MOST_SECONDS < case.seconds(parameters, lammps) < longest
            else:
                assert case.seconds(parameters, lammps) < MOST_SECONDS / 10
    assert tower_seconds(Tower(height=19), "exact") < 1
    assert tower_seconds(Tower(height=100)) < 10


def test_a_passage_takes_the_steps_that_are_expected(answer):
    found = answer("critical-angle", "--engine", "reference", "--stiffness", "1e5")
    cost = Reference.traits.microseconds_per_step * 1e-6
    expected = run_seconds(Incline(stiffness=1e5), "passage", Reference.traits) / cost
    assert found["steps"] / found["runs"] == pytest.approx(expected, rel=0.1)
    assert found["runs"] == pytest.approx(RUNS_BY_PASSAGE, abs=3)


def test_the_cost_of_a_step_grows_with_the_particles():
    rules = engine_class("lammps").traits
    assert engine_seconds(1e6, 2, rules) == engine_seconds(1e6, 10, rules) == pytest.approx(1.0)
    assert engine_seconds(1e6, 1000, rules) == pytest.approx(100.0)
    assert engine_seconds(1e6, 10, Reference("adaptive").traits) == 0.0


STIFF = ("critical-angle", "--engine", "reference", "--stiffness", "1e14")
ROW = ("tower", "--height", "300000", "--duration")
SHORT = ("--height", "2000", "--duration", "1e-4")


def cpu_seconds(process):
    """Return what the main thread of a process has used of the CPU, and all others up to now."""
    whole = Path(f"/proc/{process.pid}")
    used = []
    for part in (whole / "task" / str(process.pid), whole):
        fields = (part / "stat").read_text().rpartition(")")[2].split()
        used.append((int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"))
    return used[0], used[1] - used[0]


def await_compiled_loops(process):
    """Return when nearly all goes on beside the main thread, where kernels run."""
    windows, deadline = 0, time.monotonic() + 120.0
    main, others = cpu_seconds(process)
    while windows < 2:
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.1)
        main_now, others_now = cpu_seconds(process)
        used = main_now - main + others_now - others
        if used < 0.4:
            continue  # seconds of the CPU, of which a busy machine gives few
        windows = windows + 1 if others_now - others > 0.7 * used else 0
        main, others = main_now, others_now


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "less"),
    [
        ((*ROW, "3", "--law", "overlap"), SHORT),
        (("tower", "--height", "1000", "--duration", "100", "--solver", "exact"), SHORT),
        ((*STIFF, "--integrator", "rk4"), ("--stiffness", "1e5")),
    ],
    ids=lambda words: " ".join(words),
)
def test_ctrl_c_is_heard_within_two_seconds_in_compiled_loops(harness, tmp_path, words, less):
    harness(*words, *less)  # its kernels are compiled then
    begun = subprocess.Popen(
        [sys.executable, "-m", "harness", *words, "--force"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
    )
    with begun:
        try:
            await_compiled_loops(begun)
            begun.send_signal(signal.SIGINT)
            sent = time.monotonic()
            said = begun.communicate(timeout=60)[1]
        finally:
            begun.kill()  # one that did not hear it would go on for hours
    # the machine may be shared: its scheduler is no part of what is measured
    assert time.monotonic() - sent < 4.0
    assert (begun.returncode, "interrupted" in said.splitlines()[-1]) == (130, True)


def test_the_estimate_of_a_verification_names_cases_there_are():
    assert set(SECONDS_BY_LEVEL) <= set(all_cases())
    assert all(list(seconds) == sorted(seconds) for seconds in SECONDS_BY_LEVEL.values())
    assert verification_seconds(["incline", "tower"], "default") == 32.0
    assert verification_seconds(["drag"], "full", engines=3) == 3 * OTHER_SECONDS
