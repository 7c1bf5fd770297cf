"""Recorded output: read by the cases, held against the reference DEM, and damaged."""

import re

import numpy as np
import pytest

from harness.cases.drop import case as drops
from harness.cases.drop.case import Drop
from harness.cases.incline import runs as inclines
from harness.cases.incline.system import Incline
from harness.cases.tower import run as towers
from harness.cases.tower.system import timing_of
from harness.engines.esys.engine import Esys
from harness.engines.process import Ended, Limits
from harness.engines.reference import Reference
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineMemoryError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
)
from harness.parameters.law import PLASTIC, Contact, hertz
from harness.parameters.tower import Tower

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
TIMING = timing_of(TOWER, 2.0, 200.0, 40)


def result(said, name):
    return float(re.search(rf"^RESULT {re.escape(name)} = (.*)$", said, re.MULTILINE).group(1))


def test_a_grain_goes_where_the_reference_goes(output):
    engine = Reference("mfix-euler", spring="Hertz")
    (expected,) = inclines.run_inclines(engine, [INCLINE], "passage", every=50)
    run = inclines.read(INCLINE, "passage", output("incline"), "Hertz", 50)
    assert (run.motion, run.steps) == (expected.motion, expected.steps)
    assert run.margin_J == pytest.approx(expected.margin_J, abs=1e-11)
    for name in ("x_m", "y_m", "vx_m_per_s", "vy_m_per_s"):
        a, b = getattr(run.trajectory, name), getattr(expected.trajectory, name)
        assert np.abs(a - b).max() < 1e-11


@pytest.mark.parametrize(
    ("job", "law"),
    [
        (
            inclines.job_of(INCLINE, "passage"),
            hertz(INCLINE.contact, INCLINE.stiffness, INCLINE.mass, np.sqrt(9.81)),
        ),
        (drops.job_of(DROP), hertz(DROP.contact, DROP.stiffness, DROP.mass, DROP.speed)),
    ],
    ids=["incline", "drop"],
)
def test_the_engine_translates_the_contact_as_the_harness_does(job, law):
    told = Esys.__new__(Esys).task(job).values
    assert told["coefficient"] == pytest.approx(law.coefficient, rel=1e-14)
    assert told["relaxation"] == pytest.approx(law.relaxation, rel=1e-14)


def test_a_drop_is_read_and_follows_the_reference(output):
    path = drops.read(DROP, output("drop")).path
    (run,) = drops.run_drops(Reference("mfix-euler", spring="Hertz"), [DROP])
    assert np.abs(path.y_m - run.path.y_m).max() < 1e-13
    assert np.abs(path.vy_m_per_s - run.path.vy_m_per_s).max() < 1e-11


def test_a_tower_is_read_with_its_own_forces(output):
    run = towers.read(TOWER, TIMING, output("tower"), Esys.traits, profiles=True)
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
        (lambda _: "", EngineOutputError, "without rows"),
        (lambda text: text[:-20], EngineOutputError, "cut in its last row"),
        (lambda text: "\n".join(text.splitlines()[:-3]) + "\n", EngineOutputError, "left .* rows"),
        (lambda text: text.replace(",0,", ",nothing,"), EngineOutputError, "incomplete series"),
        (lambda text: text.replace(",0,", ",nan,"), EngineNaNError, "not numbers"),
        (
            lambda text: "\n".join(row.rpartition(",")[0] for row in text.splitlines()) + "\n",
            EngineOutputError,
            "no table with|left fx_N of 2",
        ),
    ],
    ids=["nothing", "cut row", "cut", "words", "NaN", "column"],
)
def test_damaged_series_are_named(output, damage, error, words):
    with pytest.raises(error, match=words):
        drops.read(DROP, output("drop", damage))
    with pytest.raises(error, match=words):
        towers.read(TOWER, TIMING, output("tower", damage), Esys.traits)


@pytest.fixture
def engine():
    """Return an engine that only tells ends apart, without ESyS-Particle."""
    engine = Esys.__new__(Esys)
    engine.limits = Limits(seconds=7.0)
    return engine


@pytest.mark.parametrize(
    ("said", "code", "late", "error", "words"),
    [
        ("refused.txt", 1, False, EngineInputError, "could not convert string to float: 'soft'"),
        ("hello", 139, False, EngineCrashError, "signal SIGSEGV"),
        ("hello\n-----", 0, False, EngineOutputError, "without a result .*hello"),
        ("drop.txt", -9, True, EngineTimeoutError, "within 7 s"),
        ("terminate called: std::bad_alloc", 134, False, EngineMemoryError, "out of memory"),
    ],
)
def test_each_bad_end_has_its_error(engine, recorded, said, code, late, error, words):
    text = recorded(said) if said.endswith(".txt") else said
    found = engine.error_of(Ended(text, code, 1.0, late), "")
    assert isinstance(found, error)
    assert re.search(words, str(found))


def test_a_good_end_is_no_error(engine, recorded):
    assert engine.error_of(Ended(recorded("drop.txt"), 0, 1.0, False), "") is None
