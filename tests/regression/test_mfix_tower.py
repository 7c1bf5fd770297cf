"""MFiX-DEM's recorded forces on the grain, against the exact overlap solution.

MFiX's integrator is written out here a second time, so that its step error can
be told from a difference in physics.
"""

from __future__ import annotations

from functools import cache
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from harness.comparison.convergence import slope_order
from harness.parameters.tower import Tower
from harness.solvers.chain import exact

STIFFNESS, MASS, SPEED, GRAVITY = 1e5, 1.0, 2.0, 9.81
SAMPLE = pi * sqrt(MASS / 2 / STIFFNESS) / 50  # [s] between two rows of either file
PARTICLES = (2, 3, 5, 10)
EXACT_ROWS = 425
# eight digits of at most 999 N
FORCE_DIGITS = 0.5e-5


@cache
def recorded(factor):
    """Return MFiX's table: ``t_s`` and one force for each number of particles."""
    folder = Path(__file__).parents[1] / "engines" / "reference" / "recorded"
    path = folder / f"tower_k1e5_euler_f{factor}.csv"
    return np.genfromtxt(path, delimiter=",", names=True)


@cache
def exact_force(particles):
    """Return the exact force on the grain [N] at MFiX's times."""
    tower = Tower(
        height=particles - 1,
        stiffness=STIFFNESS,
        mass=MASS,
        speed=SPEED,
        gravity=GRAVITY,
        law="overlap",
    )
    run = exact.run(tower, (EXACT_ROWS - 1) * SAMPLE, samples=EXACT_ROWS - 1)
    wanted = SAMPLE * np.arange(EXACT_ROWS)
    nearest = np.abs(run.time[:, None] - wanted).argmin(axis=0)
    np.testing.assert_allclose(run.time[nearest], wanted, rtol=1e-12)
    return run.grain_force[nearest]


def semi_implicit_euler(particles, factor, half_kick=False):
    """Return the force on the grain [N] at every (factor / 50)-th step of contact time / factor.

    With ``half_kick`` the first velocities are taken back by half a step, which
    makes it the leapfrog scheme.
    """
    every = factor // 50
    step = SAMPLE / every
    position, velocity = np.zeros(particles), np.zeros(particles)
    velocity[0] = SPEED
    if half_kick:
        velocity[:-1] -= 0.5 * step * GRAVITY  # nothing else acts at the start
    result = []
    for _ in range((EXACT_ROWS - 1) * every + 1):
        force = STIFFNESS * np.maximum(position[:-1] - position[1:], 0.0)
        result.append(force[0])
        acceleration = np.full(particles, GRAVITY)
        acceleration[:-1] -= force / MASS
        acceleration[1:] += force / MASS
        acceleration[-1] = 0.0  # the last particle is held
        velocity += step * acceleration
        position += step * velocity
    return np.array(result[::every])


@pytest.mark.parametrize("particles", PARTICLES)
def test_fine_step_meets_the_exact_solution(particles):
    force, expected = recorded(5000)[f"F_top_N{particles}"], exact_force(particles)
    assert np.abs(force - expected).max() < 2e-4 * expected.max()


@pytest.mark.parametrize("factor", [50, 5000])
@pytest.mark.parametrize("particles", PARTICLES)
def test_its_integrator_gives_each_series_to_the_last_digit(particles, factor):
    force = recorded(factor)[f"F_top_N{particles}"]
    assert np.abs(force - semi_implicit_euler(particles, factor)).max() <= FORCE_DIGITS


def errors_at(particles, factors, **how):
    """Return the largest force errors over the peak."""
    expected = exact_force(particles)
    return [
        np.abs(semi_implicit_euler(particles, int(f), **how) - expected).max() / expected.max()
        for f in factors
    ]


@pytest.mark.parametrize("particles", [5, 10])
def test_its_integrator_converges_to_the_exact_solution_at_first_order(particles):
    factors = np.array([200, 400, 800, 1600])
    errors = errors_at(particles, factors)
    order, (low, high) = slope_order(1 / factors, errors)
    assert low < 1 < high
    assert order == pytest.approx(1, abs=0.05)
    # and the recorded fine run lies on the same line
    fine = np.abs(recorded(5000)[f"F_top_N{particles}"] - exact_force(particles)).max()
    assert fine / exact_force(particles).max() == pytest.approx(errors[-1] * 1600 / 5000, rel=0.05)


@pytest.mark.parametrize("particles", [2, 3])
def test_the_first_order_is_gravity_in_the_first_half_step(particles):
    """Velocities belong to half a step earlier: taken so, the scheme is of second order."""
    factors = np.array([50, 100, 200, 400, 800])
    order, (low, high) = slope_order(1 / factors, errors_at(particles, factors, half_kick=True))
    assert low < 2.1
    assert high > 1.9
    assert order == pytest.approx(2, abs=0.2)
