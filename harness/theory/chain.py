"""Closed forms of chains of particles: two spheres, a grain on a free or endless row, on a tower.

A contact is a linear elastic spring. A grain falls on a row of equal, just touching particles; the
*shock* is the share of its kinetic energy that a grain keeps in a well of the incline.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.special import jn_zeros, jv

from harness.errors import RequestError

Law = Literal["overlap", "deformable"]
LAWS: tuple[Law, ...] = ("overlap", "deformable")  # what DEM codes do, and the source's

# ---- the contact of two spheres
#
# The source calls this case without analytical solution; it is a half-wave.


def contact_time(mass: float, stiffness: float) -> float:
    """Return how long two free equal spheres touch [s], ``pi / sqrt(2) sqrt(m/k)``."""
    return math.pi * math.sqrt(mass / (2 * stiffness))


def peak_overlap(mass: float, stiffness: float, speed: float) -> float:
    """Return the largest overlap of two free equal spheres [m], ``v sqrt(m / 2k)``."""
    return speed * math.sqrt(mass / (2 * stiffness))


def contact_time_on_fixed(mass: float, stiffness: float, speed: float, gravity: float) -> float:
    """Return t0, how long a grain under gravity touches one fixed particle [s].

    ``(2/omega) (pi - atan(v0 omega / g))`` with ``omega = sqrt(k/m)``.
    """
    omega = math.sqrt(stiffness / mass)
    return 2 / omega * (math.pi - math.atan2(speed * omega, gravity))


def impulse_on_fixed(mass: float, stiffness: float, speed: float, gravity: float) -> float:
    """Return the impulse of that contact on the grain [N s], ``2 m v0 + m g t0``."""
    t0 = contact_time_on_fixed(mass, stiffness, speed, gravity)
    return 2 * mass * speed + mass * gravity * t0


# ---- a grain that hits a free row, without gravity
#
# Velocities after all contacts have opened are parts of the grain's speed. They do not depend on
# mass or stiffness. The motion is linear until a contact opens or closes.

Floats = NDArray[np.float64]

LONG = 20.0  # [sqrt(m/k)] without a change: all have parted
NOTHING = 1e-14  # force or gap below which a contact that just touches does not change


def final_velocities(particles: int, deformable: bool = False) -> Floats:
    """Return the final velocities (N,) [1] for a grain of speed 1.

    Linear motion is integrated from change to change of a contact. Slow, and shares nothing with
    the solvers. Meant for a handful of particles. Time is in sqrt(m/k).
    """
    contacts = particles - 1
    overlap = np.eye(contacts, particles) - np.eye(contacts, particles, 1)
    law, state = compliance(contacts, deformable), np.zeros(2 * particles)
    state[particles] = 1.0
    # just touching, the row closes as far as the push reaches: the grain's contact
    # alone under the deformable law, where it pulls the next one open
    closed = np.arange(contacts) < (1 if deformable else contacts)
    while True:
        force = np.zeros((contacts, particles))  # from displacements
        force[closed] = np.linalg.solve(law[np.ix_(closed, closed)], overlap[closed])
        # force of a closed contact, gap of an open one: both vanish at a change
        sense = np.where(closed[:, None], force, law @ force - overlap)
        state, changed = _until_change(state, -overlap.T @ force, sense)
        if not changed.any():
            return state[particles:]
        closed = closed ^ changed


def _until_change(
    state: Floats, accelerations: Floats, sense: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the state when a sense falls to 0 first, and which (n,); none within ``LONG``."""
    count = len(accelerations)

    def rates(_: float, y: Floats) -> Floats:
        return np.concatenate((y[count:], accelerations @ y[:count]))

    def falls(row: Floats) -> Callable[[float, Floats], float]:
        def event(_: float, y: Floats) -> float:
            return float(row @ y[:count]) + NOTHING

        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        return event

    events = [falls(row) for row in sense]
    run = solve_ivp(rates, (0.0, LONG), state, "DOP853", events=events, rtol=1e-13, atol=1e-15)
    assert run.t_events is not None
    return run.y[:, -1], np.array([times.size > 0 for times in run.t_events])


def compliance(contacts: int, deformable: bool) -> Floats:
    """Return A (n, n): overlaps ``A f`` at unit stiffness; tridiag(1/2, 1, 1/2) or 1."""
    coupling = np.full(contacts - 1, 0.5 if deformable else 0.0)
    return np.diag(np.ones(contacts)) + np.diag(coupling, 1) + np.diag(coupling, -1)


