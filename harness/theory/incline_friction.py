"""Critical angle of an incline with friction, for a grain of another size than the row's spheres.

A rigid grain of radius R, inertia beta m R^2, moves over a row of fixed touching spheres of radius
r. Its centre is on arcs of radius a = R + r. Lengths are in a, speeds in sqrt(g a), energies in
m g a; v is the speed of the centre, w that of the rim (R times the angular velocity), psi the
angle from the vertical through a sphere's centre, positive behind the crest.

Well. The grain touches two spheres, phi = asin(r / (R + r)) on either side of the row's normal.
On a row tilted by theta an arc begins at psi = theta - phi and ends at psi = theta + phi.

Shock in the well, without rebound. The direction of motion turns by 2 phi, c = cos(2 phi), and the
sphere ahead exerts the only impulses: normal, m v sin(2 phi), and tangential, P. Both drive the
grain off the sphere behind as long as it moves on at all. So v' = c v + P / m and
w' = w - P / (beta m). Without friction P = 0. Without slip after the shock v' = w', which is
angular momentum about the new contact: (1 + beta) v' = c v + beta w. A grain that rolled (w = v)
keeps the share s = (c + beta) / (1 + beta) of its speed. That takes P = m v beta (1 - c) /
(1 + beta), hence a friction of at least P / (m v sin(2 phi)) = beta / (1 + beta) tan(phi).

Arc. v dv/dpsi = sin(psi) - f and beta v dw/dpsi = f, with the friction f against slip and the
normal force N = cos(psi) - v^2. A rolling grain has the kinetic energy (1 + beta) / 2 v^2, and
rolls as long as beta / (1 + beta) |sin(psi)| <= mu N. Otherwise it slides with |f| = mu N.

Critical angle. With share s at each shock and no loss on the arcs, a grain that leaves a crest
from rest just reaches the next one if s^2 (1 - cos(phi + theta)) = 1 - cos(phi - theta), hence
tan(theta / 2) = tan(phi / 2) (1 - s) / (1 + s). This closed form holds without friction and where
the grain rolls all along, which takes more friction than the shock: it slides first just before
the next well (:func:`rolling_friction`). Between them the arcs and shocks above are integrated
(:mod:`harness.theory.incline_coulomb`).

A DEM contact has this shock where its dashpots are much stronger than its springs and the
tangential dashpot is beta / (1 + beta) of the normal one, which keeps the ratio of both forces.
With equal dashpots under Coulomb's limit it transmits only beta / (1 + beta) mu of the normal
impulse, and sticks from mu = tan(phi) on.

Sources: Harper, Dufek and Breard (arXiv 2409.13633), without friction; Quartier, Andreotti, Douady
and Daerr, Phys. Rev. E 62, 8299 (2000), the grain with friction. Derived here.
"""

from __future__ import annotations

import math
from typing import Literal

from harness.errors import RequestError

Shape = Literal["sphere", "disc"]
INERTIA: dict[Shape, float] = {"sphere": 0.4, "disc": 0.5}  # beta [-]


# ---- closed forms; without friction the inertia factor beta is 0


def well_half_angle(size_ratio: float) -> float:
    """Return phi = asin(1 / (1 + R/r)) [deg] of a grain R/r times as large as the row's spheres.

    Raise RequestError unless the ratio is positive and finite.
    """
    if not 0.0 < size_ratio < math.inf:
        raise RequestError(f"size ratio = {size_ratio!r} is not allowed: must be greater than 0")
    return math.degrees(math.asin(1.0 / (1.0 + size_ratio)))


def size_ratio(half_angle_deg: float) -> float:
    """Return R/r of a half angle of the well [deg]."""
    return 1.0 / math.sin(math.radians(half_angle_deg)) - 1.0


def kept_speed(half_angle_deg: float, inertia: float) -> float:
    """Return s = (cos(2 phi) + beta) / (1 + beta) [-], speed after over speed before a shock.

    0 where the grain would be thrown back: it stays in the well.
    """
    turn = math.cos(2.0 * math.radians(half_angle_deg))
    return max(0.0, (turn + inertia) / (1.0 + inertia))


def critical_angle(half_angle_deg: float, inertia: float) -> float:
    """Return theta_c [deg] of a grain that rolls all along, or without friction (inertia 0)."""
    s = kept_speed(half_angle_deg, inertia)
    tangent = math.tan(math.radians(half_angle_deg) / 2.0) * (1.0 - s) / (1.0 + s)
    return math.degrees(2.0 * math.atan(tangent))


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
    psi = math.radians(half_angle_deg + critical_angle(half_angle_deg, inertia))
    normal = (3.0 + inertia) * math.cos(psi) - 2.0
    along_arc = inertia * math.sin(psi) / normal if normal > 0.0 else math.inf
    return max(along_arc, sticking_friction(half_angle_deg, inertia))


def flight_angle(inertia: float) -> float:
    """Return the angle from the vertical [deg] at which a grain leaves a sphere.

    It starts from rest on the crest and rolls, or slides without friction (inertia 0):
    cos(psi) = 2 / (3 + beta).
    """
    return math.degrees(math.acos(2.0 / (3.0 + inertia)))


def no_flight_bound(half_angle_deg: float, inertia: float) -> float:
    """Return the tilt [deg] above which a grain in steady motion leaves the row.

    It rolls all along, or has no friction (inertia 0). Just before the shock
    v^2 = 4 sin(phi) sin(theta) / ((1 - s^2) (1 + beta)) reaches cos(phi + theta).
    """
    phi, s = math.radians(half_angle_deg), kept_speed(half_angle_deg, inertia)
    speeding = 4.0 / ((1.0 - s * s) * (1.0 + inertia))
    return math.degrees(math.atan(1.0 / (math.tan(phi) * (1.0 + speeding))))
