"""Closed forms of the incline: geometry, energy from shock to shock, critical angle.

Lengths are in diameters d, energies in m g d, angles in degrees. The energy map is the source's
section on the Quartier model (Harper, Dufek and Breard). Positions and directions follow from two
conditions alone, that fixed spheres touch their neighbours and that the grain touches what it
stands on; the closed forms of the map are held against them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.errors import RequestError
from harness.theory.chain import SHOCK_WITHOUT_REBOUND

# ---- the energy map: kinetic energies just after the shock in the well


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


Points = NDArray[np.float64]


# ---- geometry in two dimensions
#
# Every vector has the components (along the row, downhill; normal to the row), unless turned() has
# tilted it. Wells, crests and turns follow.


def row(count: int) -> Points:
    """Return the centres of ``count`` touching fixed spheres (count, 2), the first at 0."""
    return np.column_stack([np.arange(float(count)), np.zeros(count)])


def resting_on(first: ArrayLike, second: ArrayLike) -> Points:
    """Return the centre (2,) of a sphere that touches two others from above."""
    first, second = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    along = second - first
    half = float(np.hypot(*along)) / 2
    up = np.array([-along[1], along[0]]) / (2 * half)
    return np.asarray((first + second) / 2 + math.sqrt(1 - half**2) * up)


def well(index: int) -> Points:
    """Return the grain's centre (2,) in the well after sphere ``index`` of the row."""
    return resting_on((index, 0), (index + 1, 0))


def crest(index: int, angle_deg: float) -> Points:
    """Return the grain's centre (2,) at its highest over sphere ``index``: right above it."""
    return np.array([float(index), 0.0]) - downwards(angle_deg)


def downwards(angle_deg: float) -> Points:
    """Return the direction of gravity (2,) on a row tilted by ``angle_deg``."""
    tilt = math.radians(angle_deg)
    return np.array([math.sin(tilt), -math.cos(tilt)])


def height(position: ArrayLike, angle_deg: float) -> float:
    """Return the height of a position against gravity [d]."""
    return -float(np.asarray(position, dtype=float) @ downwards(angle_deg))


def turned(points: ArrayLike, angle_deg: float) -> Points:
    """Return points (..., 2) with gravity straight down: (to the right, upwards)."""
    down = downwards(angle_deg)
    level = np.array([-down[1], down[0]])
    points = np.asarray(points, dtype=float)
    return np.stack([points @ level, -(points @ down)], axis=-1)


def angle_between(first: ArrayLike, second: ArrayLike) -> float:
    """Return the angle [deg] between two directions (2,)."""
    a, b = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    cross = float(a[0] * b[1] - a[1] * b[0])
    return math.degrees(math.atan2(abs(cross), float(a @ b)))


def path(first: int, last: int, each: int = 60) -> Points:
    """Return the grain's centre on its way from above sphere ``first`` to above ``last``.

    Shape (points, 2): arcs around the spheres, ``each`` points from well to well.
    """
    arcs = []
    for index in range(first, last + 1):
        start = well(index - 1) if index > first else np.array([index, 1.0])
        end = well(index) if index < last else np.array([index, 1.0])
        begins, ends = (math.atan2(p[1], p[0] - index) for p in (start, end))
        sweep = np.linspace(begins, ends, each)
        arcs.append(np.column_stack([index + np.cos(sweep), np.sin(sweep)]))
    return np.concatenate(arcs)


class Dynamics(NamedTuple):
    """The grain in the well on one of its two contacts.

    Forces in m g, velocities in sqrt(g d), all of shape (2,).
    """

    sphere: Points
    grain: Points
    weight: Points
    contact_force: Points
    velocity: Points

    @property
    def normal_weight(self) -> float:
        """Return the component of the weight along the contact, into the sphere [m g]."""
        return float(self.weight @ (self.sphere - self.grain))


def steady_shock(angle_deg: float, shock: float = SHOCK_WITHOUT_REBOUND) -> tuple[Dynamics, ...]:
    """Return the grain just before and just after the shock in steady motion.

    The kinetic energy after it is E* = dE shock / (1 - shock), before it E* + dE.
    On the circle of radius d around the sphere the contact gives what the
    weight's component lacks of, or has beyond, the centripetal force:
    F = m g cos - m v^2 / d.
    """
    energy = steady_energy(angle_deg, shock)
    before = energy + gain_per_crest(angle_deg)
    return _on_contact(0, before, angle_deg), _on_contact(1, energy, angle_deg)


