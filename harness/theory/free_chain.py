"""A grain that hits a free row of equal, just touching particles, without gravity.

Velocities after all contacts have opened, as parts of the grain's speed. They
do not depend on mass or stiffness. A mode expansion holds while the contacts
stay as they are; the first contact that opens ends it, and what is left of the
row goes on with modes of its own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq

Floats = NDArray[np.float64]

_STEP = 5e-3
_SCAN = 4_000  # steps without a change: all have parted
_NOTHING = 1e-14


def final_velocities(particles: int, deformable: bool = False) -> Floats:
    """Return the final velocities (N,) [1] for a grain of speed 1.

    Linear motion between changes of contact by matrix exponentials, the changes
    by bracketing on a fine grid: slow, and shares nothing with the solvers.
    Meant for a handful of particles. Time is in sqrt(m/k).
    """
    u, v = np.zeros(particles), np.zeros(particles)
    v[0] = 1.0
    # just touching, the row closes as far as the push reaches: the grain's contact
    # alone under the deformable law, where it pulls the next one open
    contacts = particles - 1
    closed = np.zeros(contacts, dtype=bool)
    closed[: 1 if deformable else contacts] = True
    law = compliance(contacts, deformable)
    while True:
        change = _next_change(u, v, closed, law)
        if change is None:
            return v
        time, contact = change
        u, v = _propagate(u, v, closed, law, time)
        closed[contact] = not closed[contact]


def compliance(contacts: int, deformable: bool) -> Floats:
    """Return A (n, n): overlaps ``A f`` at unit stiffness; tridiag(1/2, 1, 1/2) or 1."""
    beside = np.full(contacts - 1, 0.5 if deformable else 0.0)
    return np.diag(np.ones(contacts)) + np.diag(beside, 1) + np.diag(beside, -1)


def _forces_matrix(closed: NDArray[np.bool_], law: Floats) -> Floats:
    """Return the matrix (n, N) from displacements to contact forces."""
    contacts = closed.size
    overlap = np.eye(contacts, contacts + 1) - np.eye(contacts, contacts + 1, 1)
    force = np.zeros((contacts, contacts + 1))
    held = np.flatnonzero(closed)
    if held.size:
        force[held] = np.linalg.solve(law[np.ix_(held, held)], overlap[held])
    return force


def _propagate(
    u: Floats, v: Floats, closed: NDArray[np.bool_], law: Floats, time: float
) -> tuple[Floats, Floats]:
    """Return displacements and velocities (N,) after ``time``."""
    state = _propagator(closed, law, time) @ np.concatenate((u, v))
    return state[: u.size], state[u.size :]


def _propagator(closed: NDArray[np.bool_], law: Floats, time: float) -> Floats:
    """Return the matrix (2N, 2N) that carries displacements and velocities over ``time``."""
    n = closed.size + 1
    difference = np.eye(n - 1, n) - np.eye(n - 1, n, 1)
    generator = np.zeros((2 * n, 2 * n))
    generator[:n, n:] = np.eye(n)
    generator[n:, :n] = -difference.T @ _forces_matrix(closed, law)
    return np.asarray(expm(generator * time))


def _next_change(
    u: Floats, v: Floats, closed: NDArray[np.bool_], law: Floats
) -> tuple[float, int] | None:
    """Return when a contact changes first, and which one; None if none does any more."""
    n = u.size
    force = _forces_matrix(closed, law)
    overlap = np.eye(n - 1, n) - np.eye(n - 1, n, 1)
    # force of a closed contact, gap of an open one: both vanish at a change
    sense = np.where(closed[:, None], force, law @ force - overlap)
    now, rate = u, v
    advance = _propagator(closed, law, _STEP)
    for count in range(_SCAN):
        state = advance @ np.concatenate((now, rate))
        later, later_rate = state[:n], state[n:]
        crossed = np.flatnonzero(sense @ later < -_NOTHING)
        if crossed.size:
            roots = [_root(sense[c], now, rate, closed, law) for c in crossed]
            first = int(np.argmin(roots))
            return count * _STEP + roots[first], int(crossed[first])
        now, rate = later, later_rate
    return None


def _root(sense: Floats, u: Floats, v: Floats, closed: NDArray[np.bool_], law: Floats) -> float:
    """Return when, within a step, ``sense`` times the displacements falls to 0."""

    def value(time: float) -> float:
        return float(sense @ _propagate(u, v, closed, law, time)[0])

    return float(brentq(value, 0.0, _STEP, xtol=1e-15, rtol=1e-15)) if value(0.0) > 0 else 0.0
