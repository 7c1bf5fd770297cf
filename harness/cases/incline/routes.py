"""The two routes of the incline: where a grain starts, where it ends, by what energy it is judged.

What the LAMMPS script says in its own language, for the engines that are driven from
Python. Nothing here is a force: it is how a motion is measured.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.parameters import Incline
from harness.cases.incline.springs import spring_of
from harness.errors import RequestError
from harness.parameters.contact import Spring as SpringLaw

Number = TypeVar("Number", float, NDArray[np.float64])

STEADY_SPEED = 0.48
"""[sqrt(g d)] first speed of the steady route."""

BEHIND_CREST = math.radians(10.0)
"""Where the passage route starts, behind the crest, and the latest place before one to end."""

SETTLED = 8.0
"""Times of the contact's slowest rate, at 0.35 sqrt(g d), for it to settle after a shock."""

SPEED_AFTER_SHOCK = 0.35
NORMAL_SPEED = SPEED_AFTER_SHOCK * math.tan(math.pi / 3.0)
"""[sqrt(g d)] into the sphere ahead, at the shock that leaves SPEED_AFTER_SHOCK along it."""


@dataclass(frozen=True)
class Start:
    """Position [m] and velocity [m/s] of the grain; x from the centre of a fixed sphere."""

    x_m: float
    y_m: float
    vx_m_per_s: float
    vy_m_per_s: float

    def state(self) -> tuple[float, float, float, float]:
        """Return (x, y, vx, vy); raise RequestError when one is not finite."""
        values = tuple(float(value) for value in astuple(self))
        if not all(math.isfinite(value) for value in values):
            raise RequestError(f"start = {values}: must be finite numbers, in m and m/s")
        x, y, vx, vy = values
        return x, y, vx, vy


def start_of(case: Incline, route: str, law: SpringLaw = "linear") -> Start:
    """Return the start of a route, ``passage`` or ``steady``."""
    return start_behind_crest(case, law) if route == "passage" else start_in_well(case)


def start_in_well(case: Incline, speed: float | None = None) -> Start:
    """Return a start touching both spheres of a well, along the tangent of the one ahead.

    ``speed`` [m/s] is 0.48 sqrt(g d) unless given.
    """
    if speed is None:
        speed = STEADY_SPEED * math.sqrt(case.gravity * case.diameter)
    return Start(
        0.5 * case.diameter, math.sqrt(0.75) * case.diameter, speed * math.sqrt(0.75), 0.5 * speed
    )


def start_behind_crest(case: Incline, law: SpringLaw = "linear") -> Start:
    """Return the start of the passage route: just the energy of the crest, in balance.

    The overlap at an angle phi from the crest bears m g (3 cos phi - 2), the weight
    less the centrifugal force; the rate of phi follows from
    the energy. The case's phase shifts phi by a fraction of a step's way.
    """
    weight, d, spring = case.mass * case.gravity, case.diameter, spring_of(case, law)
    rate = math.sqrt(2.0 * case.gravity * (1.0 - math.cos(BEHIND_CREST)) / d)
    phi = BEHIND_CREST + case.phase * rate * case.step
    force = weight * (3.0 * math.cos(phi) - 2.0)
    overlap = spring.overlap(force)
    slope = spring.change(force, 3.0 * weight * math.sin(phi))
    r = d - overlap
    kinetic = crest_energy(case, law) - weight * r * math.cos(phi) - spring.energy(overlap)
    omega = math.sqrt(2.0 * kinetic / case.mass / (r * r + slope * slope))
    beta = phi - math.radians(case.angle)
    return Start(
        r * math.sin(beta),
        r * math.cos(beta),
        omega * (r * math.cos(beta) + slope * math.sin(beta)),
        omega * (slope * math.cos(beta) - r * math.sin(beta)),
    )


def crest_energy(case: Incline, law: SpringLaw = "linear") -> float:
    """Return the energy [J] of a grain at rest on the first sphere's crest, pressed in."""
    weight = case.mass * case.gravity
    return weight * _crest_radius(case, law) + spring_of(case, law).energy_under(weight)


