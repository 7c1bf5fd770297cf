"""RK4 and the exact propagator against closed forms, each other, and bad requests."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import linregress
from scipy.stats import t as student

from harness.chain import exact, rk4, stability
from harness.chain.arrays import assemble, overlap_of_forces
from harness.chain.complementarity import factorise, forces_of_overlaps
from harness.chain.modes import decompose
from harness.chain.record import blank_record
from harness.comparison.convergence import slope_order
from harness.errors import RequestError
from harness.observables import windows
from harness.observables.impulse import impulse, impulse_until
from harness.observables.summary import energy_drift, momentum_error, peak_force
from harness.parameters.tower import Tower
from harness.theory import free_chain, semi_infinite_chain, tower, two_spheres

LAWS = ("overlap", "deformable")


def order(sizes, errors):
    """Return the slope of log error against log size, and half its 95 % interval."""
    fit = linregress(np.log(sizes), np.log(errors))
    return fit.slope, fit.stderr * student.ppf(0.975, len(sizes) - 2)


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


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("particles", [3, 4, 5])
def test_free_chain(law, particles):
    case = Tower(height=particles - 1, gravity=0.0, base="free", law=law)
    expected = free_chain.final_velocities(particles, law == "deformable")
    duration = 20 * case.contact_time
    run = exact.run(case, duration, samples=10)
    assert run.final_velocity / 2 == pytest.approx(expected, abs=1e-10)
    assert rk4.run(case, duration).final_velocity / 2 == pytest.approx(expected, abs=2e-6)


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
    assert ratio == pytest.approx(semi_infinite_chain.FIRST_CONTACT_RATIO, rel=1e-10)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("height", [1, 2, 3, 12])
def test_static_tower(law, height):
    case = Tower(height=height, law=law)
    chain = assemble(case)
    overlap = tower.static_overlaps(height, 1.0, 9.81, 1e6, law == "deformable")
    force = forces_of_overlaps(overlap, chain.diagonal, chain.beside)
    assert force == pytest.approx(tower.static_forces(height, 1.0, 9.81), rel=1e-10)
    assert overlap_of_forces(force, chain.diagonal, chain.beside) == pytest.approx(overlap)
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


@pytest.mark.parametrize("height", [1, 2, 7, 30])
def test_modes_of_the_overlap_tower(height):
    case = Tower(height=height, law="overlap")
    chain = assemble(case)
    n = height
    closed, factor = np.ones(n, bool), np.zeros((3, n))
    factorise(closed, chain.diagonal, chain.beside, factor)
    shapes, frequency, first = np.zeros((n + 1, n + 1)), np.zeros(n + 1), np.zeros(n + 1)
    highest = decompose(chain, closed, factor, shapes, frequency, first)
    expected = tower.overlap_modes(height, case.omega)
    assert frequency[:n] == pytest.approx(expected, rel=1e-10)
    assert highest == pytest.approx(expected[-1], rel=1e-10)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("height", [1, 2, 5, 40])
def test_stability_bound_holds_and_is_close(law, base, height):
    rng = np.random.default_rng(height)
    equal = Tower(height=height, law=law, base=base, gravity=0.0)
    unequal = equal.replace(
        mass=tuple(rng.uniform(0.5, 2, height + 1)),
        stiffness=tuple(rng.uniform(5e5, 2e6, height + 1)),
    )
    for case in (equal, unequal):
        chain = assemble(case)
        closed, factor = np.ones(height, bool), np.zeros((3, height))
        factorise(closed, chain.diagonal, chain.beside, factor)
        size = height + 1
        highest = decompose(
            chain, closed, factor, np.zeros((size, size)), np.zeros(size), np.zeros(size)
        )
        bound = stability.highest_frequency(case)
        assert highest <= bound * (1 + 1e-12)
        if case is equal and height == 40:
            assert highest > 0.97 * bound


def test_rk4_is_unstable_beyond_the_bound():
    """A tower that stays touching, just below the bound and 3 % above the true one."""
    case = Tower(height=40, law="overlap", start="preloaded", speed=1e-6)
    bound = stability.largest_step(case)
    run = rk4.run(case, 400 * bound, step=0.99 * bound)
    assert run.energy.max() - run.energy[0] < 1e-12
    with pytest.raises(RequestError, match=r"step = .*must be .*less than 0\.00141421"):
        rk4.run(case, 400 * bound, step=1.03 * bound)


@pytest.mark.parametrize("law", LAWS)
def test_order_four_while_contacts_stay(law):
    """A tower at rest under a grain that starts to press: no contact changes."""
    case = Tower(height=5, law=law, start="preloaded", speed=0.005)
    duration = 0.4 * case.contact_time
    reference = exact.run(case, duration, samples=1)
    assert len(reference.time) <= 4
    counts = np.array([40, 60, 90, 135, 200, 300])
    errors = [
        np.abs(
            rk4.run(case, duration, step=duration / n).final_velocity - reference.final_velocity
        ).max()
        for n in counts
    ]
    slope, half = order(1 / counts, errors)
    print(f"\n{law}: order {slope:.3f} +- {half:.3f} (95 %)")
    assert abs(slope - 4) < max(half, 0.1)


@pytest.mark.parametrize("law", LAWS)
def test_order_across_an_onset(law):
    """A kink of the force inside a step costs two orders; where in the step makes it scatter."""
    case = Tower(height=3, law=law)
    duration = 3 * case.contact_time
    reference = exact.run(case, duration, samples=1)
    counts = np.unique(np.geomspace(600, 20_000, 60).astype(int))
    errors = [
        np.abs(
            rk4.run(case, duration, step=duration / n, samples=10).final_velocity
            - reference.final_velocity
        ).max()
        for n in counts
    ]
    slope, half = order(1 / counts, errors)
    print(f"\n{law}: order {slope:.2f} +- {half:.2f} (95 %)")
    assert slope - half > 1.6
    assert slope + half < 2.8


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("height", [1, 2, 3, 7, 19])
@pytest.mark.parametrize(("stiffness", "speed"), [(1e5, 4.0), (1e6, 2.0), (1e7, 2.0)])
def test_energy_over_three_contact_times(law, height, stiffness, speed):
    case = Tower(height=height, law=law, stiffness=stiffness, speed=speed)
    duration = 3 * case.contact_time
    assert energy_drift(exact.run(case, duration)) < 1e-11
    assert energy_drift(rk4.run(case, duration)) < 1e-6


def test_order_of_the_energy_drift_while_contacts_stay():
    """Fifth: RK4 damps a mode by (omega h)^6/144 a step."""
    case = Tower(height=1, law="overlap", gravity=0.0)
    counts = np.array([20, 28, 40, 56, 80])
    drifts = [
        energy_drift(rk4.run(case, 0.9 * case.contact_time, step=0.9 * case.contact_time / n))
        for n in counts
    ]
    slope, half = order(1 / counts, drifts)
    print(f"\nenergy drift, contacts stay: order {slope:.2f} +- {half:.2f} (95 %)")
    assert abs(slope - 5) < max(half, 0.3)


@pytest.mark.parametrize("law", LAWS)
def test_order_of_the_energy_drift_across_onsets(law):
    """Second: an onset at a fraction q of a step, closing at speed s, misses energy.

    The step weighs the force k s (t - q h) by Simpson's rule, 1/6, 2/3 and 1/6 at its
    start, middle and end, instead of integrating it to k s h^2 (1 - q)^2/2: the
    impulse is off by k s h^2 (q/6 - q^2/2) for q < 1/2, (1 - q)/6 - (1 - q)^2/2 beyond,
    and the energy by s times that. Where in its step each onset falls makes it scatter.
    """
    case = Tower(height=3, law=law)
    duration = 3 * case.contact_time
    counts = np.unique(np.geomspace(600, 20_000, 60).astype(int))
    drifts = [energy_drift(rk4.run(case, duration, step=duration / n)) for n in counts]
    slope, (low, high) = slope_order(1 / counts, drifts)
    print(f"\n{law}: energy drift across onsets: order {slope:.2f} [{low:.2f}, {high:.2f}]")
    assert low < 2 < high
    assert high - low < 0.5


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


def test_two_unequal_spheres():
    case = Tower(mass=(1.0, 3.0), stiffness=(1e6, 4e6), gravity=0.0, base="free")
    run = exact.run(case, 3 * case.contact_time)
    after = two_spheres.velocities_after((1.0, 3.0), 2.0)
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


def stepped(chain, step, steps):
    """Return displacements and velocities after RK4, each force from a cold start."""

    def acceleration(u):
        force = forces_of_overlaps(u[:-1] - u[1:], chain.diagonal, chain.beside)
        push = np.concatenate(([0.0], force))
        return (push - np.concatenate((force, [0.0]))) * chain.mobility + chain.gravity

    u, v = chain.displacement.copy(), chain.velocity.copy()
    for _ in range(steps):
        a = acceleration(u)
        b = acceleration(u + step / 2 * v)
        c = acceleration(u + step / 2 * v + step**2 / 4 * a)
        d = acceleration(u + step * v + step**2 / 2 * b)
        u = u + step * v + step**2 / 6 * (a + b + c)
        v = v + step / 6 * (a + 2 * (b + c) + d)
    return u, v


@pytest.mark.parametrize("particles", [300, 700, 1500])
@pytest.mark.parametrize("start", ["moving", "pressed", "cut closes"])
def test_blocks_of_a_long_row(particles, start):
    """Block by block or at once: random motion, no place to part, and a contact parted in vain."""
    chain = assemble(Tower(height=particles - 1, gravity=0.0))
    rng = np.random.default_rng(particles)
    if start == "moving":
        chain.velocity[:-1] = rng.normal(0, 0.5, particles - 1)
    elif start == "pressed":
        chain.displacement[:] = np.linspace(0.0, -1e-5 * particles, particles)
        chain.velocity[:-1] = rng.normal(0, 1e-3, particles - 1)
    else:  # what was chosen to part blocks of 256 closes within the first step
        chain.gravity[:256], chain.gravity[256:-1] = 1e3, -1e3
    step, steps = 1e-5, 60
    u, v = stepped(chain, step, steps)
    _, rows = rk4.integrate(chain, blank_record(3, particles, False), step, steps, 20, particles)
    assert rows > 0
    scale = max(np.abs(u).max(), 1e-6)
    assert chain.displacement == pytest.approx(u, abs=1e-11 * scale)
    assert chain.velocity == pytest.approx(v, abs=1e-11 * max(np.abs(v).max(), scale / step))


def test_particles_that_nothing_touches_fall_alike():
    """To the last bit, across the ends of blocks: else contacts would close at random."""
    case = Tower(height=20_000)
    run = rk4.run(case, 3e-4, step=3e-6, samples=1, longest_chain=60)
    assert np.unique(run.final_velocity[100:-100]).size == 1
    assert np.unique(run.final_displacement[100:-100]).size == 1


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


@pytest.mark.slow
@pytest.mark.parametrize(("law", "particles"), [("overlap", 1_000_000), ("deformable", 20_001)])
def test_a_long_row_until_the_pulse_is_inside(law, particles):
    """The grain cannot tell it from a row of 61: no echo is back."""
    case = Tower(height=particles - 1, law=law)
    duration, steps = 1.2 * case.contact_time, 400
    run = rk4.run(case, duration, step=duration / steps, samples=4, longest_chain=40)
    small = rk4.run(case.replace(height=60), duration, step=duration / steps, samples=4)
    assert run.step == small.step
    assert run.final_velocity[:10] == pytest.approx(small.final_velocity[:10], abs=1e-9)
    assert impulse_until(run, duration) == pytest.approx(impulse_until(small, duration), rel=1e-9)
    assert abs(run.energy[-1] - run.energy[0]) < 1e-4 * run.kinetic_energy[0]


@pytest.mark.parametrize("law", LAWS)
def test_a_million_particles(law):
    case = Tower(height=999_999, law=law)
    step = 1e-5
    run = rk4.run(case, 20 * step, step=step, samples=1, longest_chain=60)
    small = rk4.run(case.replace(height=30), 20 * step, step=step, samples=1)
    assert run.final_velocity[:10] == pytest.approx(small.final_velocity[:10], abs=1e-14)


def test_longest_chain_is_watched():
    case = Tower(height=30)
    with pytest.raises(RequestError, match="longest_chain = 1: 2 contacts touch"):
        rk4.run(case, case.contact_time, longest_chain=1)


def test_samples_are_not_all_steps():
    case = Tower(height=3)
    run = rk4.run(case, 3 * case.contact_time, steps_per_contact=50_000, samples=30)
    assert run.time.size < 60
    assert run.time[-1] == pytest.approx(3 * case.contact_time)
    assert (np.diff(run.time) >= 0).all()


@pytest.mark.parametrize("solver", [rk4.run, exact.run])
@pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf])
def test_bad_duration(solver, duration):
    with pytest.raises(RequestError, match="duration"):
        solver(Tower(), duration)


@pytest.mark.parametrize(
    "values",
    [
        {"step": 0.0},
        {"step": -1e-6},
        {"step": math.nan},
        {"step": 1.0},
        {"steps_per_contact": 0.0},
        {"steps_per_contact": -5.0},
        {"steps_per_contact": 2.0},
        {"steps_per_contact": math.nan},
        {"step": 1e-6, "steps_per_contact": 100.0},
        {"samples": 0},
        {"longest_chain": 0},
    ],
)
def test_bad_steps(values):
    with pytest.raises(RequestError, match=next(iter(values))):
        rk4.run(Tower(height=19), 0.01, **values)


def test_impulse_is_the_integral_of_the_force():
    run = exact.run(Tower(height=3), 3 * Tower().contact_time)
    by_quadrature = np.trapezoid(run.grain_force, run.time)  # off by (omega h)^2 / 12
    assert impulse_until(run, run.time[-1]) == pytest.approx(by_quadrature, rel=1e-5)


def test_a_preloaded_row_is_held_to_its_longest_chain():
    case = Tower(height=9, start="preloaded")
    with pytest.raises(RequestError, match="longest_chain = 3"):
        rk4.run(case, case.contact_time, longest_chain=3)
