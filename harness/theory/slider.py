"""A spring and a dashpot in parallel under a constant limit, in one direction: in closed form.

The force against the motion is k q + c u, at most the limit in size: beyond it the spring is cut
back so that both together hold the limit (Luding, Granular Matter 10, 235 (2008), section 4.2).
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from scipy.optimize import brentq


def limited_forces(
    stiffness: float, dashpot: float, limit: float, pieces: Iterable[tuple[float, float]]
) -> list[float]:
    """Return the force along the motion at the end of each piece: displacement, duration [s].

    The velocity is constant in a piece. The spring is slack at the start.
    """
    stretch, found = 0.0, []
    for displacement, duration in pieces:
        drag = dashpot * displacement / duration
        resisting = stiffness * (stretch + displacement) + drag
        limited = math.copysign(min(abs(resisting), limit), resisting)
        stretch = (limited - drag) / stiffness
        found.append(-limited)
    return found


def twisting_spin(
    time: float, spin: float, inertia: float, spring: tuple[float, float], limit: float
) -> float:
    """Return the spin [rad/s] after a time [s] of a body that only a twisting contact slows down.

    ``inertia`` in kg m2; ``spring``: stiffness [N m] and dashpot [N m s] of less than critical
    damping; ``limit`` [N m] of the torque. It sticks until the torque reaches the limit, slows down
    at a constant rate while it slips, and sticks again where k omega = c limit / I, the rate of the
    torque if it stuck being none: from there on it swings below the limit.
    """
    k, c = spring
    decay, omega = 0.5 * c / inertia, math.sqrt(k / inertia)
    if decay >= omega:
        raise ValueError(f"dashpot = {c!r} N m s: must be below critical damping")
    rate = math.sqrt(omega * omega - decay * decay)

    def swings(t: float, turned: float, speed: float) -> tuple[float, float]:
        """Return angle and spin of the damped oscillation after a time."""
        sine, cosine, left = math.sin(rate * t), math.cos(rate * t), math.exp(-decay * t)
        push = (speed + decay * turned) / rate
        angle = left * (turned * cosine + push * sine)
        return angle, left * rate * (push * cosine - turned * sine) - decay * angle

    def beyond(t: float) -> float:
        turned, speed = swings(t, 0.0, spin)
        return k * turned + c * speed - limit

    # the torque is largest where its rate k omega + c alpha is none
    phase = math.atan2(rate * (k - 2.0 * decay * c), decay * k + c * (rate**2 - decay**2))
    largest = max(0.0, phase) / rate
    if beyond(largest) <= 0.0:
        return swings(time, 0.0, spin)[1]
    slips = 0.0 if beyond(0.0) >= 0.0 else float(brentq(beyond, 0.0, largest, xtol=1e-16 / omega))
    if time <= slips:
        return swings(time, 0.0, spin)[1]
    start, slowing = swings(slips, 0.0, spin)[1], limit / inertia
    last = c * slowing / k
    stands = slips + max(0.0, start - last) / slowing
    if time <= stands:
        return start - slowing * (time - slips)
    return swings(time - stands, (limit - c * last) / k, last)[1]
