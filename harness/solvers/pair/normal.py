"""The normal force of a contact over its overlap: springs, dashpots, mdr's yield and adhesion.

Forces of two spheres, or of a sphere and a plane, with the slopes that the location of events
needs. mdr is the law of Zunker and Kamrin, J. Mech. Phys. Solids 183, 105492 and 105493 (2024): in
it each of two equal spheres meets a rigid flat at half the overlap, and a wall is such a flat. The
formulas stand at the head of each section.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.solvers.pair.records import Records, compiled

# ---- elastic forces
#
# hooke: k delta. hertz: 4/3 E* a delta with a^2 = R* delta (Hertz 1882; Johnson 1985, section
# 4.2). dmt: Hertz less 4 pi gamma R* (Derjaguin, Muller and Toporov 1975). jkr (Johnson, Kendall
# and Roberts 1971; Johnson 1985, section 5.5), with the work of adhesion 2 gamma:
#
#     F = 4 E* a^3 / (3 R*) - 4 sqrt(pi gamma E* a^3),   delta = a^2 / R* - 2 sqrt(pi gamma a / E*).
#
# mdr (elastic): each of two equal spheres of radius R meets a rigid flat at half the overlap.
# There, by the method of dimensionality reduction, an ellipse of the half axes R and 2 R sinks
# into independent springs, E / (1 - nu^2) = 2 E* for each length: with
#
#     cos theta = 1 - delta / (4 R),   a = R sin theta,
#     F = 4 E* R^2 (theta - sin theta cos theta),
#
# Hertz's force to the first order in delta / R. A wall is a rigid flat: as half of two spheres. Of
# two sizes, R_1 and R_2, the flat lies where the surfaces cross at the largest overlap delta_m,
#
#     d_1 = delta (2 R_2 - delta_m) / (2 (R_1 + R_2 - delta_m)),   d_2 = delta - d_1,
#
# and the force is the mean of that on either side: they differ (to the first order by R_2 / R_1),
# and what is loaded at delta_m = delta comes back along another curve.

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
    radius, partner = radii
    most = largest if largest > 0.0 else overlap
    reach = radius + partner - most
    share = 0.5 * (2.0 * partner - most) / reach
    drift = 0.5 * (partner - radius) / reach**2 if largest == 0.0 else 0.0  # d(share)/d(most)
    first = at_flat(modulus, radius, share * overlap, False)
    second = at_flat(modulus, partner, (1.0 - share) * overlap, False)
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


# ---- dashpots: eta_n [kg/s], and how it grows with the overlap
#
# velocity: eta_0. mass_velocity: eta_0 m*. viscoelastic: eta_0 m* a (Brilliantov et al. 1996).
#
# secant: c sqrt(m* F/delta) with the elastic force F; the restitution depends on c alone. c = 2
# zeta for a linear spring, sqrt(5) zeta for Hertz's (Antypov and Elliott, EPL 94, 50004 (2011)),
# with zeta = -ln e / sqrt(pi^2 + ln^2 e). Tsuji, Tanaka and Ishida, Powder Technol. 71, 239
# (1992), fit the second one: alpha(e) sqrt(m F/delta) with the mass m = 2 m* of one of two equal
# spheres.
#
# stiffness (mdr's): c sqrt(m* k) with k = 2 E_eff a, the manual of LAMMPS says: the slope of the
# elastic force of two equal spheres, E_eff = E*, and of one on a rigid wall, E_eff = 2 E*.

NONE, VELOCITY, MASS_VELOCITY, VISCOELASTIC, SECANT, STIFFNESS = range(6)

KINDS = {
    "none": NONE,
    "velocity": VELOCITY,
    "mass_velocity": MASS_VELOCITY,
    "viscoelastic": VISCOELASTIC,
    "tsuji": SECANT,
    "coeff_restitution": SECANT,
    "mdr": STIFFNESS,
}

TSUJI = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
"""alpha(e) by powers of e: the fit to Tsuji's figure by Marshall, J. Comput. Phys. 228, 1541."""


