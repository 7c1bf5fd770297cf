"""Laws that hold for every chain."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.solvers import chain_exact
from harness.solvers.chain import forces_of_overlaps
from tests.solvers.chain.rows import LAWS, Tower, by_modes, by_steps, chain_of, drift

few = settings(max_examples=20, deadline=None)
laws = st.sampled_from(LAWS)


def spread(low, high):
    """Return a strategy for numbers whose logarithm is spread."""
    return st.floats(np.log(low), np.log(high)).map(lambda x: float(np.exp(x)))


@st.composite
def towers(draw, base=("fixed", "free"), tallest=8):
    """Draw a tower of unequal particles."""
    height = draw(st.integers(1, tallest))

    def each(low, high):
        return tuple(draw(st.lists(spread(low, high), min_size=height + 1, max_size=height + 1)))

    return Tower(
        height=height, mass=each(0.3, 3.0), stiffness=each(3e5, 3e6), diameter=each(0.5, 2.0),
        speed=draw(spread(0.1, 5.0)), gravity=draw(st.sampled_from((0.0, 9.81, 300.0))),
        law=draw(laws), base=draw(st.sampled_from(base)),
    )  # fmt: skip


@settings(max_examples=10, deadline=None)  # steps are the dearest part of this room
@given(towers())
def test_energy_is_conserved_and_the_solvers_agree(case):
    run, stepped = by_modes(case, 2.0), by_steps(case, 2.0, 8000.0)
    assert drift(run) < 1e-11
    assert drift(stepped) < 1e-5
    scale = case.speed + case.gravity * 2 * case.contact_time
    assert stepped.final_velocity == pytest.approx(run.final_velocity, abs=1e-4 * scale)


@few
@given(towers(base=("free",)))
def test_momentum_of_free_chains(case):
    duration = 3 * case.contact_time
    mass = sum(case.each("mass"))
    for run in (by_modes(case, 3.0), by_steps(case, 3.0, samples=50)):
        error = run.momentum - run.momentum[0] - mass * case.gravity * run.time
        assert np.abs(error).max() < 1e-11 * mass * (case.speed + case.gravity * duration)


@few
@given(towers())
def test_no_contact_pulls_and_positions_alone_give_the_forces(case):
    run = by_modes(case, 2.0, samples=40)
    force, chain = run.forces, chain_of(case)
    peak = force.max()
    assert force.min() > -1e-10 * peak
    for overlap, expected in zip(-np.diff(run.displacements), force, strict=True):
        found = forces_of_overlaps(overlap, chain.diagonal, chain.coupling)
        assert found == pytest.approx(expected, abs=1e-10 * peak)


@few
@given(towers())
def test_reversal_of_time(case):
    """All velocities turned round, the tower runs back to its start.

    Each change of contacts magnifies rounding: the first half of the collision alone.
    """
    chain, duration = chain_of(case), 0.7 * case.contact_time
    there = chain_exact.run(chain, duration, samples=1)
    back = chain._replace(displacement=there.displacements[-1], velocity=-there.final_velocity)
    found = chain_exact.run(back, duration, samples=1)
    assert found.displacements[-1] == pytest.approx(chain.displacement, abs=1e-8 * chain.length)
    assert -found.final_velocity == pytest.approx(chain.velocity, abs=1e-8 * case.speed)


@few
@given(laws, st.integers(1, 12), spread(1e-4, 0.1), spread(1e4, 1e8), spread(0.1, 10.0))
def test_gamma_alone_matters(law, height, gamma, stiffness, mass):
    """Equal towers of one Gamma are one tower; without gravity all are one."""

    def scaled(k, m, g):
        speed = m * g / (gamma * np.sqrt(k * m))
        return Tower(height=height, law=law, stiffness=k, mass=m, gravity=g, speed=float(speed))

    free = Tower(height=height, law=law, gravity=0.0)
    for pair in (
        (scaled(1e6, 1.0, 9.81), scaled(stiffness, mass, 1.62)),
        (free, free.replace(stiffness=stiffness, mass=mass, speed=0.3)),
    ):
        ends = [by_modes(case, 1.5, samples=1).final_velocity / case.speed for case in pair]
        assert ends[0] == pytest.approx(ends[1], abs=1e-9)


@few
@given(laws, st.integers(1, 10))
def test_a_tower_that_falls_as_one_carries_nothing(law, height):
    case = Tower(height=height, law=law, base="free", speed=0.0)
    for run in (by_modes(case, 1.0), by_steps(case, 1.0)):
        assert run.grain_force.max() == 0.0
        assert run.final_velocity == pytest.approx(9.81 * case.contact_time, rel=1e-12)