def overlaps(case: Incline, x: Number, y: Number) -> tuple[Number, Number]:
    """Return the overlaps [m] with the spheres behind and ahead; negative is a gap."""
    d = case.diameter
    behind = d * np.floor(x / d)
    return d - np.hypot(x - behind, y), d - np.hypot(x - behind - d, y)


def energy(
    case: Incline, x: Number, y: Number, vx: Number, vy: Number, law: SpringLaw = "linear"
) -> Number:
    """Return the mechanical energy [J]: motion, height over the first sphere, springs."""
    tilt = math.radians(case.angle)
    height = y * math.cos(tilt) - x * math.sin(tilt)
    pressed = [np.maximum(overlap, 0.0) for overlap in overlaps(case, x, y)]
    springs = spring_of(case, law).energy(*pressed)
    motion = 0.5 * case.mass * (vx * vx + vy * vy)
    total: Number = motion + case.mass * case.gravity * height + springs
    return total


def margin(
    case: Incline,
    well: int,
    x: Number,
    y: Number,
    vx: Number,
    vy: Number,
    law: SpringLaw = "linear",
) -> Number:
    """Return the energy [J] above that of a grain at rest on the crest after ``well`` wells."""
    return energy(case, x, y, vx, vy, law) - crest_energy(case, law) + margin_offset(case, well)


def margin_offset(case: Incline, well: int) -> float:
    """Return the energy [J] by which the crest after ``well`` wells lies below the first one."""
    return case.mass * case.gravity * well * case.diameter * math.sin(math.radians(case.angle))


def end_of(case: Incline, route: str, well: int, law: SpringLaw = "linear") -> float:
    """Return the x [m] whose passage ends a well: a crest, or where a passage has settled."""
    return settled_place(case, law) if route == "passage" else crest_place(case, well, law)


def crest_place(case: Incline, well: int, law: SpringLaw = "linear") -> float:
    """Return the x [m] of the crest after ``well`` wells."""
    tilt = math.radians(case.angle)
    return well * case.diameter - _crest_radius(case, law) * math.sin(tilt)


def settled_place(case: Incline, law: SpringLaw = "linear") -> float:
    """Return the x [m] past the first well where the contact has settled: the passage's end.

    The energy left over the crest is the same there as on it, and the slow way
    to the crest need not be walked.
    """
    tilt = math.radians(case.angle)
    return case.diameter - _crest_radius(case, law) * math.sin(tilt + settled_before(case, law))


def settled_before(case: Incline, law: SpringLaw = "linear") -> float:
    """Return how far before the crest [rad] the contact has settled after a shock.

    The slowest rate is that of
    x'' + 2 zeta omega x' + omega^2 x, of small motions under the weight. A grain that
    rebounds hops on first: it turns by 60 deg at NORMAL_SPEED, and its hops add up
    to 2 e / (1 - e) NORMAL_SPEED / g of time, g being less by no more than cos 30 deg.
    """
    d = case.diameter
    spring = spring_of(case, law)
    omega, zeta = spring.small_motion(case.mass * case.gravity)
    slowest = zeta + math.sqrt(zeta * zeta - 1.0) if zeta >= 1.0 else 1.0 / (zeta + 1e-9)
    swept = SETTLED * slowest / omega * SPEED_AFTER_SHOCK * math.sqrt(case.gravity / d)
    rebound = spring.most_rebound()
    if rebound > 0.0:
        hops = 2.0 * rebound / (1.0 - min(rebound, 0.99)) * NORMAL_SPEED / math.cos(math.pi / 6.0)
        swept += hops * SPEED_AFTER_SHOCK
    return min(max(math.pi / 6.0 - math.radians(case.angle) - swept, 0.0), BEHIND_CREST)


def _crest_radius(case: Incline, law: SpringLaw) -> float:
    """Return the distance [m] of the grain from the sphere on whose crest it rests."""
    if law == "linear":  # as the LAMMPS script has it, to the last digit
        return case.diameter * (1.0 - case.static_overlap)
    return case.diameter - spring_of(case, law).overlap(case.mass * case.gravity)
