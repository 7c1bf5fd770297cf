"""The contact law mdr, step by step: elastic-plastic-adhesive spheres, each side on a rigid flat.

Zunker and Kamrin, J. Mech. Phys. Solids 183, 105492 (part I: one contact) and 105493 (part II: many
contacts) (2024), by the method of dimensionality reduction (Popov and Hess). A side of a contact is
a sphere of radius R that a rigid flat presses in by the depth d; E' = E / (1 - nu^2), K and G are
its moduli. Springs, E' for each length, below an ellipse of the axes A and B give

    cos t = 1 - 2 d_e / A,   a = B/2 sin t,   F = E' A B / 8 (2 t - sin 2 t).

*Elastic*: A = 4 R, B = 2 R, d_e = d. *Yield*: from the mean pressure p = Y (1 + 1.75 exp(-4.4
d_max / R)) on, that of Hertz being 4 E' / (3 pi) sqrt(d / R), the ellipse has B = 2 a_max and
A = 4 p a_max / E' with a_max^2 = 2 d_max R - d_max^2 - d_Y (R - d_Y), and its depth is 0 where the
surface has sprung back (Boussinesq's displacement of a uniform pressure). *Adhesion*: springs hold
until they are longer by l = sqrt(2 pi a gamma / E') (part I, section 4). *Many contacts* (part II,
section 5): the radius grows with the volume that flows, and below the share psi_b of free surface a
pressure K times the mean displacement of the surface over the volume acts on each contact area. A
step takes the sums over the contacts of a body from the step before.

The papers leave open in which order a step goes. That order is the one of LAMMPS's pair style
granular, as its public source has it; the limit of small steps does not depend on it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled
from harness.model.conventions import Rules
from harness.solvers.kernels import Records, words

SCREENED = words(Rules, "mdr_growth")["screened"]

BODY = np.dtype(
    [(name, np.float64) for name in (
        "first_radius", "radius", "caps", "strain", "flow", "widening", "area", "area_before",
        "free_area", "displacement", "free_share", "volume", "elastic_volume", "growth",
    )]
)  # fmt: skip
SIDE = np.dtype(
    [(name, np.float64) for name in (
        "depth", "depth_in_first", "spring_depth", "bulk_depth", "largest", "yields", "intercept",
        "stuck", "area", "strain", "rest",
    )]
)  # fmt: skip


def first_state(radii: NDArray[np.float64]) -> NDArray[Any]:
    """Return the records of bodies that nothing has pressed yet, of radii [m] (N,)."""
    state = np.zeros(len(radii), dtype=BODY)
    state["first_radius"] = state["radius"] = radii
    state["volume"] = state["elastic_volume"] = 4.0 / 3.0 * np.pi * radii**3
    state["free_share"] = 1.0
    return state


@compiled
def clear(side: Records) -> None:
    """Forget a side of a contact that has ended."""
    side.depth = side.depth_in_first = side.spring_depth = side.bulk_depth = side.largest = 0.0
    side.yields = side.intercept = side.stuck = side.area = side.strain = side.rest = 0.0


@compiled
def grow(law: Records, rules: Records, body: Records) -> float:
    """Return the radius [m] that keeps the volume of a body, and clear its sums for a new step."""
    r, first = body.radius, body.first_radius
    sphere = 4.0 / 3.0 * math.pi * first**3
    body.volume = min(4.0 / 3.0 * math.pi * r**3 - body.caps, sphere)
    body.elastic_volume = sphere * (1.0 + body.strain)
    surface = 4.0 * math.pi * r * r + body.free_area
    body.free_share = (surface - body.area) / surface
    if law.bulk_share < body.free_share:
        grown = body.flow / (body.widening - 4.0 * math.pi * r * r)
        if rules.mdr_growth == SCREENED:
            near = 1.0 / (1.0 + math.exp(-75.0 * (body.free_share - 0.2)))
            grown *= near if body.free_share > 0.1 else 0.0
        if grown > 0.0:
            body.growth += (grown - body.growth) / rules.mdr_growth_steps
            if rules.mdr_growth != SCREENED or r + grown < 1.5 * first:
                body.radius += body.growth
    body.area_before = body.area
    body.caps = body.strain = body.flow = body.widening = 0.0
    body.area = body.free_area = body.displacement = 0.0
    return float(body.radius)


@compiled
def flat_depth(
    sides: Records, k: int, overlap: float, largest: float, radius: float, other: float
) -> float:
    """Return the depth of the flat in side k [m]: where the surfaces cross at the largest overlap.

    At a wall (``other`` 0) it is the overlap.
    """
    if other == 0.0:
        return overlap
    share = largest * (2.0 * other - largest) / (2.0 * (radius + other - largest))
    rest = sides[0].rest + sides[1].rest
    return float(share + (sides[k].rest - share) * (overlap - largest) / (rest - largest))


@compiled
def add_displacement(body: Records, side: Records, depth: float) -> None:
    """Add what a side moves in a step to the mean displacement of its body's surface."""
    if body.area_before != 0.0:
        body.displacement += side.area / body.area_before * (depth - side.depth)


