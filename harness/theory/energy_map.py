"""The grain's energy from shock to shock, in units of m g d.

The source's section on the Quartier model. Energies are kinetic, just after the
shock in the well; angles in degrees.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def well_depth(angle_deg: float) -> float:
    """Return C = 1 - cos(30 deg - theta): the energy that it takes to reach the next crest."""
    return 1.0 - math.cos(math.radians(30.0 - angle_deg))


def gain_per_crest(angle_deg: float) -> float:
    """Return dE = sin(theta): the work of gravity from one crest to the next."""
    return math.sin(math.radians(angle_deg))


def after_next_shock(energy: float, angle_deg: float, shock: float) -> float:
    """Return E[j+1] = shock (E[j] + dE)."""
    return shock * (energy + gain_per_crest(angle_deg))


def energies(start: float, shocks: int, angle_deg: float, shock: float) -> NDArray[np.float64]:
    """Return E after each of ``shocks`` shocks in closed form, shape (shocks,).

    E[j] = E* + shock^j (E[0] - E*), whatever the wells cost; the caller asks
    whether each E[j] still reaches the crest. At shock = 1 it grows without
    bound, by dE each time.
    """
    count = np.arange(1, shocks + 1)
    if shock == 1.0:
        return np.asarray(start + count * gain_per_crest(angle_deg))
    rest = steady_energy(angle_deg, shock)
    return np.asarray(rest + shock**count * (start - rest))


def steady_energy(angle_deg: float, shock: float) -> float:
    """Return the fixed point E* = dE shock / (1 - shock); infinite from shock = 1 on."""
    if shock >= 1.0:
        return math.inf
    return gain_per_crest(angle_deg) * shock / (1.0 - shock)


def passage_margin(angle_deg: float, shock: float) -> float:
    """Return the energy over the next crest of a grain that came over the last one at rest.

    shock (C + dE) - C: its root is the critical angle, because the energy map
    is increasing and has its fixed point at the crest there.
    """
    depth = well_depth(angle_deg)
    return after_next_shock(depth, angle_deg, shock) - depth


def passage_margin_slope(angle_deg: float, shock: float) -> float:
    """Return the derivative of :func:`passage_margin` in 1/deg."""
    theta = math.radians(angle_deg)
    sixth = math.pi / 6.0
    per_radian = shock * math.sin(sixth + theta) + math.sin(sixth - theta)
    return math.radians(per_radian)
