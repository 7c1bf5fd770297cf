"""Adhesion of elastic spheres: forces and overlaps of pull-off, and what an impact loses by it.

gamma is the surface energy of each body, 2 gamma the work of adhesion. Derjaguin, Muller and
Toporov, J. Colloid Interface Sci. 53, 314 (1975); Johnson, Kendall and Roberts, Proc. R. Soc. A
324, 301 (1971): with c^2 = pi gamma / E* and the contact radius a

    F = E* (4 a^3 / (3 R*) - 4 c a^(3/2)),   overlap = a^2 / R* - 2 c sqrt(a),

and a^3 = s c^2 R*^2 with s = 9 without load, 4 where contact forms (overlap 0), 9/4 at the largest
tension, 1/4 at the fold beyond which no area is left.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

State = Literal["without load", "contact forms", "largest tension", "fold"]
SIZES: dict[State, float] = {
    "without load": 9.0,
    "contact forms": 4.0,
    "largest tension": 2.25,
    "fold": 0.25,
}


def dmt_pull_off(surface_energy: float, radius: float) -> float:
    """Return 4 pi gamma R* [N], the tension at overlap 0."""
    return 4.0 * math.pi * surface_energy * radius


def jkr_pull_off(surface_energy: float, radius: float) -> float:
    """Return 3 pi gamma R* [N], the largest tension, whatever the modulus."""
    return 3.0 * math.pi * surface_energy * radius


def jkr_contact_radius(state: State, surface_energy: float, modulus: float, radius: float) -> float:
    """Return a [m] of a state that stands out."""
    cube = SIZES[state] * math.pi * surface_energy * radius**2 / modulus
    return float(cube ** (1.0 / 3.0))


def jkr_overlap(state: State, surface_energy: float, modulus: float, radius: float) -> float:
    """Return the overlap [m] of a state: a^2 / R* (1 - 2 / sqrt(s)), negative after pull-off."""
    a = jkr_contact_radius(state, surface_energy, modulus, radius)
    return a * a / radius * (1.0 - 2.0 / math.sqrt(SIZES[state]))


def mdr_force_and_depth(
    surface_energy: float, modulus: float, radius: float, a: float
) -> tuple[float, float]:
    """Return force [N] and depth [m] of a sphere that sticks to a flat and is pulled, by mdr.

    ``modulus`` is E / (1 - nu^2), ``surface_energy`` that of sphere and flat, ``a`` the contact
    radius [m]; Zunker and Kamrin, J. Mech. Phys. Solids 183, 105492 (2024), elastic.
    """
    angle = math.asin(a / radius)
    length = math.sqrt(2.0 * math.pi * a * surface_energy / modulus)
    pressed = 2.0 * modulus * radius**2 * (angle - math.sin(angle) * math.cos(angle))
    depth = 4.0 * radius * math.sin(0.5 * angle) ** 2 - length
    return pressed - 2.0 * modulus * a * length, depth


def mdr_pull_off(surface_energy: float, modulus: float, radius: float) -> tuple[float, float]:
    """Return the largest tension [N], and the depth at which no area is left [m], by mdr.

    With a = R sin t the force is least where 2 R sin t tan t = 3/2 l, the depth where that is l/2;
    for small a / R these are JKR's 3/2 pi gamma R and fold. Arguments as those of
    :func:`mdr_force_and_depth`.
    """

    def radius_where(part: float) -> float:
        def excess(a: float) -> float:
            length = math.sqrt(2.0 * math.pi * a * surface_energy / modulus)
            return 2.0 * a * a / math.sqrt((radius - a) * (radius + a)) - part * length

        return _root(excess, 0.0, radius)

    tension, _ = mdr_force_and_depth(surface_energy, modulus, radius, radius_where(1.5))
    _, last = mdr_force_and_depth(surface_energy, modulus, radius, radius_where(0.5))
    return -tension, last


def _root(excess: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function that is negative just above ``low`` turns positive, to round-off."""
    while low < (middle := 0.5 * (low + high)) < high:
        if excess(middle) < 0.0:
            low = middle
        else:
            high = middle
    return high
