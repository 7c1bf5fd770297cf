"""Closed forms of the incline: geometry, energy from shock to shock, critical angle.

A rigid grain of radius R, inertia beta m R^2, moves over a row of fixed touching spheres of radius
r. Its centre is on arcs of radius a = R + r. Lengths are in a, speeds in sqrt(g a), energies in
m g a, angles in degrees. Unless a half angle of the well is given the grain is as large as the
spheres: then a is a diameter.

Well. The grain touches two spheres, phi = asin(r / (R + r)) on either side of the row's normal. On
a row tilted by theta an arc begins at the angle theta - phi from the vertical, and ends at
theta + phi.

Shock in the well, without rebound. The direction of motion turns by 2 phi, c = cos(2 phi), and the
sphere ahead exerts the only impulses: normal, m v sin(2 phi), and tangential, P. Both drive the
grain off the sphere behind as long as it moves on at all. With v the speed of the centre and w that
of the rim, v' = c v + P / m and w' = w - P / (beta m). Without friction P = 0. Without slip after
the shock v' = w', which is angular momentum about the new contact: (1 + beta) v' = c v + beta w. A
grain that rolled (w = v) keeps the share s = (c + beta) / (1 + beta) of its speed. That takes
P = m v beta (1 - c) / (1 + beta), hence a friction of at least P / (m v sin(2 phi)) =
beta / (1 + beta) tan(phi). The *shock* is s^2, the energy after over the energy before.

Critical angle. With share s at each shock and no loss on the arcs, a grain that leaves a crest from
rest just reaches the next one if s^2 (1 - cos(phi + theta)) = 1 - cos(phi - theta). That is
without friction, and where the grain rolls all along, which takes more friction than the shock: it
slides first just before the next well. Between them arcs and shocks are integrated
(:mod:`harness.theory.incline_coulomb`).

A DEM contact has this shock where its dashpots are much stronger than its springs and the
tangential dashpot is beta / (1 + beta) of the normal one, which keeps the ratio of both forces.
With equal dashpots under Coulomb's limit it transmits only beta / (1 + beta) mu of the normal
impulse, and sticks from mu = tan(phi) on.

Sources: Harper, Dufek and Breard (arXiv 2409.13633), section on the Quartier model, without
friction; Quartier, Andreotti, Douady and Daerr, Phys. Rev. E 62, 8299 (2000), with friction; sizes
are derived here.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.theory.chain import SHOCK_WITHOUT_REBOUND

Points = NDArray[np.float64]
Shape = Literal["sphere", "disc"]
INERTIA: dict[Shape, float] = {"sphere": 0.4, "disc": 0.5}  # beta [-]
EQUAL = STATIC_ANGLE_DEG = 30.0  # half angle of equal spheres; at rest a grain leaves at this tilt
LARGEST_HEIGHT = 10  # particles up to which the source scales the impulse by energy


# ---- the energy map: kinetic energies just after the shock in the well


def well_depth(angle_deg: float, half_angle_deg: float = EQUAL) -> float:
    """Return C = 1 - cos(phi - theta): the energy that it takes to reach the next crest."""
    return 1.0 - math.cos(math.radians(half_angle_deg - angle_deg))


def gain_per_crest(angle_deg: float, half_angle_deg: float = EQUAL) -> float:
    """Return dE = 2 sin(phi) sin(theta): the work of gravity from one crest to the next."""
    return 2.0 * math.sin(math.radians(half_angle_deg)) * math.sin(math.radians(angle_deg))


def after_next_shock(
    energy: float, angle_deg: float, shock: float, half_angle_deg: float = EQUAL
) -> float:
    """Return E[j+1] = shock (E[j] + dE)."""
    return shock * (energy + gain_per_crest(angle_deg, half_angle_deg))


def energies(start: float, shocks: int, angle_deg: float, shock: float) -> Points:
    """Return E after each of ``shocks`` shocks in closed form, shape (shocks,).

    E[j] = E* + shock^j (E[0] - E*), whether or not each E[j] still reaches the crest. At shock = 1
    it grows without bound, by dE each time.
    """
    count = np.arange(1, shocks + 1)
    if shock == 1.0:
        return np.asarray(start + count * gain_per_crest(angle_deg))
    rest = steady_energy(angle_deg, shock)
    return np.asarray(rest + shock**count * (start - rest))


def steady_energy(angle_deg: float, shock: float) -> float:
    """Return the fixed point E* = dE shock / (1 - shock); infinite from shock = 1 on."""
    return gain_per_crest(angle_deg) * shock / (1.0 - shock) if shock < 1.0 else math.inf


def passage_margin(angle_deg: float, shock: float, half_angle_deg: float = EQUAL) -> float:
    """Return the energy over the next crest of a grain that came over the last one at rest.

    shock (C + dE) - C: its root is the critical angle, because the energy map is increasing and has
    its fixed point at the crest there.
    """
    depth = well_depth(angle_deg, half_angle_deg)
    return after_next_shock(depth, angle_deg, shock, half_angle_deg) - depth


# ---- sizes, friction and the critical angle


def well_half_angle(size_ratio: float) -> float:
    """Return phi = asin(1 / (1 + R/r)) [deg] of a grain R/r times as large as the row's spheres."""
    if not 0.0 < size_ratio < math.inf:
        raise RequestError(f"size ratio = {size_ratio!r} is not allowed: must be greater than 0")
    return math.degrees(math.asin(1.0 / (1.0 + size_ratio)))