def coefficient(law: ContactLaw, rules: Rules) -> float:
    """Return eta_0, or c of a secant dashpot and of one of the stiffness."""
    if law.restitution is None:
        return law.damping_coefficient or 0.0
    if law.damping == "tsuji":
        return tsuji(law.restitution) * math.sqrt(
            2.0 if rules.tsuji_mass == "twice_effective" else 1.0
        )
    logarithm = -math.log(law.restitution)
    zeta = logarithm / math.hypot(math.pi, logarithm)
    linear = law.normal == "hooke" or rules.hertz_restitution == "linear"
    return zeta * (2.0 if linear else math.sqrt(5.0))


def tsuji(restitution: float) -> float:
    """Return alpha(e)."""
    return sum(factor * restitution**power for power, factor in enumerate(TSUJI))


@compiled
def dashpot(
    kind: int, coefficient: float, mass: float, overlap: float, elastic: Elastic, modulus: float
) -> tuple[float, float]:
    """Return eta_n [kg/s] and d(eta_n)/d(overlap) [kg/(m s)] for the effective mass [kg].

    ``modulus`` is E_eff [Pa] of a dashpot that goes with the stiffness.
    """
    if kind == VELOCITY:
        return coefficient, 0.0
    if kind == MASS_VELOCITY:
        return coefficient * mass, 0.0
    if kind == VISCOELASTIC:
        eta = coefficient * mass * elastic.radius
        return eta, eta * elastic.growth
    if kind == SECANT and elastic.force > 0.0:
        eta = coefficient * math.sqrt(mass * elastic.force / overlap)
        return eta, 0.5 * eta * (elastic.slope / elastic.force - 1.0 / overlap)
    if kind == STIFFNESS:
        eta = coefficient * math.sqrt(mass * 2.0 * modulus * elastic.radius)
        return eta, 0.5 * eta * elastic.growth
    return 0.0, 0.0


# ---- mdr: yield of a sphere on a rigid flat
#
# With the flat at the distance d from the centre, the depth delta = R - d and the yield stress Y,
# the mean pressure is at most
#
#     p = Y (1 + 1.75 exp(-4.4 delta / R)),
#
# which Hertz's, 4 E' / (3 pi) sqrt(delta / R), reaches at delta_Y. From there on F = p pi a^2 with
# a^2 = 2 R delta - delta^2 - delta_Y (R_0 - delta_Y), which begins with Hertz's a^2 = R_0 delta_Y.
#
# Plastic flow keeps the volume: the apparent radius R swells by what the flat displaces,
#
#     4/3 pi R^3 - pi/3 delta^2 (3 R - delta) - V_0 e = constant,   e (1 + e) = -F d / (3 K V_0),
#
# V_0 = 4/3 pi R_0^3, where e is the mean elastic strain of the volume; it does not shrink, so that
# at first, while e falls faster, it is R_0. Both are functions of d alone as long as d falls.
#
# It springs back elastically by A/2 - u: A/2 = 2 p a / E' is how far a uniform pressure p on the
# circle of radius a moves the surface in its middle, u by how much it moves the centre of the
# sphere, z = R - delta + A/2 below (Boussinesq),
#
#     u = p / (2 G s) (2 (1 - nu) a^2 - (1 - 2 nu) z (s - z)),   s^2 = a^2 + z^2:
#
# as an ellipse of the axes A and B = 2 a, which is at A/2 at the largest depth and comes to 0
# there.
#
# A sphere that has swollen is that large: friction has its radius as the lever, and it turns with
# the moment of inertia 2/5 m R^2 (grown).

ELASTIC, PLASTIC, SWELLING = range(3)
"""Stages of a contact that is pressed in."""

NEVER = 1e300
"""[m] of a depth that is not reached."""


class Dent(NamedTuple):
    """Elastic rebound of a plastic contact: its ellipse, and the residual depth [m].

    The ellipse is at ``stretch`` times the depth less the residual one.
    """

    height: float
    width: float
    residual: float
    stretch: float


class Pressed(NamedTuple):
    """The force of yield [N] at a depth, its slopes at a fixed radius and with the radius."""

    force: float
    slope: float
    by_radius: float  # at a fixed distance of the flat
    square: float  # a^2 [m2]
    pressure: float


@compiled
def _pressed(stress: float, onset: float, first: float, depth: float, radius: float) -> Pressed:
    soft = 1.75 * stress * math.exp(-4.4 * depth / radius)
    p, falls = stress + soft, -4.4 * soft / radius
    square = depth * (2.0 * radius - depth) - onset * (first - onset)
    slope = math.pi * (2.0 * (radius - depth) * p + square * falls)
    by_radius = math.pi * (2.0 * depth * p - square * falls * depth / radius)
    return Pressed(math.pi * square * p, slope, slope + by_radius, square, p)


