"""Chains in steps: orders, bounds of the step, long rows, samples."""

import numpy as np
import pytest
from scipy.special import stdtrit

from harness.errors import RequestError
from harness.solvers import chain_stepped
from harness.solvers.chain import STABILITY, factorise, forces_of_overlaps, highest_frequency
from harness.solvers.chain_exact import find_modes
from tests.solvers.chain.rows import LAWS, Tower, by_modes, by_steps, chain_of
from tests.theory import closed_forms


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("scheme", "order"), [("rk4", 4), ("velocity_verlet", 2)])
def test_the_order_while_contacts_stay(law, scheme, order):
    """A tower at rest under a grain that starts to press: no contact changes."""
    case = Tower(height=5, law=law, start="preloaded", speed=0.005)
    exact, time = by_modes(case, 0.4, samples=1), 0.4 * case.contact_time
    assert len(exact.time) <= 4
    steps, errors = time / np.array([40, 60, 90, 135, 200, 300]), []
    for step in steps:
        run = chain_stepped.run(chain_of(case), time, step, samples=1, scheme=scheme)
        errors.append(np.abs(run.final_velocity - exact.final_velocity).max())
    fit, covariance = np.polyfit(np.log(steps), np.log(errors), 1, cov=True)
    doubt = stdtrit(len(steps) - 2, 0.975) * np.sqrt(covariance[0, 0])
    assert abs(fit[0] - order) < max(doubt, 0.1)


def uneven(tower, rng):
    """Return a tower whose particles have masses and stiffnesses of their own."""
    mass, stiffness = rng.uniform((0.5, 5e5), (2.0, 2e6), (tower.height + 1, 2)).T
    return tower.replace(mass=tuple(mass), stiffness=tuple(stiffness))


# ---- the bound of the step: it holds, it is close, it is needed


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("height", [1, 2, 5, 40])
def test_the_bound_of_the_frequencies_holds_and_is_close(law, base, height):
    rng = np.random.default_rng(height)
    equal = Tower(height=height, law=law, base=base, gravity=0.0)
    for case in (equal, uneven(equal, rng)):
        chain, closed, factor = chain_of(case), np.ones(height, bool), np.zeros((3, height))
        factorise(closed, chain.diagonal, chain.coupling, factor)
        modes = find_modes(chain, closed, factor, chain.displacement, chain.velocity)
        bound = highest_frequency(chain)
        assert modes.highest <= bound * (1 + 1e-12)
        if case is equal and height == 40:
            assert modes.highest > 0.97 * bound
        if case is equal and (law, base) == ("overlap", "fixed"):
            expected = closed_forms.overlap_modes(height, case.omega)
            assert np.sort(modes.frequency)[1:] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("scheme", ["rk4", "velocity_verlet"])
def test_a_step_is_stable_up_to_the_bound(scheme):
    case = Tower(height=40, law="overlap", start="preloaded", speed=1e-6)
    chain = chain_of(case)
    bound = STABILITY[scheme] / highest_frequency(chain)
    stays, grows = (
        chain_stepped.run(chain, 400 * bound, share * bound, samples=400, scheme=scheme).energy
        for share in (0.99, 1.03)
    )
    assert stays.max() - stays[0] < 1e-11
    assert grows.max() - grows[0] > 1e-9


def test_too_many_steps():
    with pytest.raises(RequestError, match="more than 1e12 steps"):
        chain_stepped.run(chain_of(Tower()), 1.0, 1e-14, samples=1)


# ---- long rows


def stepped_plainly(chain, step, steps):
    """Return displacements and velocities after RK4, each force from a cold start."""

    def acceleration(u):
        force = forces_of_overlaps(u[:-1] - u[1:], chain.diagonal, chain.coupling)
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


@pytest.mark.parametrize("start", ["moving", "pressed", "clusters"])
@pytest.mark.parametrize("equal", [True, False])
def test_a_long_row_whose_contact_sets_are_kept_from_step_to_step(start, equal):
    rng, particles = np.random.default_rng(7), 800
    case = Tower(height=particles - 1, gravity=0.0)
    chain = chain_of(case if equal else uneven(case, rng))
    chain.velocity[:-1] = rng.normal(0, 1e-3 if start == "pressed" else 0.5, particles - 1)
    if start == "pressed":
        chain.displacement[:] = np.linspace(0.0, -1e-5 * particles, particles)
    elif start == "clusters":
        overlap = np.where(rng.random(particles - 1) < 0.02, -1e-5, 1e-5)
        chain.displacement[:] = np.concatenate(([0.0], -np.cumsum(overlap)))
    step, steps = 1e-6, 40
    u, v = stepped_plainly(chain, step, steps)
    run = chain_stepped.run(chain, steps * step, step * (1 + 1e-9), samples=2)
    scale = max(np.abs(u).max(), 1e-6)
    assert run.displacements[-1] == pytest.approx(u, abs=1e-11 * scale)
    assert run.final_velocity == pytest.approx(v, abs=1e-11 * max(np.abs(v).max(), scale / step))


@pytest.mark.parametrize(("law", "height"), [("overlap", 99_999), ("deformable", 9_999)])
def test_very_long_rows(law, height):
    """The shock is far from the base: the grain moves as on a short tower."""
    runs = [by_steps(Tower(height=n, law=law), 0.01, samples=1) for n in (40, height)]
    assert runs[0].final_velocity[:20] == pytest.approx(runs[1].final_velocity[:20], abs=1e-12)
    # all but the shocked ones fall freely
    assert np.ptp(runs[1].final_velocity[100:-100]) == 0.0


# ---- samples


def test_samples_are_kept_at_equal_distances_and_at_changes():
    run = by_steps(Tower(height=3), 3.0, steps_per_contact=50_000.0, samples=30)
    assert 31 < run.time.size < 60
    assert run.time[-1] == pytest.approx(3 * Tower(height=3).contact_time)
    assert (np.diff(run.time) > 0).all()
    changes = np.flatnonzero(np.diff(run.contacts))
    assert changes.size > 4
    verlet = by_steps(Tower(height=3), 3.0, samples=30, scheme="velocity_verlet")
    assert np.ptp(np.diff(verlet.time[:-1])) < 1e-15
    assert verlet.forces.shape == (verlet.time.size, 3)


def test_a_run_in_slices_is_the_same_to_the_last_bit(monkeypatch):
    whole, calls = by_steps(Tower(height=5), 1.0), []
    monkeypatch.setattr(chain_stepped, "SLICE", 1000)
    cut = by_steps(Tower(height=5), 1.0, progress=lambda done, total: calls.append((done, total)))
    assert len(calls) > 3
    assert calls == sorted(calls)
    assert calls[-1][0] == calls[-1][1]
    for name in ("time", "displacements", "velocities", "forces"):
        assert np.array_equal(getattr(whole, name), getattr(cut, name)), name


@pytest.mark.parametrize("solver", [by_steps, by_modes])
def test_an_interrupt_between_two_slices_ends_the_run(monkeypatch, solver):
    monkeypatch.setattr(chain_stepped, "SLICE", 1000)

    def interrupted(done, total):
        assert done <= total
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solver(Tower(height=5), 1.0, progress=interrupted)
