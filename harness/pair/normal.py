"""The elastic normal force of two spheres, or of a sphere and a plane, over their overlap.

hooke: k delta. hertz: 4/3 E* a delta with a^2 = R* delta (Hertz 1882; Johnson 1985, section 4.2).
dmt: Hertz less 4 pi gamma R* (Derjaguin, Muller and Toporov 1975). jkr (Johnson, Kendall and
Roberts 1971; Johnson 1985, section 5.5), with the work of adhesion 2 gamma:

    F = 4 E* a^3 / (3 R*) - 4 sqrt(pi gamma E* a^3),   delta = a^2 / R* - 2 sqrt(pi gamma a / E*).

mdr (Zunker and Kamrin 2024, elastic): each of two equal spheres of radius R meets a rigid flat at
half the overlap. There, by the method of dimensionality reduction, an ellipse of the half axes R
and 2 R sinks into independent springs, E / (1 - nu^2) = 2 E* for each length: with

    cos theta = 1 - delta / (4 R),   a = R sin theta,   F = 4 E* R^2 (theta - sin theta cos theta),

Hertz's force to the first order in delta / R. A wall is a rigid flat: as half of two spheres. Of
two sizes, R_1 and R_2, the flat lies where the surfaces cross at the largest overlap delta_m,

    d_1 = delta (2 R_2 - delta_m) / (2 (R_1 + R_2 - delta_m)),   d_2 = delta - d_1,

and the force is the mean of that on either side: they differ (to the first order by R_2 / R_1), and
what is loaded at delta_m = delta comes back along another curve.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from harness.pair.vectors import compiled

HOOKE, HERTZ, DMT, JKR, MDR = range(5)

MAGNIFIED = (10.7, -10.0)
"""LAMMPS multiplies the force of mdr at a wall by 1 + exp(10.7 delta / R - 10)."""


class Elastic(NamedTuple):
    """Force [N] and its slope [N/m], contact radius a [m] and d(ln a)/d(overlap) [1/m]."""

    force: float
    slope: float
    radius: float
    growth: float


@compiled
def elastic(
    law: int, stiffness: float, surface: float, curvature: float, overlap: float
) -> Elastic:
    """Return the elastic force at an overlap [m].

    ``stiffness`` is k [N/m] for hooke, else E* [Pa]; ``surface`` gamma [J/m2]; ``curvature`` R*.
    """
    if law == JKR:
        return _jkr(stiffness, surface, curvature, overlap)
    if overlap <= 0.0:
        pull = 4.0 * math.pi * surface * curvature if law == DMT else 0.0
        return Elastic(-pull, 0.0, 0.0, 0.0)
    if law == MDR:
        return _mdr(stiffness, 2.0 * curvature, overlap)
    a = math.sqrt(curvature * overlap)
    growth = 0.5 / overlap
    if law == HOOKE:
        return Elastic(stiffness * overlap, stiffness, a, growth)
    pull = 4.0 * math.pi * surface * curvature if law == DMT else 0.0
    return Elastic(4.0 / 3.0 * stiffness * a * overlap - pull, 2.0 * stiffness * a, a, growth)


@compiled
def at_flat(modulus: float, radius: float, overlap: float, magnified: bool) -> Elastic:
    """Return mdr's force of a sphere on a rigid wall: that on its mirror image."""
    if overlap <= 0.0:
        return Elastic(0.0, 0.0, 0.0, 0.0)
    bare = _mdr(modulus, radius, 2.0 * overlap)
    more = math.exp(MAGNIFIED[0] * overlap / radius + MAGNIFIED[1]) if magnified else 0.0
    slope = 2.0 * (1.0 + more) * bare.slope + more * MAGNIFIED[0] / radius * bare.force
    return Elastic((1.0 + more) * bare.force, slope, bare.radius, 2.0 * bare.growth)


@compiled
def _mdr(modulus: float, radius: float, overlap: float) -> Elastic:
    """Return mdr's force of two spheres of a radius, of E* ``modulus``."""
    theta = 2.0 * math.asin(math.sqrt(0.125 * overlap / radius))
    a = radius * math.sin(theta)
    growth = math.cos(theta) / (4.0 * radius * math.sin(theta) ** 2)
    return Elastic(2.0 * modulus * radius**2 * segment(2.0 * theta), 2.0 * modulus * a, a, growth)


