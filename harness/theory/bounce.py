"""A sphere that bounces under gravity on a linear spring and dashpot, piece by piece.

Flight: a parabola. Contact: x'' = g - 2 zeta omega x' - omega^2 x from x = 0 at speed v until
x = 0 again (tail attractive). MFiX's verification case DEM02 holds the apexes against it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy.optimize import brentq


class Rebound(NamedTuple):
    """Duration of a contact [s], speed at its end [m/s], largest overlap [m]."""

    duration: float
    speed: float
    overlap: float


def rebound(omega: float, zeta: float, gravity: float, speed: float) -> Rebound | None:
    """Return the contact of an impact; None where the sphere stays in contact for ever.

    ``omega`` = sqrt(k/m) [rad/s], ``zeta`` the damping ratio, below 1.
    """
    turns = omega * math.sqrt(1.0 - zeta * zeta)
    rest = gravity / omega**2
    sine = (gravity - zeta * omega * speed) / turns

    def velocity(time: float) -> float:
        wave = speed * math.cos(turns * time) + sine * math.sin(turns * time)
        return math.exp(-zeta * omega * time) * wave

    def overlap(time: float) -> float:
        wave = -rest * math.cos(turns * time)
        wave += (speed - zeta * omega * rest) / turns * math.sin(turns * time)
        return rest + math.exp(-zeta * omega * time) * wave

    peak = math.atan2(speed, -sine) / turns
    trough = peak + math.pi / turns
    if overlap(trough) > 0.0:
        return None
    end = float(brentq(overlap, peak, trough, xtol=1e-16 * trough, rtol=1e-15))
    return Rebound(end, -velocity(end), overlap(peak))