def _on_contact(sphere: int, energy: float, angle_deg: float) -> Dynamics:
    """Return forces and velocity of the grain in well 0 as it slides on ``sphere`` (0 or 1)."""
    centre, grain, weight = row(2)[sphere], well(0), downwards(angle_deg)
    outwards = grain - centre
    onwards = np.array([outwards[1], -outwards[0]])
    centripetal = 2 * energy
    force = -float(weight @ outwards) - centripetal
    return Dynamics(centre, grain, weight, force * outwards, math.sqrt(centripetal) * onwards)


def towers(columns: int, layers: int) -> Points:
    """Return fixed spheres and ``layers`` upright layers on them (columns * (layers + 1), 2)."""
    return np.concatenate([row(columns) + np.array([0.0, level]) for level in range(layers + 1)])


def close_packed(columns: int, layers: int) -> Points:
    """Return the same number of layers, each sphere in a well of the layer below.

    Every other layer is shifted by half a diameter: straight lines of touching
    spheres run along the row and at 60 deg to it.
    """
    sideways, up = well(0)
    steps = [np.array([sideways * (level % 2), up * level]) for level in range(layers + 1)]
    return np.concatenate([row(columns) + step for step in steps])


def straight_chain(grain: ArrayLike, spheres: Points, sphere: ArrayLike) -> Points:
    """Return the spheres (L, 2) that touch in a straight line from the grain on, ``sphere`` first.

    The line ends where the next place along it is empty.
    """
    at = np.asarray(sphere, dtype=float)
    along, centres = at - np.asarray(grain, dtype=float), []
    while np.min(np.hypot(*(spheres - at).T)) < 1e-9:
        centres.append(at)
        at = at + along
    return np.array(centres)


# ---- critical angle

STATIC_ANGLE_DEG = 30.0
"""The tilt at which a grain at rest in a well stands on the crest and leaves it."""


def critical_angle(shock: float = SHOCK_WITHOUT_REBOUND) -> float:
    """Return theta_c [deg], the smallest tilt at which motion persists.

    From E* >= C with C + dE = 1 - cos(30 deg + theta) (units of m g d):
    shock = (1 - cos(30 - theta)) / (1 - cos(30 + theta))
    = (sin(15 - theta/2) / sin(15 + theta/2))^2, hence
    tan(theta/2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock)).
    It is 30 deg (the static angle) at shock 0 and 0 at shock 1. Raise
    RequestError unless 0 <= shock <= 1.
    """
    if not 0.0 <= shock <= 1.0:
        raise RequestError(f"shock = {shock!r} is not allowed: must be from 0 to 1")
    root = math.sqrt(shock)
    tangent = math.tan(math.pi / 12.0) * (1.0 - root) / (1.0 + root)
    return math.degrees(2.0 * math.atan(tangent))


def no_flight_bound(shock: float = SHOCK_WITHOUT_REBOUND) -> float:
    """Return the tilt [deg] above which the grain in steady motion leaves the row.

    Contact is weakest just before the shock, where the kinetic energy is
    dE / (1 - shock): m g cos(30 + theta) = 2 m g sin(theta) / (1 - shock).
    15.30 deg at shock = 1/4. Raise RequestError unless 0 <= shock < 1.
    """
    if not 0.0 <= shock < 1.0:
        raise RequestError(f"shock = {shock!r} is not allowed: must be from 0 to below 1")
    ratio = 2.0 / (1.0 - shock)
    return math.degrees(math.atan(math.cos(math.pi / 6.0) / (ratio + math.sin(math.pi / 6.0))))


# ---- the energy argument of the source's discussion: alpha = 1/sqrt(n)
#
# Under one force F, n equal springs in series store n times the energy of one, U_n = F^2 n / (2
# k), and so take up a velocity v = sqrt(2 U_n / m) that grows as sqrt(n) (source, eq. of the
# energy scaling). The velocity that the grain loses to a row of n is taken to fall as its inverse.
# The springs are k each: k/n is exact under the overlap law, not under the source's own.

LARGEST_HEIGHT = 10
"""Particles beyond which the source sees no longer contacts, and the scaling ends."""


def impulse_ratio(height: int) -> float:
    """Return alpha = 1/sqrt(n) of a tower of ``height`` n.

    Raise RequestError for a height below 1.
    """
    if height < 1:
        raise RequestError(f"height = {height!r} is not allowed: must be at least 1")
    return 1.0 / math.sqrt(height)
