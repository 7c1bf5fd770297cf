"""The exact propagator against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from harness.observables import tower as windows
from harness.observables.tower import energy_drift, impulse, impulse_until, peak_force
from harness.parameters.tower import Tower
from harness.solvers.chain import exact
from harness.solvers.chain.forces import forces_of_overlaps
from harness.solvers.chain.motion import assemble, overlap_of_forces
from harness.theory import chain as semi_infinite_chain
from harness.theory import chain as tower
from harness.theory import chain as two_spheres
from tests.theory import closed_forms

LAWS = ("overlap", "deformable")


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("mass", "stiffness", "speed"), [(1.0, 1e6, 2.0), (0.02, 3e4, 0.1)])
def test_two_free_spheres(law, mass, stiffness, speed):
    case = Tower(mass=mass, stiffness=stiffness, speed=speed, gravity=0.0, base="free", law=law)
    contact = two_spheres.contact_time(mass, stiffness)
    run = exact.run(case, 2 * contact)
    assert run.final_velocity == pytest.approx([0, speed], abs=1e-10 * speed)
    assert windows.first_contact_end(run) == pytest.approx(contact, rel=1e-10)
    peak = two_spheres.peak_overlap(mass, stiffness, speed)
    assert run.compression.max() == pytest.approx(peak, rel=1e-10)
    assert peak_force(run) == pytest.approx(stiffness * peak, rel=1e-10)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("gravity", [0.0, 9.81, 2000.0])
def test_grain_on_one_fixed_particle(law, gravity):
    case = Tower(gravity=gravity, law=law)
    run = exact.run(case, 3 * case.contact_time)
    values = (1.0, 1e6, 2.0, gravity)
    t0 = two_spheres.contact_time_on_fixed(*values)
    assert case.contact_time == pytest.approx(t0, rel=1e-14)
    assert windows.first_contact_end(run) == pytest.approx(t0, rel=1e-10)
    assert windows.turnaround(run) == pytest.approx(t0 / 2, rel=1e-10)
    expected = two_spheres.impulse_on_fixed(*values)
    for window in windows.WINDOWS:
        assert impulse(run, window) == pytest.approx(expected, rel=1e-10)
    assert peak_force(run) == pytest.approx(two_spheres.peak_force_on_fixed(*values), rel=1e-10)


def test_semi_infinite_chain():
    """A row of 40 is without end for the grain: no echo is back while it touches."""
    case = Tower(height=40, gravity=0.0, law="overlap")
    run = exact.run(case, case.contact_time)
    tau = 2 * case.omega * run.time
    touching = tau <= semi_infinite_chain.DETACHMENT_TAU
    velocity = semi_infinite_chain.grain_velocity(tau[touching])
    assert run.grain_velocity[touching] / 2 == pytest.approx(velocity, abs=1e-10)
    force = 2 * case.omega * semi_infinite_chain.grain_force(tau[touching])
    assert run.grain_force[touching] == pytest.approx(force, abs=1e-10 * force.max())
    end = windows.first_contact_end(run)
    assert 2 * case.omega * end == pytest.approx(semi_infinite_chain.DETACHMENT_TAU, rel=1e-10)
    ratio = impulse(run, "first-contact") / (2 * 2.0)
    assert ratio == pytest.approx(closed_forms.FIRST_CONTACT_RATIO, rel=1e-10)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("height", [1, 2, 3, 12])
def test_static_tower(law, height):
    case = Tower(height=height, law=law)
    chain = assemble(case)
    overlap = closed_forms.static_overlaps(height, 1.0, 9.81, 1e6, law == "deformable")
    force = forces_of_overlaps(overlap, chain.diagonal, chain.coupling)
    assert force == pytest.approx(tower.static_forces(height, 1.0, 9.81), rel=1e-10)
    assert overlap_of_forces(force, chain.diagonal, chain.coupling) == pytest.approx(overlap)
    chain.displacement[:-1] = np.cumsum(overlap[::-1])[::-1]
    chain.velocity[:] = 0.0
    chain.displacement[-1] = 0.0
    start = chain.displacement.copy()
    record, rows = exact.propagate(chain, exact.blank_record(8, height + 1, False), 0.01, 1)
    assert rows > 0
    assert chain.displacement == pytest.approx(start, rel=1e-10)
    assert np.abs(chain.velocity).max() < 1e-12
    assert record.rows[rows - 1, 3] == pytest.approx(9.81)


@pytest.mark.parametrize("law", LAWS)
def test_preloaded_start_rests_until_the_grain_comes(law):
    case = Tower(height=5, law=law, start="preloaded")
    run = exact.run(case, 0.02 * case.contact_time, profiles=True)
    weight = 9.81 * np.arange(5)
    assert run.profiles.forces[0] == pytest.approx(weight, abs=1e-9)
    run = exact.run(case.replace(gravity=0.0), 0.01)
    same = exact.run(case.replace(gravity=0.0, start="touching"), 0.01)
    assert run.final_velocity == pytest.approx(same.final_velocity)


def test_gapped_start():
    case = Tower(height=2, gravity=0.0, start="gapped", gap=5e-3)
    run = exact.run(case, 6 * case.contact_time)
    assert windows.touch_time(run) == pytest.approx(5e-3 / 2, rel=1e-9)
    # two parted collisions: the grain stops, then the middle particle comes back
    assert windows.first_contact_end(run) == pytest.approx(
        2.5e-3 + two_spheres.contact_time(1.0, 1e6), rel=1e-9
    )
    assert run.final_velocity == pytest.approx([-2, 0, 0], abs=1e-9)


def test_two_unequal_spheres():
    case = Tower(mass=(1.0, 3.0), stiffness=(1e6, 4e6), gravity=0.0, base="free")
    run = exact.run(case, 3 * case.contact_time)
    after = closed_forms.velocities_after((1.0, 3.0), 2.0)
    assert run.final_velocity == pytest.approx(after, abs=1e-10)
    reduced = math.sqrt(0.75 / 1.6e6)
    assert windows.first_contact_end(run) == pytest.approx(math.pi * reduced, rel=1e-10)


def test_long_chain_by_the_exact_propagator():
    case = Tower(height=150)
    run = exact.run(case, case.contact_time, samples=10)
    short = exact.run(case.replace(height=40), case.contact_time, samples=10)
    assert run.final_velocity[:20] == pytest.approx(short.final_velocity[:20], abs=1e-12)
    assert energy_drift(run) < 1e-11


def test_a_sinking_tower_does_not_stall_the_search():
    """Strong gravity: displacements far beyond compressions, events at the edge of rounding."""
    case = Tower(height=12, speed=9.81 / 300)
    run = exact.run(case, 6 * case.contact_time, samples=1)
    assert run.time.size < 1000
    assert energy_drift(run) < 1e-11


def test_impulse_is_the_integral_of_the_force():
    run = exact.run(Tower(height=3), 3 * Tower().contact_time)
    by_quadrature = np.trapezoid(run.grain_force, run.time)  # off by (omega h)^2 / 12
    assert impulse_until(run, run.time[-1]) == pytest.approx(by_quadrature, rel=1e-5)
