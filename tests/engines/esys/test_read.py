"""Recorded output: read as it is, held against the reference DEM, and damaged."""

import re

import numpy as np
import pytest

from harness.cases.drop.parameters import Drop
from harness.cases.incline.judge import run_of_path
from harness.cases.incline.parameters import Incline
from harness.cases.tower.timing import plan
from harness.engines.esys.read import error_of, read_drop, read_paths, read_tower
from harness.engines.process import Ended
from harness.engines.reference.engine import Reference
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineMemoryError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
)
from harness.observables.provenance import Provenance
from harness.parameters.contact import PLASTIC, Contact
from harness.parameters.hertz import hertz_of_drop, hertz_of_incline
from harness.parameters.tower import Tower

WHO = Provenance("esys", "2.3.4")
INCLINE = Incline(angle=10.5, stiffness=1e5, contact=PLASTIC, steps_per_contact=50.0)
DROP = Drop(
    contact=Contact(restitution=0.5, damping_ratio=None, tail="clipped"),
    speed=1.0,
    gap=1e-4,
    steps_per_contact=200.0,
    duration=4.0,
    every=20,
)
TOWER = Tower(height=2, stiffness=1e5, law="overlap")
TIMING = plan(TOWER, 2.0, 200.0, 40)


def result(said, name):
    return float(re.search(rf"^RESULT {re.escape(name)} = (.*)$", said, re.MULTILINE).group(1))


def test_grains_side_by_side_go_where_the_reference_goes(recorded):
    cases = [INCLINE, INCLINE.replace(phase=0.5)]
    engine = Reference("mfix-euler", spring="Hertz")
    paths = read_paths(recorded("incline.csv"), 2)
    runs = engine.inclines(cases, "passage", every=50)
    said = recorded("incline.txt")
    for case, path, expected in zip(cases, paths, runs, strict=True):
        run = run_of_path(case, "passage", path, WHO, seconds=1.0, keep=True, law="Hertz")
        assert (run.motion, run.steps) == (expected.motion, expected.steps)
        assert run.margin_J == pytest.approx(expected.margin_J, abs=1e-11)
        assert f"RESULT margin_J = {run.margin_J:.17g}"[:30] in said
        for name in ("x_m", "y_m", "vx_m_per_s", "vy_m_per_s"):
            a, b = getattr(run.trajectory, name), getattr(expected.trajectory, name)
            assert np.abs(a - b).max() < 1e-11


@pytest.mark.parametrize(
    ("name", "law"),
    [("incline", hertz_of_incline(INCLINE)), ("drop", hertz_of_drop(DROP))],
)
def test_a_script_translates_the_contact_as_the_harness_does(recorded, name, law):
    said = recorded(f"{name}.txt")
    assert result(said, "hertz_coefficient_N_per_m1.5") == pytest.approx(law.coefficient, rel=1e-14)
    assert result(said, "relaxation_s") == pytest.approx(law.relaxation, rel=1e-14)


def test_a_drop_is_read_and_follows_the_reference(recorded):
    path = read_drop(DROP, recorded("drop.csv"))
    (run,) = Reference("mfix-euler", spring="Hertz").drops([DROP])
    assert np.abs(path.y_m - run.path.y_m).max() < 1e-13
    assert np.abs(path.vy_m_per_s - run.path.vy_m_per_s).max() < 1e-11


def test_a_tower_is_read_with_its_own_forces(recorded):
    run = read_tower(
        TOWER, TIMING.step, TIMING.steps // TIMING.every, recorded("tower.csv"), WHO, profiles=True
    )
    assert run.time[-1] == pytest.approx(2.0 * TOWER.contact_time, rel=1e-12)
    d = run.profiles.displacements
    overlap = np.maximum(d[:, :-1] - d[:, 1:], 0.0)
    assert np.abs(run.profiles.forces - 1e5 * overlap).max() < 1e-9 * run.grain_force.max()
    assert run.grain_velocity[0] == pytest.approx(2.0, abs=1e-12)
    # the base is fixed; the energy is the start's, up to the square of omega h
    assert np.abs(run.energy / run.energy[0] - 1.0).max() < (np.pi / 200.0) ** 2
    assert set(run.contacts) == {0.0, 1.0, 2.0}


def test_steps_are_those_that_were_planned(recorded):
    assert result(recorded("tower.txt"), "steps") == TIMING.steps
    assert result(recorded("tower.txt"), "step_s") == pytest.approx(TIMING.step, rel=1e-14)


@pytest.mark.parametrize(
    ("damage", "error", "words"),
    [
        (lambda _: "", EngineOutputError, "series of 0 lines"),
        (lambda text: text[:-20], EngineOutputError, "the last one cut"),
        (lambda text: "\n".join(text.splitlines()[:-3]) + "\n", EngineOutputError, "left .* rows"),
        (lambda text: text.replace(",0,", ",nothing,"), EngineOutputError, "incomplete series"),
        (lambda text: text.replace(",0,", ",nan,"), EngineNaNError, "not numbers"),
        (
            lambda text: "\n".join(row.rpartition(",")[0] for row in text.splitlines()) + "\n",
            EngineOutputError,
            "4 columns of 5",
        ),
    ],
    ids=["nothing", "cut row", "cut", "words", "NaN", "column"],
)
def test_damaged_series_are_named(recorded, damage, error, words):
    with pytest.raises(error, match=words):
        read_drop(DROP, damage(recorded("drop.csv")))
    with pytest.raises(error, match=r"columns|rows|lines|cut|incomplete|numbers"):
        read_tower(
            TOWER, TIMING.step, TIMING.steps // TIMING.every, damage(recorded("tower.csv")), WHO
        )


@pytest.mark.parametrize(
    ("said", "code", "late", "error", "words"),
    [
        ("refused.txt", 1, False, EngineInputError, "could not convert string to float: 'soft'"),
        ("hello", 139, False, EngineCrashError, "signal SIGSEGV"),
        ("hello", 0, False, EngineOutputError, "without a result .*hello"),
        ("drop.txt", -9, True, EngineTimeoutError, "within 7 s"),
        ("terminate called: std::bad_alloc", 134, False, EngineMemoryError, "out of memory"),
    ],
)
def test_each_bad_end_has_its_error(recorded, said, code, late, error, words):
    text = recorded(said) if said.endswith(".txt") else said
    found = error_of(Ended(text, code, 1.0, late), 7.0)
    assert isinstance(found, error)
    assert re.search(words, str(found))


def test_a_good_end_is_no_error(recorded):
    assert error_of(Ended(recorded("drop.txt"), 0, 1.0, False), 7.0) is None
