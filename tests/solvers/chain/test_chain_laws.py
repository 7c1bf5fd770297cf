"""Laws that must hold for every chain."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.observables.tower import energy_drift, impulse
from harness.parameters.tower import Tower
from harness.solvers.chain import exact, rk4
from harness.solvers.chain.forces import forces_of_overlaps
from harness.solvers.chain.motion import assemble
from tests.theory.closed_forms import momentum_error

few = settings(max_examples=25, deadline=None)
laws = st.sampled_from(["overlap", "deformable"])


def spread(low, high):
    """Return a strategy for numbers whose logarithm is spread."""
    return st.floats(np.log(low), np.log(high)).map(lambda x: float(np.exp(x)))


@st.composite
def towers(draw, base=("fixed", "free"), gravity=(0.0, 9.81, 300.0), tallest=8):
    """Draw a tower of unequal particles."""
    height = draw(st.integers(1, tallest))
    size = height + 1

    def each(low, high):
        return tuple(draw(st.lists(spread(low, high), min_size=size, max_size=size)))

    return Tower(
        height=height,
        mass=each(0.3, 3.0),
        stiffness=each(3e5, 3e6),
        diameter=each(0.5, 2.0),
        speed=draw(spread(0.1, 5.0)),
        gravity=draw(st.sampled_from(gravity)),
        law=draw(laws),
        base=draw(st.sampled_from(base)),
    )


@few
@given(towers())
def test_energy(case):
    duration = 3 * case.contact_time
    assert energy_drift(exact.run(case, duration)) < 1e-11
    assert energy_drift(rk4.run(case, duration, steps_per_contact=8000)) < 1e-5


@few
@given(towers(base=("free",)))
def test_momentum_and_third_law(case):
    duration = 3 * case.contact_time
    scale = sum(case.each("mass")) * (case.speed + case.gravity * duration)
    for run in (exact.run(case, duration, profiles=True), rk4.run(case, duration, samples=50)):
        assert momentum_error(run) < 1e-11 * scale
    # what a contact gives to one particle it takes from the other
    run = exact.run(case, duration, samples=20, profiles=True)
    force = np.pad(run.profiles.forces, ((0, 0), (1, 1)))
    pushes = force[:, :-1] - force[:, 1:]
    assert np.abs(pushes.sum(axis=1)).max() <= 1e-12 * max(force.max(), 1)


@few
@given(towers())
def test_no_contact_pulls_and_deformations_add_up(case):
    run = exact.run(case, 2 * case.contact_time, samples=40, profiles=True)
    force, peak = run.profiles.forces, run.profiles.forces.max()
    assert force.min() > -1e-10 * peak
    chain = assemble(case)
    overlaps = -np.diff(run.profiles.displacements, axis=1)
    for state, expected in zip(overlaps, force, strict=True):
        found = forces_of_overlaps(state, chain.diagonal, chain.coupling)
        assert found == pytest.approx(expected, abs=1e-10 * peak)


@few
@given(towers())
def test_reversal_of_time(case):
    """Turn all velocities round and the tower runs back to where it began.

    An elastic chain amplifies rounding at each change of contacts, so this is
    asked of the first half of the collision.
    """
    chain = assemble(case)
    start = chain.displacement.copy(), chain.velocity.copy()
    duration = 0.7 * case.contact_time
    for _ in range(2):
        record = exact.blank_record(64, case.particles, False)
        _, rows = exact.propagate(chain, record, duration, 1)
        assert rows > 0
        chain.velocity[:] *= -1
    assert chain.displacement == pytest.approx(start[0], abs=1e-8 * chain.length)
    assert chain.velocity == pytest.approx(start[1], abs=1e-8 * case.speed)


@few
@given(laws, st.integers(1, 12), spread(1e-4, 0.1), spread(1e4, 1e8), spread(0.1, 10.0))
def test_gamma_alone_matters(law, height, gamma, stiffness, mass):
    """Equal towers of one Gamma are one tower: impulses in m v0, times in t0.

    Each change of contacts magnifies rounding, hence 1.5 t0 for the velocities.
    """

    def scaled(k, m, g):
        speed = m * g / (gamma * np.sqrt(k * m))
        return Tower(height=height, law=law, stiffness=k, mass=m, gravity=g, speed=float(speed))

    runs = []
    for case in (scaled(1e6, 1.0, 9.81), scaled(stiffness, mass, 1.62)):
        assert case.gamma == pytest.approx(gamma)
        end = exact.run(case, 1.5 * case.contact_time, samples=1).final_velocity
        run = exact.run(case, 6 * case.contact_time, samples=4000)
        runs.append((end / case.speed, impulse(run) / (case.speed * mass_of(case))))
    assert runs[0][0] == pytest.approx(runs[1][0], abs=1e-9)
    assert runs[0][1] == pytest.approx(runs[1][1], rel=1e-9)


def mass_of(case):
    return case.each("mass")[0]


@few
@given(laws, st.integers(1, 12), spread(1e4, 1e8), spread(0.1, 10.0), spread(0.1, 10.0))
def test_without_gravity_the_scale_is_all(law, height, stiffness, mass, speed):
    base = Tower(height=height, law=law, gravity=0.0)
    other = base.replace(stiffness=stiffness, mass=mass, speed=speed)
    ends = [
        exact.run(c, 3 * c.contact_time, samples=1).final_velocity / c.speed for c in (base, other)
    ]
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


@few
@given(towers())
def test_solvers_agree(case):
    duration = 2 * case.contact_time
    end = exact.run(case, duration, samples=1).final_velocity
    stepped = rk4.run(case, duration, steps_per_contact=8000, samples=1).final_velocity
    assert stepped == pytest.approx(end, abs=1e-4 * (case.speed + case.gravity * duration))


@few
@given(laws, st.integers(1, 10))
def test_equal_free_fall_is_not_touched(law, height):
    """A tower without base that falls as one carries nothing."""
    case = Tower(height=height, law=law, base="free", speed=0.0)
    for solver in (exact.run, rk4.run):
        run = solver(case, case.contact_time)
        assert run.grain_force.max() == 0
        assert run.final_velocity == pytest.approx(9.81 * case.contact_time, rel=1e-12)
