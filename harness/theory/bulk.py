"""Scales of many grains that are known: a silo's discharge and walls, the depth of an impact."""

from __future__ import annotations

import math

BEVERLOO_FACTOR = 0.58
"""C of Beverloo's law; 0.55 to 0.65 was measured."""

BEVERLOO_MARGIN = 1.5
"""[diameters] k of Beverloo's law: what an orifice loses; 1.2 to 3 was measured."""


DEPTH_FACTOR = 0.14
"""Of the depth of an impact."""

GLASS_BEADS = 0.45
"""Tangent of the angle of repose of glass beads, 24 deg: Katsuragi and Durian, Nature Phys. 3, 420
(2007)."""


def friction_by_depth(depth: float, fall: float, diameter: float, density_ratio: float) -> float:
    """Return the tangent of the angle of repose of a bed that a sphere enters so deep.

    ``depth`` d and ``fall`` down to the surface [m], ``diameter`` D of the sphere [m] and its
    density over that of the bed with its voids: d = 0.14/mu (rho_s/rho_b)^(1/2) D^(2/3) H^(1/3)
    with H = fall + depth. Uehara, Ambroso, Ojha and Durian, Phys. Rev. Lett. 90, 194301 (2003);
    explained by forces k z and m v^2/d_1 (Katsuragi and Durian, Phys. Rev. E 87, 052208 (2013)).
    """
    lengths = (diameter / depth) ** 2 * (1.0 + fall / depth)
    return float(DEPTH_FACTOR * math.sqrt(density_ratio) * lengths ** (1.0 / 3.0))


def beverloo_scale(orifice: float, grain: float, bulk_density: float, gravity: float) -> float:
    """Return rho_b sqrt(g) (D - k d)^(5/2) [kg/s]: C times it is the discharge rate.

    ``orifice`` D and ``grain`` d are diameters [m], ``bulk_density`` [kg/m3], ``gravity`` [m/s2];
    0 where nothing passes. Beverloo, Leniger and van de Velde, Chem. Eng. Sci. 15, 260 (1961).
    """
    free = max(orifice - BEVERLOO_MARGIN * grain, 0.0)
    return float(bulk_density * math.sqrt(gravity) * free**2.5)


def janssen_share(height: float, radius: float, friction: float, ratio: float) -> float:
    """Return the share of the weight in an upright cylinder that its walls bear.

    ``height`` of the grains and ``radius`` [m], ``friction`` of the wall, fully mobilised, and
    ``ratio`` K of horizontal to vertical stress: 1 - (1 - exp(-x))/x with x = 2 mu K h/R.
    Janssen, Z. Ver. Dtsch. Ing. 39, 1045 (1895).
    """
    x = 2.0 * friction * ratio * height / radius
    return 1.0 + math.expm1(-x) / x if x > 0.0 else 0.0