def size_ratio(half_angle_deg: float) -> float:
    """Return R/r of a half angle of the well [deg]."""
    return 1.0 / math.sin(math.radians(half_angle_deg)) - 1.0


def kept_speed(half_angle_deg: float, inertia: float) -> float:
    """Return s = (cos(2 phi) + beta) / (1 + beta) [-] of a grain that rolls, or has no friction.

    Without friction the inertia is 0. It is 0 where the grain would be thrown back.
    """
    turn = math.cos(2.0 * math.radians(half_angle_deg))
    return max(0.0, (turn + inertia) / (1.0 + inertia))


def critical_angle(shock: float = SHOCK_WITHOUT_REBOUND, half_angle_deg: float = EQUAL) -> float:
    """Return theta_c [deg], the smallest tilt at which motion persists.

    tan(theta / 2) = tan(phi / 2) (1 - sqrt(shock)) / (1 + sqrt(shock)), the root of
    :func:`passage_margin`: phi at shock 0 and 0 at shock 1. Raise RequestError unless
    0 <= shock <= 1.
    """
    if not 0.0 <= shock <= 1.0:
        raise RequestError(f"shock = {shock!r} is not allowed: must be from 0 to 1")
    s = math.sqrt(shock)
    tangent = math.tan(math.radians(half_angle_deg) / 2.0) * (1.0 - s) / (1.0 + s)
    return math.degrees(2.0 * math.atan(tangent))


def critical_angle_without_loss(half_angle_deg: float, inertia: float) -> float:
    """Return theta_c [deg] of a grain that rolls all along, or has no friction (inertia 0)."""
    return critical_angle(kept_speed(half_angle_deg, inertia) ** 2, half_angle_deg)


def no_flight_bound(
    shock: float = SHOCK_WITHOUT_REBOUND, half_angle_deg: float = EQUAL, inertia: float = 0.0
) -> float:
    """Return the tilt [deg] above which the grain in steady motion leaves the row.

    Contact is weakest just before the shock: there v^2 = 4 sin(phi) sin(theta) /
    ((1 - shock) (1 + beta)) reaches cos(phi + theta). 15.30 deg for equal spheres at shock = 1/4.
    Raise RequestError unless 0 <= shock < 1.
    """
    if not 0.0 <= shock < 1.0:
        raise RequestError(f"shock = {shock!r} is not allowed: must be from 0 to below 1")
    speeding = 4.0 / ((1.0 - shock) * (1.0 + inertia))
    slope = math.tan(math.radians(half_angle_deg)) * (1.0 + speeding)
    return math.degrees(math.atan(1.0 / slope))


def sticking_friction(half_angle_deg: float, inertia: float) -> float:
    """Return mu_s = beta / (1 + beta) tan(phi) [-], from which the shock of a rolling grain sticks.

    Tangential over normal impulse. 0.16496 for equal spheres, 0.19245 for discs.
    """
    return inertia / (1.0 + inertia) * math.tan(math.radians(half_angle_deg))


def rolling_friction(half_angle_deg: float, inertia: float) -> float:
    """Return mu_r [-], from which a grain rolls all along at its critical angle.

    Friction over normal force at the end of an arc, psi = phi + theta_c, after a start from rest
    on the crest: beta sin(psi) / ((3 + beta) cos(psi) - 2). 0.32848 for equal spheres, 0.35666
    for discs. Infinite where the rolling grain leaves the row.
    """
    angle = critical_angle_without_loss(half_angle_deg, inertia)
    psi = math.radians(half_angle_deg + angle)
    normal = (3.0 + inertia) * math.cos(psi) - 2.0
    along_arc = inertia * math.sin(psi) / normal if normal > 0.0 else math.inf
    return max(along_arc, sticking_friction(half_angle_deg, inertia))


def flight_angle(inertia: float) -> float:
    """Return the angle from the vertical [deg] at which a grain leaves a sphere.

    It starts from rest on the crest and rolls, or slides without friction (inertia 0):
    cos(psi) = 2 / (3 + beta).
    """
    return math.degrees(math.acos(2.0 / (3.0 + inertia)))


# ---- the energy argument of the source's discussion


def impulse_ratio(height: int) -> float:
    """Return alpha = 1/sqrt(n) of a tower of ``height`` n.

    Under one force F, n equal springs in series store n times the energy of one, U = F^2 n / (2 k),
    and so take up a velocity sqrt(2 U / m) that grows as sqrt(n). The velocity that the grain loses
    to a row of n is taken to fall as its inverse, up to ``LARGEST_HEIGHT``, beyond which the source
    sees no longer contacts. Raise RequestError for a height below 1.
    """
    if height < 1:
        raise RequestError(f"height = {height!r} is not allowed: must be at least 1")
    return 1.0 / math.sqrt(height)
