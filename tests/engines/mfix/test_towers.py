"""Towers in MFiX's stand-in, against MFiX's scheme written out and the exact solution."""

from math import pi, sqrt

import numpy as np
import pytest

from harness.cases.tower.run import run_towers
from harness.cases.tower.system import start_displacements, timing_of
from harness.comparison.convergence import slope_order
from harness.errors import EngineOutputError
from harness.observables.tower import turnaround
from harness.parameters.tower import Tower
from harness.solvers.chain import exact

K, SINGLE = 1e5, 2.0**-23


def tower(**changes):
    return Tower(**{"height": 2, "stiffness": K, "law": "overlap", **changes})


def scheme(case, step, steps):
    """Return displacements, velocities and forces at every step of semi-implicit Euler."""
    x, v = np.array(start_displacements(case)), np.zeros(case.particles)
    v[0] = case.speed
    places, speeds, forces = [], [], []
    for _ in range(steps + 1):
        force = K * np.maximum(x[:-1] - x[1:], 0.0)
        places.append(x.copy())
        speeds.append(v.copy())
        forces.append(force)
        acceleration = case.gravity - np.diff(np.pad(-force, 1)) * -1.0
        if case.base == "fixed":
            acceleration[-1] = 0.0
        v = v + step * acceleration
        x = x + step * v
    return np.array(places), np.array(speeds), np.array(forces)


CASES = [
    tower(height=1),
    tower(),
    tower(height=4),
    tower(base="free"),
    tower(base="free", gravity=0.0, height=3),
    tower(start="preloaded", height=4),
    tower(start="gapped", gap=0.002),
]


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c.height}-{c.base}-{c.start}-{c.gravity}")
def test_a_tower_is_mfix_s_scheme_sample_by_sample(stand_in, case):
    duration, fineness, samples = 3.0, 100.0, 100
    (run,) = run_towers(
        stand_in(), [case], duration, steps_per_contact=fineness, samples=samples, profiles=True
    )
    timing = timing_of(case, duration, fineness, samples)
    places, speeds, forces = scheme(case, timing.step, timing.steps)
    taken = np.rint(run.time / timing.step).astype(int)
    assert taken[0] == 0
    assert taken[-1] == timing.steps
    assert run.time == pytest.approx(taken * timing.step, rel=1e-12, abs=1e-15)
    assert np.all(np.diff(taken) == timing.every)
    box = case.height + 3.0
    assert np.abs(run.profiles.displacements - places[taken]).max() < box * SINGLE
    assert np.abs(run.profiles.velocities - speeds[taken]).max() < 3 * 2.0 * SINGLE
    assert np.abs(run.profiles.forces - forces[taken]).max() < 2 * SINGLE * forces.max()
    assert np.array_equal(run.profiles.forces > 0.0, forces[taken] > 0.0)


@pytest.mark.parametrize(
    ("case", "claimed"),
    [
        (tower(height=1, gravity=0.0), 2.0),
        (tower(height=2, gravity=0.0), 2.0),
        (tower(height=4), 1.0),
    ],
    ids=["1, g = 0", "2, g = 0", "4"],
)
def test_a_tower_converges_to_the_exact_one(stand_in, case, claimed):
    """Of second order, but for gravity in the first half step: velocities belong half a step back.

    In lower towers that first-order error is too small to show at these steps.
    """
    steps = np.array([50.0, 100.0, 200.0] if claimed == 2.0 else [100.0, 200.0, 400.0])
    expected = exact.run(case, 3.0 * case.contact_time, samples=6000)
    engine = stand_in()
    errors = []
    for fineness in steps:
        (run,) = run_towers(engine, [case], 3.0, steps_per_contact=fineness, samples=300)
        force = np.interp(run.time, expected.time, expected.grain_force)
        errors.append(np.abs(run.grain_force - force).max())
    order, (low, high) = slope_order(1 / steps, errors)
    assert low < claimed < high
    assert order == pytest.approx(claimed, abs=0.2)


def test_the_step_is_the_plan_s(stand_in):
    case = tower()
    (run,) = run_towers(stand_in(), [case], 1.0, steps_per_contact=50.0)
    assert run.step == pytest.approx(pi * sqrt(1.0 / K) / 50.0, rel=0.02)
    assert run.time[-1] == pytest.approx(case.contact_time, rel=1e-12)


def test_every_step_can_be_written(stand_in):
    """The frame of the first step and that of the start tell of one state."""
    case = tower()
    (run,) = run_towers(stand_in(), [case], 0.5, steps_per_contact=50.0, samples=10_000)
    timing = timing_of(case, 0.5, 50.0, 10_000)
    assert timing.every == 1
    assert run.time == pytest.approx(timing.step * np.arange(timing.steps + 1), rel=1e-12)
    _, _, forces = scheme(case, timing.step, timing.steps)
    assert np.abs(run.grain_force - forces[:, 0]).max() < 2 * SINGLE * forces.max()


def test_a_search_with_cells_of_less_than_two_diameters_is_told(stand_in, monkeypatch):
    """As in MFiX without the keywords: the grain falls through and nothing ever presses."""
    monkeypatch.setattr("harness.engines.mfix.engine.SEARCH_CELL", 1.5)
    (run,) = run_towers(stand_in(), [tower()], 1.0, steps_per_contact=50.0)
    assert isinstance(run, EngineOutputError)
    assert "no contact of the tower ever presses" in str(run)


def test_the_impulse_does_not_feel_single_precision(stand_in):
    """The sample of largest compression is some samples away from where the rate turns."""
    case = tower()
    (run,) = run_towers(stand_in(), [case], 3.0, steps_per_contact=400.0, samples=3000)
    expected = exact.run(case, 3.0 * case.contact_time, samples=6000)
    # the scheme's velocities belong half a step back
    assert turnaround(run) - 0.5 * run.step == pytest.approx(
        turnaround(expected), abs=0.2 * run.step
    )
