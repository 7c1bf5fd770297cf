"""The classic Runge-Kutta method of fourth order with a fixed step (Kutta 1901).

Forces depend on positions alone, so the four stages reduce to four force
evaluations at displacements ``u + c v + b a``, with a the acceleration of the
stage before. Order 4 while the contacts stay; at a change of contacts the force
has a kink, and the error of the step that meets it is of lower order.
"""

from __future__ import annotations

import math

import numpy as np

from harness.chain.arrays import Chain, Floats, assemble
from harness.chain.compiled import compiled
from harness.chain.complementarity import factorise, solve
from harness.chain.record import Record, as_run, blank_record, chain_of_grain, with_room, write_sample
from harness.chain.stability import chosen_step
from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

SAMPLES_PER_CONTACT = 1000
_STEPS_AT_MOST = 10**12


def run(
    tower: Tower,
    duration: float,
    *,
    step: float | None = None,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
    longest_chain: int | None = None,
) -> TowerRun:
    """Run ``tower`` for ``duration`` [s] and return about ``samples`` samples.

    ``step`` [s] or ``steps_per_contact`` (steps in pi sqrt(m/k)); without them
    the step is chosen (:func:`harness.chain.stability.chosen_step`) and made to
    divide the duration. By default 1000 samples per t0, or every step. A
    ``longest_chain`` says how many contacts will touch in a row at most, which
    allows a larger step for long deformable chains; the run stops if it is not
    true. Raise RequestError for a step or duration that cannot be.
    """
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} s: must be finite and greater than 0")
    if longest_chain is not None and longest_chain < 1:
        raise RequestError(f"longest_chain = {longest_chain}: must be at least 1")
    wanted = samples or max(1, math.ceil(SAMPLES_PER_CONTACT * duration / tower.contact_time))
    if wanted < 1:
        raise RequestError(f"samples = {samples}: must be at least 1")
    h = chosen_step(tower, step, steps_per_contact, longest_chain)
    if duration / h > _STEPS_AT_MOST:
        raise RequestError(f"duration = {duration} s: more than 1e12 steps of {h:.6g} s")
    steps = max(1, math.ceil(duration / h * (1 - 1e-12)))
    h = duration / steps
    every = max(1, steps // wanted)
    chain = assemble(tower)
    record = blank_record(steps // every + 2, tower.particles, profiles)
    limit = tower.height if longest_chain is None else longest_chain
    record, rows = integrate(chain, record, h, steps, every, limit)
    if rows < 0:
        raise _stopped(-rows, limit, h)
    return as_run(tower, "rk4", h, record, rows, chain)


def _stopped(found: int, limit: int, step: float) -> RequestError:
    if found > limit:
        return RequestError(
            f"longest_chain = {limit}: {found} contacts touch in a row, "
            f"for which a step of {step:.6g} s may be unstable"
        )
    return RequestError(f"step = {step:.6g} s: the contacts could not be found, values overflow")


@compiled
def integrate(
    chain: Chain, record: Record, step: float, steps: int, every: int, longest: int
) -> tuple[Record, int]:
    """Advance ``chain`` in place; sample every so many steps, at the end, and ...

    whenever the number of contacts in the grain's chain has changed. Return the
    record and its rows; or minus the length of a chain of touching contacts
    longer than ``longest``, or -1 where no contact set fits.
    """
    u, v, mass, gravity = chain.displacement, chain.velocity, chain.mass, chain.gravity
    mobility, diagonal, beside = chain.mobility, chain.diagonal, chain.beside
    deformable, tolerance = chain.deformable, 1e-14 * chain.length
    n = diagonal.size
    a, b, c = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    overlap, force, stiffness = np.zeros(n), np.zeros(n), 1 / diagonal
    held = n if deformable else 0
    closed, open_, factor = np.zeros(held, np.bool_), np.zeros(held), np.zeros((3, held))
    for i in range(held):
        closed[i], open_[i] = u[i] > u[i + 1], u[i] <= u[i + 1]
    found = factorise(closed, diagonal, beside, factor)
    pivot, forth, back = factor[0], factor[1], factor[2]
    rows, contacts = 0, -1
    for count in range(steps + 1):
        for stage in range(4):
            shift = 0.0 if stage == 0 else 0.5 * step if stage < 3 else step
            lift = 0.0 if stage < 2 else 0.5 * step * shift
            _overlaps(u, v, a if stage < 3 else b, shift, lift, overlap)
            if deformable:
                _substitute(overlap, pivot, forth, back, force)
                if _wrong(overlap, diagonal, beside, open_, force, tolerance):
                    found = solve(overlap, diagonal, beside, closed, factor, force, tolerance)
                    if found < 0 or found > longest:
                        return record, -abs(found)
                    for i in range(n):
                        open_[i] = not closed[i]
            else:
                _press(overlap, stiffness, force)
            if stage == 0:
                touching = chain_of_grain(force)
                if touching != contacts or count % every == 0 or count == steps:
                    contacts = touching
                    record = with_room(record, rows)
                    write_sample(record, rows, count * step, u, v, overlap, force, mass, gravity)
                    rows += 1
                if count == steps:
                    break
            if stage < 3:
                _accelerate(force, mobility, gravity, a if stage == 0 else b if stage == 1 else c)
        if count < steps:
            _finish(u, v, a, b, c, force, mobility, gravity, step)
    return record, rows


@compiled
def _overlaps(u: Floats, v: Floats, a: Floats, shift: float, lift: float, overlap: Floats) -> None:
    """Set the overlaps (n,) [m] at ``u + shift v + lift a``."""
    for i in range(overlap.size):
        overlap[i] = (u[i] - u[i + 1]) + shift * (v[i] - v[i + 1]) + lift * (a[i] - a[i + 1])


@compiled
def _press(overlap: Floats, stiffness: Floats, force: Floats) -> None:
    """Set the forces (n,) [N] of the overlap law, ``stiffness`` (n,) [N/m] being the contacts'."""
    for i in range(force.size):
        force[i] = max(overlap[i], 0.0) * stiffness[i]


@compiled
def _substitute(
    overlap: Floats, pivot: Floats, forth: Floats, back: Floats, force: Floats
) -> None:
    """Set the forces (n,) [N] of the contact set that is factorised."""
    n = overlap.size
    carried = 0.0
    for i in range(n):
        carried = overlap[i] - forth[i] * carried
        force[i] = carried
    carried = 0.0
    for j in range(n):
        i = np.uintp(n - 1 - j)
        carried = pivot[i] * force[i] - back[i] * carried
        force[i] = carried


@compiled
def _wrong(
    overlap: Floats, diagonal: Floats, beside: Floats, open_: Floats, force: Floats, tolerance: float
) -> int:
    """Return how many contacts pull, or are open and overlap, by more than ``tolerance`` [m]."""
    n = overlap.size
    wrong = 0
    for i in range(1, n - 1):
        gap = beside[i - 1] * force[i - 1] + beside[i] * force[i + 1] - overlap[i]
        wrong += diagonal[i] * force[i] + open_[i] * gap < -tolerance
    for i in (0, n - 1):
        gap = -overlap[i]
        if i > 0:
            gap += beside[i - 1] * force[i - 1]
        if i < n - 1:
            gap += beside[i] * force[i + 1]
        wrong += diagonal[i] * force[i] + open_[i] * gap < -tolerance
    return wrong


@compiled
def _accelerate(force: Floats, mobility: Floats, gravity: Floats, acceleration: Floats) -> None:
    """Set the accelerations (N,) [m/s2] from the contact forces (n,) [N]."""
    n = force.size
    acceleration[0] = gravity[0] - force[0] * mobility[0]
    for i in range(1, n):
        acceleration[i] = (force[i - 1] - force[i]) * mobility[i] + gravity[i]
    acceleration[n] = gravity[n] + force[n - 1] * mobility[n]


@compiled
def _finish(
    u: Floats, v: Floats, a: Floats, b: Floats, c: Floats,
    force: Floats, mobility: Floats, gravity: Floats, step: float,
) -> None:  # fmt: skip
    """Complete the step with the forces (n,) [N] of the fourth stage."""
    n = force.size
    for i in range(n + 1):
        push = force[i - 1] if i > 0 else 0.0
        pull = force[i] if i < n else 0.0
        d = (push - pull) * mobility[i] + gravity[i]
        u[i] += step * v[i] + step * step / 6 * (a[i] + b[i] + c[i])
        v[i] += step / 6 * (a[i] + 2 * (b[i] + c[i]) + d)
