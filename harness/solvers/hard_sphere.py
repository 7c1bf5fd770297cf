"""The grain over rigid spheres with restitution, from event to event, and its critical angle.

In units of diameter, gravity and mass. The row's spheres have their centres at (j, 0), the grain's
centre stays at a distance of 1 or more from each. Gravity is (sin theta, -cos theta). On a sphere
the grain is at an angle beta from the vertical, positive ahead, where its potential energy over
the centre is cos beta. Hops die out into sliding, sliding ends in a shock.

The grain comes over a crest at rest and slides into the well, as in the passage of a DEM. Critical
is the smallest angle at which it passes the next crest, once its hops in the well have died out. Up
to a restitution of 0.7 that is also the smallest angle of steady motion, from whatever start;
above, the grain is in flight at the crest, and fates of different starts differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from harness.compiled import compiled
from harness.errors import RequestError
from harness.solvers.kernels import first_root

LOWEST = 0.8  # height over the row below any contact, sqrt(3) / 2: where a flight has ended
TOUCHING = 1e-13  # gap of a contact, to rounding
WELL = math.pi / 6.0  # from the row's normal, at which the grain touches two spheres
# how sliding ends: the normal force vanishes, another sphere is met, the grain comes to rest
LEAVES, SHOCK, TURNS = 0, 1, 2
# [sqrt(g d)] of a rebound from which on the hops add up to sliding: they take a time of
# 2 v / (N (1 - e)) in all, in which the grain moves along the sphere as if it slid, to order v^2
COLLAPSED = 1e-8
MOST_EVENTS = 1_000_000
MOVES_ON, TRAPPED, UNDECIDED = 1, 0, -1
MOST_RESTITUTION, WINDOW, SCAN, RESOLUTION_DEG = 0.7, (5.0, 15.0), 41, 1e-10


@cache
def critical_angle(restitution: float) -> float:
    """Return the critical angle [deg] of rigid spheres.

    Raise RequestError for a restitution outside 0 to 0.7.
    """
    if not 0.0 <= restitution <= MOST_RESTITUTION:
        raise RequestError(
            f"restitution = {restitution!r}: must be from 0 to {MOST_RESTITUTION:g}, above which "
            "the grain of rigid spheres flies over the crest"
        )
    return first_moving(lambda angle: passage(angle, restitution)[0])


@cache
def hops_end(restitution: float) -> float:
    """Return how far before the next crest [deg] the hops die out at the critical angle.

    Raise RequestError for a restitution outside 0 to 0.7.
    """
    return -math.degrees(passage(critical_angle(restitution), restitution)[4])


def passage(angle_deg: float, restitution: float) -> tuple[int, float, int, bool, float]:
    """Return what becomes of a grain that came over the last crest at rest.

    Its fate, the energy above that of rest on the next crest [m g d], the collisions, whether it
    slid at the end, and the angle ahead of the crest [rad] at which its hops died out, as
    :func:`harness.solvers.hard_sphere.follow` returns them.
    """
    theta = math.radians(angle_deg)
    speed = math.sqrt(2.0 * (1.0 - math.cos(WELL + theta)))
    vx, vy = speed * math.cos(WELL), -speed * math.sin(WELL)
    return follow(math.sin(WELL), math.cos(WELL), vx, vy, theta, restitution, 1, True)


def first_moving(fate: Callable[[float], int]) -> float:
    """Return the lowest angle [deg] from which on a grain moves, trapped just below it."""
    angles = np.linspace(*WINDOW, SCAN)
    moves = [fate(angle) == MOVES_ON for angle in angles]
    first = moves.index(True)
    low, high = float(angles[first - 1]), float(angles[first])
    while high - low > RESOLUTION_DEG:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fate(middle) == MOVES_ON else (middle, high)
    return 0.5 * (low + high)


# ---- flight, collision and sliding


@compiled
def flight(x: float, y: float, vx: float, vy: float, theta: float, last: int) -> tuple[float, int]:
    """Return how long the grain flies, and the sphere that it meets.

    ``last`` is the sphere from which it takes off: their gap at the start is 0 to rounding.
    """
    along, down = math.sin(theta), math.cos(theta)
    longest = (vy + math.sqrt(vy * vy + 2.0 * down * (y - LOWEST))) / down
    turn = min(max(-vx / along, 0.0), longest) if along > 0.0 else 0.0
    far = max(x, x + vx * longest + 0.5 * along * longest**2)
    near = min(x, x + vx * turn + 0.5 * along * turn**2)
    first, target, h = math.inf, last, longest  # times of the gap are in shares of the longest
    for sphere in range(math.floor(near) - 1, math.ceil(far) + 2):
        rx, ry = x - sphere, y
        gap = np.array([
            rx * rx + ry * ry - 1.0, 2.0 * h * (rx * vx + ry * vy),
            h**2 * (vx * vx + vy * vy + rx * along - ry * down), h**3 * (vx * along - vy * down),
            0.25 * h**4,
        ])  # fmt: skip
        touches = sphere == last or gap[0] <= TOUCHING
        if touches and sphere != last and gap[1] < TOUCHING:
            return 0.0, sphere  # it stands on it, and moves into it or along it
        gap[1] = max(gap[1], TOUCHING) if touches else gap[1]
        root = first_root(gap[int(touches) :], 0.0, 1.0)  # the contact at the start is none
        if root <= 1.0 and h * root < first:
            first, target = h * root, sphere
    return first, target


@compiled
def slide(energy: float, beta: float, forward: bool, theta: float) -> tuple[float, int]:
    """Return the angle at which sliding ends, and how: LEAVES, SHOCK, or TURNS.

    ``energy`` is v^2 / 2 + cos beta. The normal force cos beta - v^2 vanishes where
    cos beta = 2 E / 3, the speed where cos beta = E; the next sphere is met at WELL from the
    row's normal. Seen from behind, where the grain moves backward.
    """
    side = 1.0 if forward else -1.0
    beta, well = side * beta, WELL + side * theta
    if energy < 1.0 and beta < 0.0:
        return -side * math.acos(energy), TURNS
    leaves = math.acos(max(-1.0, min(1.0, 2.0 * energy / 3.0)))
    if leaves < well:
        return side * max(leaves, beta), LEAVES
    return side * well, SHOCK


@compiled
def follow(
    x: float, y: float, vx: float, vy: float, theta: float, e: float, wells: int, settle: bool
) -> tuple[int, float, int, bool, float]:
    """Follow the grain over ``wells`` crests, or until it has too little energy for the next.

    Position and velocity in units of d and sqrt(g d), theta in radians, x from the centre of
    sphere 0 whose crest lies behind. Return its fate, the energy above that of rest on the crest
    ahead [m g d], the number of collisions, whether it slid at the end, and the angle ahead of a
    crest [rad] at which its hops died out last (NaN: never). With ``settle`` a grain that will not
    pass is followed until its hops have died out, and its energy is taken there.
    """
    sine, cosine = math.sin(theta), math.cos(theta)
    crest, last, hits, settled = 1, -(10**9), 0, math.nan
    for _ in range(MOST_EVENTS):
        t, sphere = flight(x, y, vx, vy, theta, last)
        if not math.isfinite(t):
            break
        x, y = x + vx * t + 0.5 * sine * t * t, y + vy * t - 0.5 * cosine * t * t
        vx, vy = vx + sine * t, vy - cosine * t
        energy = 0.5 * (vx * vx + vy * vy) + y * cosine - x * sine
        while x > crest - sine:
            if crest == wells:
                return MOVES_ON, energy - 1.0 + crest * sine, hits, False, settled
            crest += 1
        nx, ny = x - sphere, y
        size = math.hypot(nx, ny)
        nx, ny = nx / size, ny / size
        into, hits = -(vx * nx + vy * ny), hits + 1
        along = vx * ny - vy * nx
        beta = math.atan2(nx, ny) + theta
        if e * into > COLLAPSED or math.cos(beta) <= along * along:
            vx, vy, last = vx + (1.0 + e) * into * nx, vy + (1.0 + e) * into * ny, sphere
            energy = 0.5 * (vx * vx + vy * vy) + y * cosine - x * sine
            if energy < 1.0 - crest * sine and not settle:
                return TRAPPED, energy - 1.0 + crest * sine, hits, False, settled
            continue
        # it slides, turning round where it comes to rest, until it flies or meets a sphere
        on_sphere = 0.5 * along * along + math.cos(beta)
        forward, ends, settled = along >= 0.0, -1, beta
        over = on_sphere - sphere * sine - 1.0 + crest * sine
        if over < 0.0:
            return TRAPPED, over, hits, True, settled
        if forward and sphere >= crest and beta <= 0.0:
            if crest == wells:
                return MOVES_ON, over, hits, True, settled
            crest += 1
        while ends not in (LEAVES, SHOCK):
            beta, ends = slide(on_sphere, beta, forward, theta)
            forward = forward if ends in (LEAVES, SHOCK) else not forward
        speed = math.sqrt(max(0.0, 2.0 * (on_sphere - math.cos(beta)))) * (1.0 if forward else -1.0)
        phi = beta - theta
        x, y = sphere + math.sin(phi), math.cos(phi)
        vx, vy, last = speed * math.cos(phi), -speed * math.sin(phi), sphere
    return UNDECIDED, 0.0, hits, False, settled