@compiled
def _kept(
    law: Records, onset: float, radius: float, depth: float, swelling: float
) -> tuple[float, float, float]:
    """Return what volume is kept [m3], and its slopes with the flat's way and with the swelling.

    Less that of the sphere; ``depth`` is that of the flat in the sphere as it was.
    """
    now, away = radius + swelling, radius - depth
    real = depth + swelling
    load = _pressed(law.yield_stress, onset, radius, real, now)
    sphere = 4.0 / 3.0 * math.pi * radius**3
    share = 1.0 / (3.0 * law.bulk_modulus)
    root = math.sqrt(1.0 - 4.0 * share * load.force * away / sphere)
    strained = -2.0 * share * load.force * away / (1.0 + root)  # V_0 e
    more = 4.0 / 3.0 * math.pi * swelling * (3.0 * radius * (radius + swelling) + swelling**2)
    cap = math.pi / 3.0 * real**2 * (3.0 * now - real)
    by_way = (
        -math.pi * (now - away) * (now + away) + share * (load.slope * away - load.force) / root
    )
    by_swelling = 2.0 * math.pi * now * (2.0 * now - real) + share * load.by_radius * away / root
    return more - cap - strained, by_way, by_swelling


def yield_depth(modulus: float, stress: float, radius: float) -> float:
    """Return delta_Y [m] of E' [Pa], Y [Pa] and R_0 [m]; NEVER where it is beyond the radius."""

    def elastic_at(depth: float) -> bool:
        hertz = 4.0 * modulus / (3.0 * math.pi) * math.sqrt(depth / radius)
        return bool(hertz < _pressed(stress, 0.0, 0.0, depth, radius).pressure)

    depth = _bisect(elastic_at, 0.0, radius)
    return depth if depth < radius else NEVER


def swelling_depth(law: Records, onset: float, radius: float) -> float:
    """Return the depth [m] from which on the radius swells; NEVER where it is beyond the radius."""
    if onset >= radius or _kept(law, onset, radius, onset, 0.0)[1] < 0.0:
        return onset
    depth = _bisect(lambda depth: _kept(law, onset, radius, depth, 0.0)[1] > 0.0, onset, radius)
    return depth if depth < radius else NEVER


def _bisect(below: Callable[[float], bool], low: float, high: float) -> float:
    """Return the least number of an interval that is not ``below`` a root, to the last bit."""
    for _ in range(300):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if below(middle) else (low, middle)
    return high


@compiled
def swelling(law: Records, contact: Records, depth: float, radius: float) -> tuple[float, float]:
    """Return R - R_0 [m] at a depth in the sphere as it was, and its slope."""
    onset = contact.onset
    if depth <= contact.swells:
        return 0.0, 0.0
    kept = _kept(law, onset, radius, contact.swells, 0.0)[0]
    grown = 0.0
    for _ in range(50):
        now, by_way, by_swelling = _kept(law, onset, radius, depth, grown)
        change = (now - kept) / by_swelling
        grown -= change
        if abs(change) <= 4e-16 * depth:
            break
    return grown, -by_way / by_swelling


@compiled
def next_stage(contact: Records) -> float:
    """Return the overlap [m] at which a contact that closes yields, or swells."""
    flats = 1.0 if contact.second < 0 else 2.0
    if contact.stage == ELASTIC:
        return float(flats * contact.onset)
    return float(flats * contact.swells) if contact.stage == PLASTIC else NEVER


@compiled
def loaded(law: Records, contact: Records, depth: float, radius: float) -> Elastic:
    """Return the force of a contact that yields, pressed in further than ever."""
    grown, rate = swelling(law, contact, depth, radius)
    if contact.stage < SWELLING:
        grown, rate = 0.0, 0.0
    load = _pressed(law.yield_stress, contact.onset, radius, depth + grown, radius + grown)
    slope = load.slope + rate * load.by_radius
    flat = radius - depth  # of the flat from the centre, which stays as the radius grows
    widens = (flat * (1.0 + rate) + (depth + grown) * rate) / load.square  # d(ln a)/d(depth)
    return Elastic(load.force, slope, math.sqrt(load.square), widens)


