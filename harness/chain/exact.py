"""The exact propagator: modes between changes of contact, root finding for the changes.

No step and no error of one: what remains is rounding. The cost is that of an
eigenvalue problem for each change of contacts, O(L^3) in the runs of L touching
particles, and O(L^2) for each sample; a few hundred particles are the
practical limit. RK4 is the one for long chains. Each change of contacts magnifies the
rounding of what came before it, as in any chain of collisions.
"""

from __future__ import annotations

import math

import numpy as np

from harness.chain.arrays import Chain, Floats, assemble
from harness.chain.compiled import compiled
from harness.chain.complementarity import solve, substitute
from harness.chain.events import REACH, first_root, taylor_of_contacts
from harness.chain.modes import decompose, project, state_at
from harness.chain.motion import Motion, motion_of
from harness.chain.record import (
    Record,
    as_run,
    blank_record,
    wanted_samples,
    with_room,
    write_sample,
)
from harness.chain.slices import Told
from harness.compiled import shielded
from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

# a contact changes when its force or gap is this far below 0, as a part of the
# scale of displacements: above the rounding of the modes, below all else
_SLACK = 1e-13

_UNSETTLED = -2
"""In place of a contact that changes."""


MOST_PARTICLES = 5000
"""Of a tower: the modes take 8 bytes for each pair of particles."""

CUBES = 1e8
"""Particles to the third power, times changes of contact, between two looks for an interrupt."""


def run(
    tower: Tower,
    duration: float,
    *,
    samples: int | None = None,
    profiles: bool = False,
    told: Told = lambda *_: None,
) -> TowerRun:
    """Run ``tower`` for ``duration`` [s] and return its samples.

    There are ``samples`` at equal distances (1000 per t0 if not given), one at
    each change of contacts and one whenever the distance of grain and base turns. ``told`` is
    called with the samples done and all of them. Raise RequestError for a duration or a number of
    particles that cannot be, and where it cannot be told which contacts touch.
    """
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} s: must be finite and greater than 0")
    if tower.particles > MOST_PARTICLES:
        raise RequestError(
            f"height = {tower.height}: must be less than {MOST_PARTICLES} for the exact solver"
        )
    wanted = wanted_samples(samples, duration / tower.contact_time)
    chain = assemble(tower)
    blank = blank_record(wanted + 64, tower.particles, profiles)
    record, rows = propagate(chain, blank, duration, wanted, told)
    if rows < 0:
        raise RequestError(
            f"duration = {duration:.6g} s: which contacts of {tower.particles} particles touch "
            "cannot be told to rounding before that; a shorter run, or rk4, can be"
        )
    order = np.argsort(record.rows[:rows, 0], kind="stable")
    sorted_record = Record(*(part[order] if part.shape[0] else part for part in record))
    return as_run(tower, "exact", None, sorted_record, rows, chain)


def propagate(
    chain: Chain, record: Record, duration: float, samples: int, told: Told = lambda *_: None
) -> tuple[Record, int]:
    """Advance ``chain`` in place; return the record and its rows, -1 if contacts do not settle."""
    u, v = chain.displacement, chain.velocity
    particles, motion = u.size, motion_of(chain, u[:-1] - u[1:] > _SLACK * chain.length)
    changes, changed = math.ceil(CUBES / particles**3), 0
    while changed >= 0:
        record, changed = shielded(_advance, chain, motion, record, duration, samples, changes)
        told(int(motion.counts[1]), samples)
    if changed == _UNSETTLED:
        return record, -1
    told(samples, samples)
    return _sampled(chain, motion, record, duration, u, v), int(motion.counts[0])


@compiled
def _advance(
    chain: Chain, motion: Motion, record: Record, duration: float, samples: int, changes: int
) -> tuple[Record, int]:
    """Go through so many changes of contact; return the last contact that changed, -1 at the end.

    ``_UNSETTLED`` where contacts do not settle.
    """
    u, v = chain.displacement, chain.velocity
    closed, overlap, force, n = motion.closed, motion.overlap, motion.force, u.size - 1
    changed = 0
    for _ in range(changes):
        for i in range(n):
            overlap[i] = u[i] - u[i + 1]
        slack = _SLACK * max(chain.length, np.max(np.abs(u)))
        # stricter than what the search allows: the new set is not at its own edge
        settled = solve(
            overlap, chain.diagonal, chain.beside, closed, motion.factor, force, 0.25 * slack
        )
        if settled < 0 or motion.counts[2] > 4 * n + 16:
            return record, _UNSETTLED
        highest = decompose(
            chain, closed, motion.factor, motion.shapes, motion.frequency, motion.first
        )
        project(chain, closed, motion.shapes, motion.frequency, motion.first, motion.amplitudes)
        record, time = with_room(record, motion.counts[0]), motion.time[0]
        write_sample(record, motion.counts[0], time, chain, u, v, overlap, force)
        motion.counts[0] += 1
        record, local, changed = _until_change(
            chain, motion, record, time, duration, samples, slack, highest
        )
        u[:], v[:] = motion.x, motion.w
        motion.time[0] = time + local
        if changed < 0:
            break
        # many changes in no time, to rounding, would never end
        motion.counts[2] = motion.counts[2] + 1 if local * highest < 1e-9 else 0
        closed[changed] = not closed[changed]
    return record, changed


