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
from harness.chain.complementarity import Flags, solve, substitute
from harness.chain.events import ORDER, REACH, first_root, taylor_of_contacts
from harness.chain.modes import decompose, project, state_at
from harness.chain.record import (
    Record,
    as_run,
    blank_record,
    wanted_samples,
    with_room,
    write_sample,
)
from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

# a contact changes when its force or gap is this far below 0, as a part of the
# scale of displacements: above the rounding of the modes, below all else
_SLACK = 1e-13


def run(
    tower: Tower, duration: float, *, samples: int | None = None, profiles: bool = False
) -> TowerRun:
    """Run ``tower`` for ``duration`` [s] and return its samples.

    There are ``samples`` at equal distances (1000 per t0 if not given), one at
    each change of contacts and one whenever the distance of grain and base turns. Raise
    RequestError for a duration that cannot be.
    """
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} s: must be finite and greater than 0")
    wanted = wanted_samples(samples, duration / tower.contact_time)
    chain = assemble(tower)
    record, rows = propagate(
        chain, blank_record(wanted + 64, tower.particles, profiles), duration, wanted
    )
    if rows < 0:
        raise RequestError(
            f"displacements = {chain.displacement.tolist()} m: the contacts do not settle here"
        )
    order = np.argsort(record.rows[:rows, 0], kind="stable")
    sorted_record = Record(*(part[order] if part.shape[0] else part for part in record))
    return as_run(tower, "exact", None, sorted_record, rows, chain)


@compiled
def propagate(chain: Chain, record: Record, duration: float, samples: int) -> tuple[Record, int]:
    """Advance ``chain`` in place; return the record and its rows, -1 if contacts do not settle."""
    u, v = chain.displacement, chain.velocity
    diagonal, beside = chain.diagonal, chain.beside
    particles, n = u.size, u.size - 1
    slack = 0.0
    closed, factor = np.zeros(n, np.bool_), np.zeros((3, n))
    overlap, force = np.zeros(n), np.zeros(n)
    shapes, amplitudes = np.zeros((particles, particles)), np.zeros((4, particles))
    frequency, first = np.zeros(particles), np.zeros(particles)
    series = np.zeros((n, ORDER + 1))
    x, w = u.copy(), v.copy()  # the state where the search stands
    y, z = u.copy(), v.copy()  # the state of a sample
    time, rows, sample, stuck = 0.0, 0, 0, 0
    for i in range(n):
        closed[i] = u[i] - u[i + 1] > _SLACK * chain.length
    while True:
        for i in range(n):
            overlap[i] = u[i] - u[i + 1]
        slack = _SLACK * max(chain.length, np.max(np.abs(u)))
        # stricter than what the search allows: the new set is not at its own edge
        settled = solve(overlap, diagonal, beside, closed, factor, force, 0.25 * slack)
        if settled < 0 or stuck > 4 * n + 16:
            return record, -1
        highest = decompose(chain, closed, factor, shapes, frequency, first)
        project(chain, closed, shapes, frequency, first, amplitudes)
        record = with_room(record, rows)
        write_sample(record, rows, time, u, v, overlap, force, chain.mass, chain.gravity)
        rows += 1
        x[:], w[:] = u, v
        local, changed, ended = 0.0, -1, False
        while changed < 0 and not ended:
            reach = duration - time - local
            if highest > 0:
                reach = min(reach, REACH / highest)
            changed, root = _next_change(chain, closed, factor, x, w, reach, slack, series)
            until = local + reach * root
            ended = changed < 0 and time + until >= duration * (1 - 1e-14)
            if ended:
                until = duration - time
            before = w[0] - w[n]
            state_at(chain, closed, shapes, frequency, amplitudes, until, x, w)
            if before * (w[0] - w[n]) < 0:
                at = _turn(chain, closed, shapes, frequency, amplitudes, local, until, y, z)
                record = with_room(record, rows)
                _forces(y, factor, overlap, force)
                write_sample(
                    record, rows, time + at, y, z, overlap, force, chain.mass, chain.gravity
                )
                rows += 1
            while (sample + 1) * duration / samples < time + until and sample + 1 < samples:
                sample += 1
                at = sample * duration / samples - time
                state_at(chain, closed, shapes, frequency, amplitudes, at, y, z)
                record = with_room(record, rows)
                _forces(y, factor, overlap, force)
                write_sample(
                    record, rows, time + at, y, z, overlap, force, chain.mass, chain.gravity
                )
                rows += 1
            local = until
        u[:], v[:] = x, w
        time += local
        if changed < 0:
            break
        # many changes in no time, to rounding, would never end
        stuck = stuck + 1 if local * highest < 1e-9 else 0
        closed[changed] = not closed[changed]
    record = with_room(record, rows)
    _forces(u, factor, overlap, force)
    write_sample(record, rows, duration, u, v, overlap, force, chain.mass, chain.gravity)
    return record, rows + 1


@compiled
def _next_change(
    chain: Chain, closed: Flags, factor: Floats, u: Floats, v: Floats,
    reach: float, slack: float, series: Floats,
) -> tuple[int, float]:  # fmt: skip
    """Return the contact that changes first within ``reach`` [s] and when, as a part of it.

    Return -1 and 1 if none does.
    """
    taylor_of_contacts(chain, closed, factor, u, v, reach, series)
    changed, root = -1, 1.0
    for i in range(closed.size):
        found = first_root(series[i], slack, root)
        if found < root:
            changed, root = i, found
    return changed, root


@compiled
def _turn(
    chain: Chain, closed: Flags, shapes: Floats, frequency: Floats,
    amplitudes: Floats, low: float, high: float, y: Floats, z: Floats,
) -> float:  # fmt: skip
    """Return when, between ``low`` and ``high`` [s], grain and base turn; leave the state there."""
    n = y.size - 1
    state_at(chain, closed, shapes, frequency, amplitudes, low, y, z)
    sign = 1.0 if z[0] - z[n] > 0 else -1.0
    middle = low
    for _ in range(60):
        middle = 0.5 * (low + high)
        state_at(chain, closed, shapes, frequency, amplitudes, middle, y, z)
        if sign * (z[0] - z[n]) > 0:
            low = middle
        else:
            high = middle
    return middle


@compiled
def _forces(u: Floats, factor: Floats, overlap: Floats, force: Floats) -> None:
    """Set overlaps (n,) [m] and forces (n,) [N] of the present contact set at ``u`` (N,) [m]."""
    for i in range(overlap.size):
        overlap[i] = u[i] - u[i + 1]
    substitute(overlap, factor, force)