@compiled
def ellipse_force(modulus: float, height: float, width: float, depth: float) -> float:
    """Return the force [N] of springs below an ellipse of axes A and B [m] at a depth [m]."""
    if depth <= 0.0:
        return 0.0
    t = 4.0 * math.asin(math.sqrt(depth / height))
    segment = t - math.sin(t)
    if t < 0.5:  # t - sin t without its cancellation
        series = 1.0
        for n in (13, 11, 9, 7, 5):
            series = 1.0 - t * t / (n * (n - 1)) * series
        segment = t**3 / 6.0 * series
    return 0.125 * modulus * height * width * segment


@compiled
def neck(length: float, height: float, width: float, a: float) -> tuple[float, float, float]:
    """Return the depth g(a) - l(a) at which springs at a let go, g(a), and the slope.

    ``length`` is l^2 / a = 2 pi gamma / E'.
    """
    root = math.sqrt(0.25 * width * width - a * a)
    g, stretched = height / width * a * a / (0.5 * width + root), math.sqrt(length * a)
    return g - stretched, g, height / width * a / root - 0.5 * stretched / a


@compiled
def least_neck(length: float, height: float, width: float) -> float:
    """Return the radius a [m] below which g(a) - l(a) grows again: the neck breaks."""
    low, high = 0.0, 0.5 * width
    middle = 0.5 * high
    while low < middle < high:
        if neck(length, height, width, middle)[2] < 0.0:
            low = middle
        else:
            high = middle
        middle = 0.5 * (low + high)
    return high


@compiled
def adhere(
    law: Records, rules: Records, side: Records, moves: bool, new: bool,
    axes: tuple[float, float], depth: float, largest_radius: float,
) -> tuple[float, float]:  # fmt: skip
    """Return force [N] and contact radius [m] of a side that sticks; ``new``: deepest so far."""
    modulus, (height, width) = 2.0 * law.stiffness, axes
    bare = width / height * math.sqrt((height - depth) * depth) if depth > 0.0 else 0.0
    stuck = min(side.stuck, rules.mdr_sticking_share * largest_radius)
    if new or bare >= stuck:
        if moves:
            side.stuck = rules.mdr_sticking_share * bare
        return ellipse_force(modulus, height, width, depth), stuck  # as the step before left it
    length = 2.0 * math.pi * law.surface_energy / modulus
    lets_go, g, slope = neck(length, height, width, stuck)
    if depth < lets_go:
        least = least_neck(length, height, width)
        for _ in range(100):
            if stuck < least or abs(lets_go - depth) < rules.mdr_newton_error:
                break
            change = (lets_go - depth) / slope
            stuck -= change
            lets_go, g, slope = neck(length, height, width, stuck)
            if abs(change) <= 4e-16 * stuck:
                break
        stuck = 0.0 if stuck < least else stuck
    if moves:
        side.stuck = stuck
    if stuck <= 0.0:
        return 0.0, 0.0
    elastic = ellipse_force(modulus, height, width, g)
    return elastic + 2.0 * modulus * (depth - g) * stuck, stuck