@compiled
def grown(law: Records, contact: Records, overlap: float) -> tuple[float, float]:
    """Return by how much the radius of a sphere in a contact has grown [m], d(that)/d(overlap).

    ``overlap`` [m] is that of the spheres as they were.
    """
    if not law.yields or contact.stage < SWELLING:
        return 0.0, 0.0
    flats = 1.0 if contact.second < 0 else 2.0
    most = max(overlap, contact.largest)
    more, rate = swelling(law, contact, most / flats, contact.first_radius)
    return more, rate / flats if overlap >= contact.largest else 0.0


@compiled
def sprung_back(law: Records, contact: Records, largest: float, radius: float) -> Dent:
    """Return how a contact springs back from its largest depth in the sphere as it was."""
    grown, _ = swelling(law, contact, largest, radius)
    now, depth = radius + grown, largest + grown
    load = _pressed(law.yield_stress, contact.onset, radius, depth, now)
    a2, a, p = load.square, math.sqrt(load.square), load.pressure
    middle = p * a / law.stiffness  # 2 p a / E'
    z = now - depth + middle
    s = math.sqrt(a2 + z * z)
    along = 2.0 * (1.0 - law.poisson) * a2 - (1.0 - 2.0 * law.poisson) * z * (s - z)
    u = p / (2.0 * law.shear_modulus * s) * along
    return Dent(2.0 * middle, 2.0 * a, largest - (middle - u), 1.0 / (1.0 - u / middle))


@compiled
def remembers(law: Records, contact: Records) -> bool:
    """Return whether a contact that does not yield opens along another curve than it closed."""
    uneven = contact.first_radius != contact.second_radius
    return bool(law.normal == MDR and (uneven or law.surface > 0.0))


# ---- mdr: the branches that are not elastic alone
#
# Two equal spheres meet a flat between them, each at half the overlap; a wall is one. With E' = E
# / (1 - nu^2), the depth delta of the flat, and by the method of dimensionality reduction an
# ellipse of the half axes A/2 along the motion and B/2 across that sinks into springs, E' for each
# length:
#
#     cos theta = 1 - 2 delta_e / A,   a = B/2 sin theta,
#     F = E' A B / 4 (theta - sin theta cos theta)
#
# elastic: A = 4 R, B = 2 R, delta_e = delta. Yield: as above. Adhesion, of the energy gamma of
# sphere and flat: as the contact opens, springs hold on until they are longer by l(a) = sqrt(2 pi
# a gamma / E'), those at the edge first: with the depth g(a) = A/2 (1 - cos theta)
#
#     F = E' A B / 4 (theta - sin theta cos theta) - 2 E' a l(a),   delta = g(a) - l(a),
#
# which is JKR for small a / R, down to the a below which delta grows again; before, a stays that
# of the largest depth.
#
# Bulk response, of one contact: the mean displacement of its surface is delta, so that nothing is
# left to the ellipse; a pressure of the bulk modulus K times the volume displaced, A_c delta, over
# that of the sphere without its cap acts on the area A_c = pi R delta:
#
#     F = K A_c^2 delta / (4/3 pi R^3 - pi/3 delta^2 (3 R - delta)).


@compiled
def pressed(law: Records, contact: Records, overlap: float) -> Elastic:
    """Return the elastic normal force of a contact at an overlap [m], of any law."""
    wall = contact.second < 0
    if law.normal != MDR or not (law.bulk or law.yields or law.surface > 0.0):
        if law.normal == MDR and wall:
            return at_flat(law.stiffness, contact.curvature, overlap, law.wall_magnified)
        if remembers(law, contact):
            radii = (contact.first_radius, contact.second_radius)
            return between(law.stiffness, radii, overlap, contact.largest)
        stiffness = law.stiffness * contact.factor
        return elastic(law.normal, stiffness, law.surface, contact.curvature, overlap)
    share = 1.0 if wall else 0.5
    radius = contact.curvature / share
    bare = _on_flat(law, contact, share * overlap, share * contact.largest, radius)
    more, rise = 0.0, 0.0
    if wall and law.wall_magnified:
        more = math.exp(MAGNIFIED[0] * overlap / radius + MAGNIFIED[1])
        rise = more * MAGNIFIED[0] / radius
    slope = share * (1.0 + more) * bare.slope + rise * bare.force
    return Elastic((1.0 + more) * bare.force, slope, bare.radius, share * bare.growth)