# ---- a grain that hits a row without end, overlap law, no gravity: Bessel functions
#
# Schroedinger's chain: u_j'' = omega^2 (u_(j-1) - 2 u_j + u_(j+1)) with a free end gives v1 = 2
# J1(tau)/tau for tau = 2 omega t. No contact opens before the grain's own, so this holds until the
# grain leaves, at the first zero of J2. A finite tower obeys it until the echo from its base is
# back.

DETACHMENT_TAU = float(jn_zeros(2, 1)[0])  # 5.135622


def grain_velocity(tau: ArrayLike) -> NDArray[np.float64]:
    """Return the velocity of the grain [1], as a part of its speed, while in contact."""
    return _ratio(1, 2.0, np.asarray(tau, dtype=float), 1.0)


def grain_force(tau: ArrayLike) -> NDArray[np.float64]:
    """Return the contact force on the grain [1], in m omega v0, ``4 J2(tau)/tau``."""
    return _ratio(2, 4.0, np.asarray(tau, dtype=float), 0.0)


def _ratio(
    order: int, factor: float, tau: NDArray[np.float64], at_zero: float
) -> NDArray[np.float64]:
    """Return ``factor J(tau)/tau``, ``at_zero`` where tau is 0."""
    result = np.full_like(tau, at_zero)
    np.divide(factor * jv(order, tau), tau, out=result, where=tau != 0)
    return result


# ---- the shock in the well: the part of the kinetic energy that is left after it
#
# In the well the velocity must turn by 60 deg: cos 60 = 1/2 of it is tangential to the new contact
# and survives, sin 60 = sqrt(3)/2 is normal to it and comes back times the restitution e. The
# source prints two formulas that disagree; both readings are kept, named for what they are:
#
#     kept: the shock is the energy after over the energy before;
#     lost: the shock is built from the velocity lost, ((v' - v)/v')^2, as the source's equations
#     for the shock print it. It agrees with kept at v = v'/2 only.

Reading = Literal["kept", "lost"]

SHOCK_WITHOUT_REBOUND = 0.25
"""Energy ratio of the shock at e = 0: cos(60 deg)^2."""


def shock_from_restitution(restitution: float, reading: Reading = "kept") -> float:
    """Return the shock of a rebound with normal restitution e (source, eqs. of the shock).

    Raise RequestError unless 0 <= e <= 1.
    """
    if not 0.0 <= restitution <= 1.0:
        raise RequestError(f"restitution = {restitution!r} is not allowed: must be from 0 to 1")
    return _shock(math.sqrt(0.25 + 0.75 * restitution**2), reading)


def shock_from_impulse_ratio(ratio: float, reading: Reading = "lost") -> float:
    """Return the shock when the impulse is alpha times that of a rigid base (source, eq. of alpha).

    The post-shock velocity v'/2 is rescaled by alpha = J(n)/J(1). ``lost``
    puts it into the source's shock, (1 - alpha/2)^2; ``kept`` takes it at its
    word, (alpha/2)^2. Their critical angles move in opposite directions.

    Raise RequestError unless 0 < alpha < 2, where both are between 0 and 1.
    """
    if not 0.0 < ratio < 2.0:
        raise RequestError(
            f"impulse-ratio = {ratio!r} is not allowed: must be greater than 0 and less than 2"
        )
    return _shock(ratio / 2.0, reading)


def _shock(velocity_ratio: float, reading: Reading) -> float:
    """Return the shock from v/v' in one of the two readings."""
    if reading == "kept":
        return velocity_ratio**2
    if reading == "lost":
        return (1.0 - velocity_ratio) ** 2
    raise RequestError(f"reading = {reading!r} is not allowed: must be 'kept' or 'lost'")


# ---- a tower of equal particles on a fixed base: at rest, its modes, its stiffness


def static_forces(contacts: int, mass: float, gravity: float) -> Floats:
    """Return the contact forces at rest (n,) [N]: the weight above, under either law."""
    return np.arange(1.0, contacts + 1) * (mass * gravity)


def series_stiffness(contacts: int, stiffness: float, deformable: bool) -> float:
    """Return force over approach of the outer centres [N/m] of M contacts in series.

    Overlap law k/M. Deformable law k/(2M-1): each of the M - 1 particles in
    between is pressed from both sides and so shortened by 2f/k, the outer two,
    of which one half counts, by f/k. The source's k/n is neither.
    """
    return stiffness / (2 * contacts - 1 if deformable else contacts)