@compiled
def between(modulus: float, radii: tuple[float, float], overlap: float, largest: float) -> Elastic:
    """Return mdr's force of two spheres of radii R_1, R_2 [m], of E* ``modulus``.

    ``largest`` is the overlap from which it came back; 0 while it is the largest itself.
    """
    if overlap <= 0.0:
        return Elastic(0.0, 0.0, 0.0, 0.0)
    one, other = radii
    most = largest if largest > 0.0 else overlap
    reach = one + other - most
    share = 0.5 * (2.0 * other - most) / reach
    drift = 0.5 * (other - one) / reach**2 if largest == 0.0 else 0.0  # d(share)/d(most)
    first = at_flat(modulus, one, share * overlap, False)
    second = at_flat(modulus, other, (1.0 - share) * overlap, False)
    slope = (share + drift * overlap) * first.slope + (1.0 - share - drift * overlap) * second.slope
    growth = (share + drift * overlap) * first.growth
    return Elastic(0.5 * (first.force + second.force), 0.5 * slope, first.radius, growth)


@compiled
def segment(twice: float) -> float:
    """Return twice - sin(twice), to round-off."""
    if twice >= 0.5:
        return twice - math.sin(twice)
    series = 1.0  # there the difference would lose its digits
    for n in (13, 11, 9, 7, 5):
        series = 1.0 - twice * twice / (n * (n - 1)) * series
    return float(twice**3 / 6.0 * series)


@compiled
def pull_off_force(law: int, surface: float, curvature: float) -> float:
    """Return the largest tension [N]: 4 pi gamma R* (dmt), 3 pi gamma R* (jkr), else 0."""
    if law == DMT:
        return 4.0 * math.pi * surface * curvature
    return 3.0 * math.pi * surface * curvature if law == JKR else 0.0


@compiled
def last_overlap(law: int, modulus: float, surface: float, curvature: float, fold: bool) -> float:
    """Return the overlap [m] at which a contact that opens ends; 0 but for jkr.

    jkr: at its largest tension, a^3 = 9 pi gamma R*^2 / (4 E*), delta = -a^2 / (3 R*); or at the
    ``fold``, where d(delta)/da = 0: a^3 = pi gamma R*^2 / (4 E*), delta = -3 a^2 / R*.
    """
    if law != JKR:
        return 0.0
    cube = math.pi * surface * curvature**2 / (4.0 * modulus)
    if fold:
        return float(-3.0 * cube ** (2.0 / 3.0) / curvature)
    return float(-((9.0 * cube) ** (2.0 / 3.0)) / (3.0 * curvature))


@compiled
def _jkr(modulus: float, surface: float, curvature: float, overlap: float) -> Elastic:
    a = _jkr_radius(modulus, surface, curvature, overlap)
    root = math.sqrt(math.pi * surface * modulus * a)
    spread = 2.0 * a / curvature - root / (modulus * a)  # d(overlap)/da, 0 at the fold
    force = 4.0 * modulus * a**3 / (3.0 * curvature) - 4.0 * root * a
    slope = 4.0 * modulus * a * a / curvature - 6.0 * root
    spread = max(spread, 1e-12 * a / curvature)
    return Elastic(force, slope / spread, a, 1.0 / (a * spread))


@compiled
def _jkr_radius(modulus: float, surface: float, curvature: float, overlap: float) -> float:
    """Return a on the stable branch, by Newton's method in s = sqrt(a) from above the root.

    s^4 / R* - 2 c s - delta = 0 with c = sqrt(pi gamma / E*) is convex for s > 0 and rises from
    the fold s^3 = c R* / 2 on, so that the iteration falls to the root without passing it.
    """
    c = math.sqrt(math.pi * surface / modulus)
    fold = float((0.5 * c * curvature) ** (1.0 / 3.0))
    if fold**4 / curvature - 2.0 * c * fold >= overlap:
        return fold * fold
    s = float((2.0 * c * curvature) ** (1.0 / 3.0) + max(overlap * curvature, 0.0) ** 0.25)
    for _ in range(60):
        change = (s**4 / curvature - 2.0 * c * s - overlap) / (4.0 * s**3 / curvature - 2.0 * c)
        s -= change
        if change <= 4e-16 * s:
            break
    return s * s