@compiled
def _on_flat(
    law: Records, contact: Records, depth: float, largest: float, radius: float
) -> Elastic:
    modulus = 2.0 * law.stiffness
    if law.surface > 0.0:
        if depth < largest:
            return held(modulus, law.surface, radius, contact.least, depth, largest)
        return ellipse(modulus, 4.0 * radius, 2.0 * radius, depth)
    if depth <= 0.0:
        return Elastic(0.0, 0.0, 0.0, 0.0)
    if law.bulk:
        return _bulk(law.bulk_modulus, radius, depth)
    if contact.stage < PLASTIC:
        return ellipse(modulus, 4.0 * radius, 2.0 * radius, depth)
    if depth < largest:
        dent = sprung_back(law, contact, largest, radius)
        bare = ellipse(modulus, dent.height, dent.width, (depth - dent.residual) * dent.stretch)
        return Elastic(
            bare.force, dent.stretch * bare.slope, bare.radius, dent.stretch * bare.growth
        )
    return loaded(law, contact, depth, radius)


@compiled
def ellipse(modulus: float, height: float, width: float, depth: float) -> Elastic:
    """Return force and slope of springs, E' for a length, under an ellipse of axes A and B."""
    if depth <= 0.0:
        return Elastic(0.0, 0.0, 0.0, 0.0)
    theta = 2.0 * math.asin(math.sqrt(min(1.0, depth / height)))
    a = 0.5 * width * math.sin(theta)
    growth = 2.0 * math.cos(theta) / (height * math.sin(theta) ** 2)
    force = 0.125 * modulus * height * width * segment(2.0 * theta)
    return Elastic(force, 2.0 * modulus * a, a, growth)


@compiled
def _bulk(bulk_modulus: float, radius: float, depth: float) -> Elastic:
    area = math.pi * radius * depth
    cap = math.pi / 3.0 * depth**2 * (3.0 * radius - depth)
    volume = 4.0 / 3.0 * math.pi * radius**3 - cap
    force = bulk_modulus * area**2 * depth / volume
    slope = force * (3.0 / depth + math.pi * depth * (2.0 * radius - depth) / volume)
    return Elastic(force, slope, math.sqrt(radius * depth), 0.5 / depth)


@compiled
def sunk(modulus: float, surface: float, radius: float, a: float) -> tuple[float, float, float]:
    """Return g(a), l(a) and d(g - l)/da of an elastic sphere on a flat."""
    root = math.sqrt((radius - a) * (radius + a))
    length = math.sqrt(2.0 * math.pi * a * surface / modulus)
    return 2.0 * a * a / (radius + root), length, 2.0 * a / root - 0.5 * length / a


def fold(modulus: float, surface: float, radius: float) -> tuple[float, float]:
    """Return the contact radius below which the depth grows again, and the depth there [m]."""
    if surface <= 0.0:
        return 0.0, 0.0
    a = _bisect(lambda a: sunk(modulus, surface, radius, a)[2] < 0.0, 0.0, radius)
    g, length, _ = sunk(modulus, surface, radius, a)
    return a, g - length


@compiled
def held(
    modulus: float, surface: float, radius: float, least: float, depth: float, largest: float
) -> Elastic:
    """Return the force of a contact that opens and sticks, from the largest depth on.

    ``least`` is the contact radius of :func:`fold`.
    """
    a = math.sqrt(max(0.0, largest * (radius - 0.25 * largest)))
    g, length, rate = sunk(modulus, surface, radius, a)
    if a <= least or depth >= g - length:
        force = ellipse(modulus, 4.0 * radius, 2.0 * radius, g).force
        return Elastic(force + 2.0 * modulus * a * (depth - g), 2.0 * modulus * a, a, 0.0)
    for _ in range(100):  # from above, where g - l rises and is convex, down to the root
        change = (g - length - depth) / rate
        a = max(a - change, least)
        g, length, rate = sunk(modulus, surface, radius, a)
        if change <= 4e-16 * a or a == least:
            break
    rate = max(rate, 1e-12 * a / radius)
    force = ellipse(modulus, 4.0 * radius, 2.0 * radius, g).force - 2.0 * modulus * a * length
    slope = 2.0 * modulus * (a * rate - length) / rate
    return Elastic(force, slope, a, 1.0 / (a * rate))
