"""The exact propagator against closed forms, and laws that hold for every chain."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.cases.tower import impulse as windows
from harness.cases.tower.runs import TowerRun
from harness.errors import RequestError
from harness.solvers import chain_exact
from harness.solvers.chain import forces_of_overlaps, overlaps_of_forces
from harness.solvers.chain_exact import first_root
from harness.theory import chain as theory
from tests.solvers.chain.rows import LAWS, Tower, by_modes, by_steps, chain_of, drift
from tests.theory import closed_forms


def run(case, duration, **options):
    samples = by_modes(case, duration, **options)
    return TowerRun(**vars(samples), tower=case, solver="exact")


@pytest.mark.parametrize("law", LAWS)
def test_two_free_spheres(law):
    mass, stiffness, speed = 0.02, 3e4, 0.1
    case = Tower(mass=mass, stiffness=stiffness, speed=speed, gravity=0.0, base="free", law=law)
    found = run(case, 2.0)
    assert found.final_velocity == pytest.approx([0, speed], abs=1e-10 * speed)
    contact = theory.contact_time(mass, stiffness)
    assert windows.first_contact_end(found) == pytest.approx(contact, rel=1e-10)
    peak = theory.peak_overlap(mass, stiffness, speed)
    assert windows.peak_force(found) == pytest.approx(stiffness * peak, rel=1e-9)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("gravity", [0.0, 2000.0])
def test_a_grain_on_one_fixed_particle(law, gravity):
    case, values = Tower(gravity=gravity, law=law), (1.0, 1e6, 2.0, gravity)
    found, t0 = run(case, 3.0), theory.contact_time_on_fixed(1.0, 1e6, 2.0, gravity)
    assert case.contact_time == pytest.approx(t0, rel=1e-14)
    assert windows.first_contact_end(found) == pytest.approx(t0, rel=1e-10)
    assert windows.turnaround(found) == pytest.approx(t0 / 2, rel=1e-10)
    for window in windows.WINDOWS:
        expected = theory.impulse_on_fixed(*values)
        assert windows.impulse(found, window) == pytest.approx(expected, rel=1e-10)
    peak = gravity + math.hypot(gravity, math.sqrt(1e6) * 2.0)  # m g + sqrt((m g)^2 + k m v^2)
    assert windows.peak_force(found) == pytest.approx(peak, rel=1e-10)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("particles", [3, 4, 5])
def test_free_chains_against_matrix_exponentials(law, particles):
    case = Tower(height=particles - 1, gravity=0.0, base="free", law=law)
    expected = theory.final_velocities(particles, law == "deformable")
    assert run(case, 20.0, samples=10).final_velocity / 2 == pytest.approx(expected, abs=1e-10)


def test_a_row_without_end_in_bessel_functions():
    """A row of 40: no echo is back while the grain touches."""
    case = Tower(height=40, gravity=0.0, law="overlap")
    found, rate = run(case, 1.0), 2 * case.omega
    touching = rate * found.time <= theory.DETACHMENT_TAU
    tau = rate * found.time[touching]
    velocity, force = theory.grain_velocity(tau), rate * theory.grain_force(tau)
    assert found.grain_velocity[touching] / 2 == pytest.approx(velocity, abs=1e-10)
    assert found.grain_force[touching] == pytest.approx(force, abs=1e-10 * force.max())
    end = rate * windows.first_contact_end(found)
    assert end == pytest.approx(theory.DETACHMENT_TAU, rel=1e-10)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("height", [1, 2, 3, 12])
def test_a_tower_at_rest_stays_at_rest(law, height):
    case = Tower(height=height, law=law, speed=0.0)
    chain = chain_of(case)
    overlap = closed_forms.static_overlaps(height, 1.0, 9.81, 1e6, law == "deformable")
    force = forces_of_overlaps(overlap, chain.diagonal, chain.coupling)
    assert force == pytest.approx(theory.static_forces(height, 1.0, 9.81), rel=1e-10)
    assert overlaps_of_forces(force, chain.diagonal, chain.coupling) == pytest.approx(overlap)
    chain.displacement[:-1] = np.cumsum(overlap[::-1])[::-1]
    found = chain_exact.run(chain, 0.01, samples=5)
    assert found.displacements[-1] == pytest.approx(chain.displacement, rel=1e-10)
    assert np.abs(found.final_velocity).max() < 1e-12
    assert found.grain_force == pytest.approx(9.81)


@pytest.mark.parametrize(
    ("roots", "expected"),
    [((0.3, 0.7), 0.3), ((0.5, 0.5 + 1e-6), 0.5), ((2.0,), 2.0), ((0.9, -0.2), 0.9)],
)
def test_the_first_root_of_a_polynomial(roots, expected):
    """Roots within [0, 1] of a polynomial that begins above 0; 2 stands for none."""
    coefficients = np.polynomial.polynomial.polyfromroots(roots)
    coefficients = np.pad(coefficients * np.sign(coefficients[0]), (0, 20))
    assert first_root(coefficients, 0.0, 1.0) == pytest.approx(expected, abs=1e-7)
    assert first_root(coefficients, 0.0, 0.2) == 2.0


def test_long_chains_and_strong_gravity():
    tall, short = (run(Tower(height=n), 1.0, samples=10) for n in (150, 40))
    assert tall.final_velocity[:20] == pytest.approx(short.final_velocity[:20], abs=1e-12)
    assert drift(tall) < 1e-11
    sinking = run(Tower(height=12, speed=9.81 / 300), 6.0, samples=1)
    assert sinking.time.size < 1000
    assert drift(sinking) < 1e-11


def test_what_it_cannot_do():
    with pytest.raises(RequestError, match=r"^height = 5000: must be less than 5000 .*$"):
        chain_exact.run(chain_of(Tower(height=5000)), 0.01, samples=1)
    with pytest.raises(RequestError, match=r"^duration = .* is below rounding before .*$"):
        run(Tower(height=20, speed=0.3), 1000.0, samples=10)


# ---- laws that hold for every chain, also in steps


few = settings(max_examples=8)
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


@settings(max_examples=6)  # steps are the dearest part of this room
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
    other = free.replace(stiffness=stiffness, mass=mass, speed=0.3)
    for pair in ((scaled(1e6, 1.0, 9.81), scaled(stiffness, mass, 1.62)), (free, other)):
        ends = [by_modes(case, 1.5, samples=1).final_velocity / case.speed for case in pair]
        assert ends[0] == pytest.approx(ends[1], abs=1e-9)
