"""RK4 and the exact propagator against each other and what must hold for both."""

from __future__ import annotations

import math

import pytest

from harness.errors import RequestError
from harness.observables.tower import energy_drift, impulse_until
from harness.parameters.tower import Tower
from harness.solvers.chain import exact, rk4
from harness.theory import chain
from tests.theory.closed_forms import momentum_error

LAWS = ("overlap", "deformable")


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("particles", [3, 4, 5])
def test_free_chain(law, particles):
    case = Tower(height=particles - 1, gravity=0.0, base="free", law=law)
    expected = chain.final_velocities(particles, law == "deformable")
    duration = 20 * case.contact_time
    run = exact.run(case, duration, samples=10)
    assert run.final_velocity / 2 == pytest.approx(expected, abs=1e-10)
    assert rk4.run(case, duration).final_velocity / 2 == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("height", [1, 2, 3, 7, 19])
@pytest.mark.parametrize(("stiffness", "speed"), [(1e5, 4.0), (1e6, 2.0), (1e7, 2.0)])
def test_energy_over_three_contact_times(law, height, stiffness, speed):
    case = Tower(height=height, law=law, stiffness=stiffness, speed=speed)
    duration = 3 * case.contact_time
    assert energy_drift(exact.run(case, duration)) < 1e-11
    assert energy_drift(rk4.run(case, duration)) < 1e-6


@pytest.mark.parametrize("law", LAWS)
def test_unequal_particles(law):
    case = Tower(
        height=4,
        law=law,
        mass=(1.0, 0.3, 2.0, 0.7, 1.5),
        stiffness=(1e6, 3e5, 2e6, 8e5, 1e6),
        diameter=(1.0, 0.5, 2.0, 1.0, 0.1),
        base="free",
    )
    duration = 4 * case.contact_time
    run = exact.run(case, duration)
    assert energy_drift(run) < 1e-11
    assert momentum_error(run) < 1e-11
    stepped = rk4.run(case, duration, steps_per_contact=20_000)
    assert stepped.final_velocity == pytest.approx(run.final_velocity, abs=1e-5)


@pytest.mark.parametrize("law", LAWS)
def test_one_particle_more_than_the_source(law):
    """Height 20: the source stops at 19."""
    case = Tower(height=20, law=law)
    duration = 3 * case.contact_time
    run, reference = rk4.run(case, duration), exact.run(case, duration)
    assert run.final_velocity == pytest.approx(reference.final_velocity, abs=1e-5)
    assert impulse_until(run, duration) == pytest.approx(
        impulse_until(reference, duration), rel=1e-5
    )


@pytest.mark.parametrize("solver", [rk4.run, exact.run])
@pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf])
def test_bad_duration(solver, duration):
    with pytest.raises(RequestError, match="duration"):
        solver(Tower(), duration)