@compiled
def spring_back(law: Records, side: Records, radius: float) -> tuple[float, float, float]:
    """Return axis A, a_max and the part u of A/2 that the middle of a dent springs back [m]."""
    modulus, nu, most = 2.0 * law.stiffness, law.poisson_ratio, side.largest
    shear = 0.5 * modulus * (1.0 - nu)
    p = law.yield_stress * (1.0 + 1.75 * math.exp(-4.4 * most / radius))
    square = 2.0 * most * radius - most * most + side.intercept
    height = 4.0 * p / modulus * math.sqrt(square)
    z = radius - most + 0.5 * height
    far = math.sqrt(square + z * z)
    shape = 2.0 * (1.0 - nu) * square - (1.0 - 2.0 * nu) * z * (far - z)
    return height, math.sqrt(square), p / (2.0 * shear * far) * shape


@compiled
def side_force(
    law: Records, rules: Records, body: Records, side: Records, depth: float, moves: bool
) -> tuple[float, float]:
    """Return force [N] and contact radius [m] of a side at a depth [m]; steps bring it on."""
    r, first = body.radius, body.first_radius
    modulus, nu = 2.0 * law.stiffness, law.poisson_ratio
    bulk_modulus = modulus * (1.0 - nu * nu) / (3.0 * (1.0 - 2.0 * nu)) if nu < 0.5 else math.inf
    confined = body.free_share < law.bulk_share
    step, in_first = depth - side.depth, depth - (r - first)
    step_in_first = in_first - side.depth_in_first
    of_bulk = body.displacement if confined and moves else 0.0
    to_spring = step - of_bulk
    spring = side.spring_depth + (
        min(to_spring, depth - side.spring_depth) if confined else to_spring
    )
    bulk = max(0.0, side.bulk_depth + of_bulk)
    side.largest = max(side.largest, spring)
    new = spring == side.largest
    if moves:
        side.depth, side.depth_in_first = depth, in_first
        side.spring_depth, side.bulk_depth = spring, bulk
        hertz = 4.0 * modulus / (3.0 * math.pi) * math.sqrt(max(spring, 0.0) / r)
        limit = law.yield_stress * (1.0 + 1.75 * math.exp(-4.4 * side.largest / r))
        if side.yields == 0.0 and new and hertz > limit:
            side.yields, side.intercept = 1.0, spring * (spring - r)
    height, width, elastic, widest = 4.0 * r, 2.0 * r, spring, math.sqrt(side.largest * r)
    if side.yields > 0.0:
        height, widest, back = spring_back(law, side, r)
        width = 2.0 * widest
        elastic = (spring - side.largest + 0.5 * height - back) / (1.0 - 2.0 * back / height)
        if moves:
            side.rest = side.largest - 0.5 * height + back
    if law.surface_energy > 0.0:
        of_springs, a = adhere(law, rules, side, moves, new, (height, width), elastic, widest)
    else:
        of_springs = ellipse_force(modulus, height, width, elastic)
        a = width / height * math.sqrt((height - elastic) * elastic) if elastic > 0.0 else 0.0
    square = depth * r if side.yields == 0.0 else 2.0 * depth * r - depth * depth + side.intercept
    area, force = max(0.0, math.pi * square), of_springs
    if bulk > 0.0:
        force += body.area_before * bulk * bulk_modulus * area / body.volume
    if moves:
        flows = new and side.yields > 0.0 and of_springs > 0.0
        strain = -force * (first - in_first) / (3.0 * bulk_modulus * body.elastic_volume)
        add_sums(body, side, depth, area, strain, bulk, step_in_first, flows)
    return force, a


@compiled
def add_sums(
    body: Records, side: Records, depth: float, area: float, strain: float, bulk: float,
    step_in_first: float, flows: bool,
) -> None:  # fmt: skip
    """Add a side's share to the sums of its body, for the volume of the next step."""
    r, first, in_first = body.radius, body.first_radius, side.depth_in_first
    body.free_area += area - 2.0 * math.pi * r * (side.largest + bulk)
    body.area += area
    body.caps += math.pi / 3.0 * depth * depth * (3.0 * r - depth)
    body.strain += strain
    if flows:
        body.flow -= 4.0 / 3.0 * math.pi * first**3 * (strain - side.strain)
        squared = 2.0 * in_first * first - in_first * in_first + r * r - first * first
        body.flow -= math.pi * step_in_first * squared
        body.widening += 2.0 * math.pi * r * (in_first + r - first)
    side.area, side.strain = area, strain
