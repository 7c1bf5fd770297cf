"""The exact propagator against closed forms."""

import math

import numpy as np
import pytest

from harness.cases.tower import impulse as windows
from harness.cases.tower.runs import TowerRun
from harness.errors import RequestError
from harness.solvers import chain_exact
from harness.solvers.chain import forces_of_overlaps, overlaps_of_forces
from harness.solvers.chain_exact import first_root
from harness.theory import chain as theory
from tests.solvers.chain.rows import LAWS, Tower, by_modes, chain_of, drift
from tests.theory import closed_forms


def run(case, duration, **options):
    samples = by_modes(case, duration, **options)
    return TowerRun(**vars(samples), tower=case, solver="exact")


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("mass", "stiffness", "speed"), [(1.0, 1e6, 2.0), (0.02, 3e4, 0.1)])
def test_two_free_spheres(law, mass, stiffness, speed):
    case = Tower(mass=mass, stiffness=stiffness, speed=speed, gravity=0.0, base="free", law=law)
    found = run(case, 2.0)
    contact = theory.contact_time(mass, stiffness)
    assert found.final_velocity == pytest.approx([0, speed], abs=1e-10 * speed)
    assert windows.first_contact_end(found) == pytest.approx(contact, rel=1e-10)
    peak = theory.peak_overlap(mass, stiffness, speed)
    assert windows.peak_force(found) == pytest.approx(stiffness * peak, rel=1e-9)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("gravity", [0.0, 9.81, 2000.0])
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
    found = run(case, 1.0)
    tau = 2 * case.omega * found.time
    touching = tau <= theory.DETACHMENT_TAU
    velocity = theory.grain_velocity(tau[touching])
    assert found.grain_velocity[touching] / 2 == pytest.approx(velocity, abs=1e-10)
    force = 2 * case.omega * theory.grain_force(tau[touching])
    assert found.grain_force[touching] == pytest.approx(force, abs=1e-10 * force.max())
    end = 2 * case.omega * windows.first_contact_end(found)
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


def test_a_gapped_start_is_two_collisions():
    """The grain stops, then the middle particle comes back."""
    case = Tower(height=2, gravity=0.0, start="gapped", gap=5e-3)
    found = run(case, 6.0)
    assert windows.touch_time(found) == pytest.approx(2.5e-3, rel=1e-9)
    end = 2.5e-3 + theory.contact_time(1.0, 1e6)
    assert windows.first_contact_end(found) == pytest.approx(end, rel=1e-9)
    assert found.final_velocity == pytest.approx([-2, 0, 0], abs=1e-9)


def test_two_unequal_spheres():
    case = Tower(mass=(1.0, 3.0), stiffness=(1e6, 4e6), gravity=0.0, base="free")
    found = run(case, 3.0)
    after = closed_forms.velocities_after((1.0, 3.0), 2.0)
    assert found.final_velocity == pytest.approx(after, abs=1e-10)
    contact = math.pi * math.sqrt(0.75 / 1.6e6)
    assert windows.first_contact_end(found) == pytest.approx(contact, rel=1e-10)


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
    tall = run(Tower(height=150), 1.0, samples=10)
    short = run(Tower(height=40), 1.0, samples=10)
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