@compiled
def _until_change(
    chain: Chain, motion: Motion, record: Record, time: float,
    duration: float, samples: int, slack: float, highest: float,
) -> tuple[Record, float, int]:  # fmt: skip
    """Move on from ``time`` [s] to the next change of contacts or the end, writing samples.

    Return the record, how long it took [s] and the contact that changes, -1 at the end.
    ``highest`` is the highest frequency [rad/s], 0 where nothing touches.
    """
    x, w, y, z, n = motion.x, motion.w, motion.y, motion.z, motion.closed.size
    x[:], w[:] = chain.displacement, chain.velocity
    local, changed, ended = 0.0, -1, False
    while changed < 0 and not ended:
        reach = duration - time - local
        if highest > 0:
            reach = min(reach, REACH / highest)
        changed, root = _next_change(chain, motion, reach, slack)
        until = local + reach * root
        ended = changed < 0 and time + until >= duration * (1 - 1e-14)
        if ended:
            until = duration - time
        before = w[0] - w[n]
        _state_at(chain, motion, until, x, w)
        if before * (w[0] - w[n]) < 0:
            at = _turn(chain, motion, local, until)
            record = _sampled(chain, motion, record, time + at, y, z)
        sample = motion.counts[1]
        while (sample + 1) * duration / samples < time + until and sample + 1 < samples:
            sample += 1
            at = sample * duration / samples - time
            _state_at(chain, motion, at, y, z)
            record = _sampled(chain, motion, record, time + at, y, z)
        motion.counts[1] = sample
        local = until
    return record, local, changed


@compiled
def _sampled(
    chain: Chain, motion: Motion, record: Record, time: float, u: Floats, v: Floats
) -> Record:
    """Return the record with a sample of the state ``u`` and ``v`` (N,)."""
    row = motion.counts[0]
    record = with_room(record, row)
    for i in range(motion.overlap.size):
        motion.overlap[i] = u[i] - u[i + 1]
    substitute(motion.overlap, motion.factor, motion.force)
    write_sample(record, row, time, chain, u, v, motion.overlap, motion.force)
    motion.counts[0] = row + 1
    return record


@compiled
def _state_at(chain: Chain, motion: Motion, time: float, u: Floats, v: Floats) -> None:
    """Set ``u`` and ``v`` (N,) at ``time`` [s] after the last change of contacts."""
    state_at(chain, motion.closed, motion.shapes, motion.frequency, motion.amplitudes, time, u, v)


@compiled
def _next_change(chain: Chain, motion: Motion, reach: float, slack: float) -> tuple[int, float]:
    """Return the contact that changes first within ``reach`` [s] and when, as a part of it.

    Return -1 and 1 if none does.
    """
    series = motion.series
    taylor_of_contacts(chain, motion.closed, motion.factor, motion.x, motion.w, reach, series)
    changed, root = -1, 1.0
    for i in range(motion.closed.size):
        found = first_root(series[i], slack, root)
        if found < root:
            changed, root = i, found
    return changed, root


@compiled
def _turn(chain: Chain, motion: Motion, low: float, high: float) -> float:
    """Return when, between ``low`` and ``high`` [s], the distance of grain and base turns.

    Leaves the state then in ``motion.y`` and ``motion.z``.
    """
    y, z, n = motion.y, motion.z, motion.closed.size
    _state_at(chain, motion, low, y, z)
    sign = 1.0 if z[0] - z[n] > 0 else -1.0
    middle = low
    for _ in range(60):
        middle = 0.5 * (low + high)
        _state_at(chain, motion, middle, y, z)
        if sign * (z[0] - z[n]) > 0:
            low = middle
        else:
            high = middle
    return middle
