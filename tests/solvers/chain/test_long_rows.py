"""RK4 in rows of many blocks."""

from __future__ import annotations

import numpy as np
import pytest

from harness.observables.tower import impulse_until
from harness.parameters.tower import Tower
from harness.solvers.chain import rk4, rk4_deformable
from harness.solvers.chain.forces import forces_of_overlaps
from harness.solvers.chain.motion import Plan, assemble, blank_record
from harness.solvers.chain.rk4_deformable import (
    BLOCK,
    STAGES,
    in_free_flight,
    set_overlaps,
    stage_shift,
)

LAWS = ("overlap", "deformable")


def stepped(chain, step, steps):
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


def start_row(chain, start, rng):
    """Set the state of ``chain``: what moves at random, has no place to part, or parts in vain."""
    particles = chain.mass.size
    if start == "moving":
        chain.velocity[:-1] = rng.normal(0, 0.5, particles - 1)
    elif start == "pressed":
        chain.displacement[:] = np.linspace(0.0, -1e-5 * particles, particles)
        chain.velocity[:-1] = rng.normal(0, 1e-3, particles - 1)
    elif start == "clusters":  # runs of touching particles, apart from each other
        overlap = np.where(rng.random(particles - 1) < 0.02, -1e-5, 1e-5)
        chain.displacement[:] = np.concatenate(([0.0], -np.cumsum(overlap)))
        chain.velocity[:-1] = rng.normal(0, 0.5, particles - 1)
    else:  # what was chosen to part blocks closes within the first step
        chain.gravity[:BLOCK], chain.gravity[BLOCK:-1] = 1e3, -1e3


def unequal(particles, rng):
    """Return a row of random masses and stiffnesses."""
    return Tower(
        height=particles - 1,
        gravity=0.0,
        mass=tuple(rng.uniform(0.5, 2, particles)),
        stiffness=tuple(rng.uniform(5e5, 2e6, particles)),
    )


STARTS = ("moving", "pressed", "clusters", "cut closes")


@pytest.mark.parametrize("particles", [1100, 1600])
@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("equal", [True, False])
def test_blocks_of_a_long_row(particles, start, equal):
    """Block by block, each contact set kept from stage to stage, or at once from a cold start."""
    rng = np.random.default_rng(particles)
    case = Tower(height=particles - 1, gravity=0.0) if equal else unequal(particles, rng)
    chain = assemble(case)
    start_row(chain, start, rng)
    step, steps = 1e-5, 40
    u, v = stepped(chain, step, steps)
    plan = Plan(step, steps, 20, particles)
    _, rows = rk4.integrate(chain, blank_record(3, particles, False), plan)
    assert rows > 0
    scale = max(np.abs(u).max(), 1e-6)
    assert chain.displacement == pytest.approx(u, abs=1e-11 * scale)
    assert chain.velocity == pytest.approx(v, abs=1e-11 * max(np.abs(v).max(), scale / step))


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("seed", range(3))
def test_blocks_sample_what_the_whole_row_does(start, seed):
    """All samples and profiles, over a time in which contacts open and close where blocks part."""
    particles, step, steps = 3 * BLOCK + 200, 1e-5, 300
    rng = np.random.default_rng(seed)
    case = unequal(particles, rng)
    records = []
    for kernel in (rk4_deformable.long_row_kernel, rk4_deformable.short_row_kernel):
        chain = assemble(case)
        start_row(chain, start, np.random.default_rng(seed))
        blank = blank_record(8, particles, True)
        record, rows = kernel(chain, Plan(step, steps, 50, particles))(blank, 0, steps + 1)
        records.append([part[:rows] for part in record])
    for blocks, whole in zip(*records, strict=True):
        assert blocks.shape == whole.shape
        # rounding grows with each change of contacts it meets, and forces differ by it times k
        assert (np.abs(blocks - whole) <= 1e-9 * np.abs(whole).max()).all()


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_two_particles_meet_where_nothing_touched(gravity):
    """A block falls freely, its first contact closes and opens, and it falls freely again."""
    step, steps, gap = 1e-5, 300, 1e-2
    case = Tower(height=3 * BLOCK - 1, start="gapped", gap=gap, gravity=gravity)
    chain, at = assemble(case), 3 * BLOCK // 2
    chain.gravity[-1] = gravity  # the base falls too: no other contact closes
    chain.velocity[:] = 0.0
    chain.displacement[at] += gap - 1e-4
    chain.velocity[at : at + 2] = 0.5, -0.5
    start, thrown = chain.displacement.copy(), chain.velocity.copy()
    advance = rk4_deformable.long_row_kernel(chain, Plan(step, steps, 50, 2))
    record, rows = advance(blank_record(8, 3 * BLOCK, True), 0, steps + 1)
    pressed = record.forces[:rows] > 0
    assert pressed.sum(axis=1).tolist() == [0, 1, 1, 1, 1, 0, 0]  # from 0.1 ms for pi sqrt(m/2k)
    assert not np.delete(pressed, at, axis=1).any()
    others = np.delete(np.arange(3 * BLOCK), [at, at + 1])
    time = step * steps
    fall = start + gravity * time**2 / 2
    rounding = steps * 1e-15 * np.abs(start).max()  # a few ulp in each step
    assert chain.displacement[others] == pytest.approx(fall[others], abs=rounding)
    assert chain.velocity[others] == pytest.approx(gravity * time, abs=rounding)
    exchanged = thrown[[at + 1, at]] + gravity * time
    # the kink of the force at the two changes of contact
    assert chain.velocity[[at, at + 1]] == pytest.approx(exchanged, abs=1e-4)


@pytest.mark.parametrize("equal", [True, False])
def test_free_flight_is_what_the_stages_find(equal):
    """Against the overlaps of each stage; where gravity differs it may be too cautious."""
    rng = np.random.default_rng(1)
    step, tolerance, n, answers = 1e-2, 1e-12, 3, []
    for _ in range(400):
        u, v = np.cumsum(rng.uniform(0, 1e-2, 8)), rng.normal(0, 0.5, 8)
        gravity = np.full(8, 9.81) if equal else rng.normal(0, 40, 8)
        low, at = 2, 4
        overlap, stages = np.empty(n), []
        for stage in range(STAGES):
            set_overlaps(u, v, gravity[at:], low, n, *stage_shift(stage, step), overlap)
            stages.append(overlap.max())
        here, g = slice(low, low + n + 1), gravity[at : at + n + 1]
        free = in_free_flight(u[here], v[here], np.zeros(n, np.bool_), g, step, tolerance)
        answers.append((bool(free), max(stages) <= tolerance))
    assert {(True, True), (False, False)} <= set(answers)
    assert (True, False) not in answers
    assert not equal or (False, True) not in answers


def test_a_closed_contact_is_not_in_free_flight():
    """It may carry a force as small as the tolerance, until a stage has found it open."""
    u, v, gravity = np.zeros(8), np.zeros(8), np.zeros(8)
    for contact in range(7):
        closed = np.arange(7) == contact
        free = in_free_flight(u[2:6], v[2:6], closed[2:5], gravity[2:6], 1e-5, 1e-14)
        assert free == (contact not in (2, 3, 4))


def test_particles_that_nothing_touches_fall_alike():
    """To the last bit, across the ends of blocks: else contacts would close at random."""
    case = Tower(height=20_000)
    run = rk4.run(case, 3e-4, step=3e-6, samples=1, longest_chain=60)
    assert np.unique(run.final_velocity[100:-100]).size == 1
    assert np.unique(run.final_displacement[100:-100]).size == 1


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
