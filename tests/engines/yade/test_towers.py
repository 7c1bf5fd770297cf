import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.cases.tower.run import run_towers, tower
from harness.observables.windows import impulse
from harness.parameters.tower import Tower

pytestmark = [pytest.mark.live, pytest.mark.slow]

DURATION = 4.0
"""[t0] the turnaround window of tall towers ends at 2.6 t0 and is searched within 3."""

SOFT = {"law": "overlap", "stiffness": 1e5}


def exact(case, samples):
    return tower(case, solver="exact", duration=DURATION, samples=samples)


def test_peak_force_and_impulse_against_the_exact_propagator(yade):
    cases = [Tower(height=height, **SOFT) for height in (1, 2, 4, 9, 19)]
    # 10,000 steps per contact are steps of 1e-6 s, written often enough to see the peak
    runs = run_towers(yade, cases, DURATION, steps_per_contact=10_000.0, samples=8000)
    for case, run in zip(cases, runs, strict=True):
        truth = exact(case, 8000)
        assert run.grain_force.max() == pytest.approx(truth.grain_force.max(), rel=2e-5)
        assert impulse(run) == pytest.approx(impulse(truth), rel=2e-5)


def test_closed_contact_gives_second_order(yade):
    """While no contact opens, the leapfrog's error falls with the square of the step."""
    case = Tower(height=2, **SOFT)
    truth = impulse(exact(case, 8000))
    steps = np.array([250.0, 500.0, 1000.0, 2000.0])
    errors = [
        abs(
            impulse(run_towers(yade, [case], DURATION, steps_per_contact=n, samples=8000)[0])
            - truth
        )
        for n in steps
    ]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.02)


CHANGES = [
    {"base": "free", "gravity": 0.0},
    {"start": "preloaded"},
    {"start": "gapped", "gap": 1e-3},
    {"diameter": 0.1, "mass": 0.02, "speed": 0.5},
]


def test_bases_starts_and_sizes_against_the_exact_propagator(yade):
    cases = [Tower(height=4, **{**SOFT, **change}) for change in CHANGES]
    runs = run_towers(yade, cases, DURATION, steps_per_contact=4000.0, profiles=True)
    for case, run in zip(cases, runs, strict=True):
        truth = tower(case, solver="exact", duration=DURATION, samples=40_000, profiles=True)
        expected = [np.interp(run.time, truth.time, v) for v in truth.profiles.velocities.T]
        # a leapfrog turns by omega_max t, omega_max = 2 omega, with an error of
        # (omega_max h)^2 / 24 of it; twice that, for contacts that begin within a step
        width = 4.0 * np.pi * DURATION * (2.0 * np.pi / 4000.0) ** 2 / 24.0 * case.speed
        assert_allclose(run.profiles.velocities, np.transpose(expected), rtol=0.0, atol=width)


def test_a_preloaded_tower_below_a_grain_that_rests_stays_at_rest(yade):
    case = Tower(height=5, start="preloaded", speed=0.0, **SOFT)
    (run,) = run_towers(yade, [case], 0.01, steps_per_contact=500.0, profiles=True)
    # nothing holds the grain yet: it falls freely, and the particles below do not feel it yet
    assert run.grain_velocity[1] == pytest.approx(9.81 * run.time[1], rel=1e-3)
    weights = 9.81 * np.arange(1, 5)
    assert run.profiles.forces[0] == pytest.approx([0.0, *weights], abs=1e-9)
