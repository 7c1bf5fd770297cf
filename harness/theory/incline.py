"""Rigid grain on a row of spheres: energy from shock to shock, critical angle, with friction too.

A grain of radius R, inertia beta m R^2, moves over a row of fixed touching spheres of radius r. Its
centre is on arcs of radius a = R + r. Lengths are in a, speeds in sqrt(g a), energies in m g a,
angles in degrees. Unless a half angle of the well is given the grain is as large as the spheres:
then a is a diameter.

Well. The grain touches two spheres, phi = asin(r / (R + r)) on either side of the row's normal. On
a row tilted by theta an arc goes from the angle theta - phi from the vertical to theta + phi.

Shock in the well, without rebound. The direction of motion turns by 2 phi, c = cos(2 phi), and the
sphere ahead exerts the only impulses: normal, m v sin(2 phi), and tangential, P. Both drive the
grain off the sphere behind. With v the speed of the centre and w that of the rim, v' = c v + P / m
and w' = w - P / (beta m). Without friction P = 0. Without slip after the shock v' = w', which is
angular momentum about the new contact: (1 + beta) v' = c v + beta w. A grain that rolled (w = v)
keeps the share s = (c + beta) / (1 + beta) of its speed; that takes a friction of at least
P / (m v sin(2 phi)) = beta / (1 + beta) tan(phi). The *shock* is s^2, energy after over before.

Critical angle. With share s at each shock and no loss on the arcs, a grain that leaves a crest from
rest just reaches the next one if s^2 (1 - cos(phi + theta)) = 1 - cos(phi - theta). That is
without friction, and where the grain rolls all along, which takes more friction than the shock: it
slides first just before the next well. Between them arcs and shocks are integrated, see below.

A DEM contact has this shock where its dashpots are much stronger than its springs and the
tangential dashpot is beta / (1 + beta) of the normal one, which keeps the ratio of both forces.
With equal dashpots it transmits beta / (1 + beta) mu of the normal impulse, and sticks from
mu = tan(phi) on.

Sources: Harper, Dufek and Breard (arXiv 2409.13633), section on the Quartier model, without
friction; Quartier, Andreotti, Douady and Daerr, Phys. Rev. E 62, 8299 (2000), with friction; sizes
are derived here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from harness.errors import RequestError
from harness.theory.chain import SHOCK_WITHOUT_REBOUND

Points = NDArray[np.float64]
Shape = Literal["sphere", "disc"]
INERTIA: dict[Shape, float] = {"sphere": 0.4, "disc": 0.5}  # beta [-]
EQUAL = STATIC_ANGLE_DEG = 30.0  # half angle of equal spheres; at rest a grain leaves at this tilt
FRICTIONLESS = "closed form, no friction"
ROLLING = "closed form, rolls without slip"
INTEGRATED = "integrated: rigid grain, Coulomb friction in shock and on arcs"


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
    return math.degrees(math.asin(1.0 / (1.0 + size_ratio)))


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


def friction_to_roll(arc_end: float, inertia: float) -> float:
    """Return the friction [-] with which a grain from rest on a crest rolls up to an angle [rad].

    Friction over normal force is largest at the end of the arc, beta sin(psi) / ((3 + beta)
    cos(psi) - 2). Infinite where the rolling grain leaves the row.
    """
    normal = (3.0 + inertia) * math.cos(arc_end) - 2.0
    return inertia * math.sin(arc_end) / normal if normal > 0.0 else math.inf


def rolling_friction(half_angle_deg: float, inertia: float) -> float:
    """Return mu_r [-], from which a grain rolls all along at its critical angle.

    0.32848 for equal spheres, 0.35666 for discs.
    """
    angle = critical_angle_without_loss(half_angle_deg, inertia)
    on_arc = friction_to_roll(math.radians(half_angle_deg + angle), inertia)
    return max(on_arc, sticking_friction(half_angle_deg, inertia))


# ---- with friction: rolling and sliding on arcs, plastic shocks
#
# An arc is v dv/dpsi = sin(psi) - f and beta v dw/dpsi = f, with the friction f against slip, the
# normal force N = cos(psi) - v^2 and the angle psi from the vertical, positive behind the crest.
# The grain rolls as long as beta / (1 + beta) |sin(psi)| <= mu N; otherwise it slides with
# |f| = mu N. The critical angle is the tilt at which a grain that leaves a crest from rest just
# reaches the next one.
#
# Slight friction leaves the grain almost without spin, retards it, and raises the critical angle:
# of equal spheres to 10.687 deg at mu = 0.016. There (mu < 0.022) steady motion carries spin over
# the crest, which a start from rest lacks, and persists down to at most 0.018 deg below that angle.

ANGLE_TOLERANCE = 1e-12  # [rad]
MOST_ROUNDS = 60  # of three wells each, until motion is steady
LARGEST_FRICTION = 100.0  # nothing slides beyond, but for the last 1e-3 deg before flight
LEAST_FRICTION = 1e-15  # moves the angle by 1e-13 deg; slip of less is lost in round-off
TINY_SPEED = 1e-8  # [sqrt(g a)] of turning points, where the quadrature of w divides by v

# double exponential quadrature on -1 to 1, for integrands that are steep or singular at the ends
_TIMES = np.linspace(-3.2, 3.2, 161)
NODES = np.tanh(np.pi / 2.0 * np.sinh(_TIMES))
WEIGHTS = 0.04 * np.pi / 2.0 * np.cosh(_TIMES) / np.cosh(np.pi / 2.0 * np.sinh(_TIMES)) ** 2


class LeavesRow(RequestError):
    """A grain that is too small to stay on the row at its critical angle."""


class Grain(NamedTuple):
    """Friction mu and inertia factor beta."""

    friction: float
    inertia: float

    @classmethod
    def of(cls, friction: float, shape: Shape) -> Grain:
        """Return a grain of a shape, with a friction in the range that makes a difference."""
        friction = min(friction, LARGEST_FRICTION) if friction >= LEAST_FRICTION else 0.0
        return cls(friction, INERTIA[shape])


class State(NamedTuple):
    """A grain on a sphere: angle from the vertical [rad], speeds of centre and rim [sqrt(g a)]."""

    angle: float
    speed: float
    rim: float

    @property
    def normal_force(self) -> float:
        """Return N [m g]."""
        return math.cos(self.angle) - self.speed**2


CREST = State(0.0, 0.0, 0.0)  # at rest


class RigidAngle(NamedTuple):
    """A critical angle [deg], its model; share of the energy after a shock, that energy [m g a]."""

    degrees: float
    model: str
    shock: float
    energy: float


def rigid_angle(half_angle_deg: float, grain: Grain) -> RigidAngle:
    """Return the critical angle of rigid grains without rebound.

    Raise LeavesRow for a grain that leaves the row at a smaller tilt.
    """
    if 0.0 < grain.friction < rolling_friction(half_angle_deg, grain.inertia):
        angle, phi = integrated_critical_angle(half_angle_deg, grain), math.radians(half_angle_deg)
        before = over_arc(CREST, phi + math.radians(angle), grain)
        speeds = (before.speed, before.rim), after_shock(before, grain, phi)
        first, second = ((v * v + grain.inertia * w * w) / 2.0 for v, w in speeds)
        return RigidAngle(angle, INTEGRATED, second / first, second)
    if grain.friction == 0.0 and half_angle_deg > largest_half_angle(grain):
        raise LeavesRow("the grain leaves the row below its critical angle")
    model, inertia = (ROLLING, grain.inertia) if grain.friction else (FRICTIONLESS, 0.0)
    shock = kept_speed(half_angle_deg, inertia) ** 2
    angle = critical_angle(shock, half_angle_deg)
    return RigidAngle(angle, model, shock, well_depth(angle, half_angle_deg))


def integrated_critical_angle(half_angle_deg: float, grain: Grain) -> float:
    """Return theta_c [deg], the root of the margin over one well; errors as of rigid_angle."""
    phi = math.radians(half_angle_deg)
    steepest = min(phi, _takeoff(grain) - phi)
    if steepest <= 0.0 or _margin(steepest, grain, phi) < 0.0:
        raise LeavesRow("the grain leaves the row below its critical angle")
    return math.degrees(_root(lambda angle: _margin(angle, grain, phi), 0.0, steepest))


@cache
def largest_half_angle(grain: Grain) -> float:
    """Return the half angle [deg] of the smallest grain that stays on the row at theta_c."""
    end = _takeoff(grain)
    return math.degrees(_root(lambda phi: _margin(end - phi, grain, phi), end / 2.0, end))


def smallest_size_ratio(grain: Grain) -> float:
    """Return the least size R/r of a grain that stays on the row at its critical angle."""
    return 1.0 / math.sin(math.radians(largest_half_angle(grain))) - 1.0


def integrated_no_flight_bound(half_angle_deg: float, grain: Grain) -> float | None:
    """Return the tilt [deg] above which a grain leaves the row on its way to steady motion.

    It starts from rest on a crest. None where its motion is not found steady within 180 wells, as
    with slight friction, which sets it spinning slowly, and of grains as large as ten spheres.
    """
    phi = math.radians(half_angle_deg)
    low, high = math.radians(integrated_critical_angle(half_angle_deg, grain)), phi
    while high - low > 1e-8:
        middle = (low + high) / 2.0
        if (stays := _stays(middle, grain, phi)) is None:
            return None
        low, high = (middle, high) if stays else (low, middle)
    return math.degrees(low)


def _margin(angle: float, grain: Grain, half_angle: float) -> float:
    """Return the energy on the crest after a start from rest on the last one, or minus what lacks.

    Angles in rad. Raise LeavesRow for flight.
    """
    end = over_arc(_after_well(CREST, angle, grain, half_angle), 0.0, grain)
    if end.angle < 0.0:
        return -2.0 * math.sin(end.angle / 2.0) ** 2
    return (1.0 + grain.inertia) / 2.0 * end.speed**2


def _takeoff(grain: Grain) -> float:
    """Return the angle [rad] at which a grain from rest on the crest flies off.

    At the latest, rolling all along, at cos(psi) = 2 / (3 + beta); a sliding grain is faster.
    """
    latest = math.acos(2.0 / (3.0 + grain.inertia))
    sliding = _Sliding(_roll(CREST, latest, grain), grain)
    return _root(sliding.normal_force, sliding.start.angle, latest) - 10.0 * ANGLE_TOLERANCE


def _stays(angle: float, grain: Grain, half_angle: float) -> bool | None:
    """Return whether a grain that starts from rest stays on the row until its motion is steady.

    None where it is not steady after MOST_ROUNDS. States after shocks are extrapolated: their v^2
    are a geometric series (Aitken).
    """
    state = CREST
    try:
        for _ in range(MOST_ROUNDS):
            first = _after_well(state, angle, grain, half_angle)
            second = _after_well(first, angle, grain, half_angle)
            state = _after_well(second, angle, grain, half_angle)
            gains = second.speed**2 - first.speed**2, state.speed**2 - second.speed**2
            if 0.0 < gains[1] < gains[0]:
                speed = math.sqrt(state.speed**2 + gains[1] ** 2 / (gains[0] - gains[1]))
                rolls = state.rim == state.speed
                state = State(state.angle, speed, speed if rolls else state.rim)
            if abs(state.speed - first.speed) + abs(state.rim - first.rim) < 1e-9:
                return True
    except LeavesRow:
        return False
    return None


def _after_well(state: State, angle: float, grain: Grain, half_angle: float) -> State:
    """Return the state behind the shock after an arc; tilt and half angle of the well [rad]."""
    before = over_arc(state, half_angle + angle, grain)
    return State(angle - half_angle, *after_shock(before, grain, half_angle))


def after_shock(state: State, grain: Grain, half_angle: float) -> tuple[float, float]:
    """Return speeds of centre and rim after the plastic shock of a half angle [rad].

    The tangential impulse is the one that ends slip, at most mu times the normal one; slip never
    changes its sign, because neither impulse turns the other.
    """
    forward, normal = (state.speed * f(2.0 * half_angle) for f in (math.cos, math.sin))
    ending_slip = (state.rim - forward) * grain.inertia / (1.0 + grain.inertia)
    limit = grain.friction * normal
    tangential = max(-limit, min(limit, ending_slip))
    speed = forward + tangential
    return speed, speed if tangential == ending_slip else state.rim - tangential / grain.inertia


def over_arc(start: State, end: float, grain: Grain) -> State:
    """Return the state at the angle ``end`` [rad], or where the grain turns back before.

    Raise LeavesRow where the normal force vanishes.
    """
    state, rolls = start, start.speed == start.rim
    while True:
        state = (_roll if rolls else _slide)(state, end, grain)
        if state.angle >= end or (state.speed <= 0.0 and state.angle < 0.0):
            return state
        rolls = not rolls


def _roll(state: State, end: float, grain: Grain) -> State:
    """Return the state where rolling ends: at ``end``, in a turning point, at Coulomb's limit."""
    beta, mu = grain.inertia, grain.friction
    share = beta / (1.0 + beta)
    if share * abs(math.sin(state.angle)) > mu * state.normal_force:
        return state
    excess = (1.0 + beta) / 2.0 * state.speed**2 - 2.0 * math.sin(state.angle / 2.0) ** 2
    if state.angle < 0.0 and excess < 0.0:
        return State(-2.0 * math.asin(math.sqrt(-excess / 2.0)), 0.0, 0.0)

    def rolling(angle: float) -> State:
        speed = math.sqrt(2.0 * max(0.0, excess + 2.0 * math.sin(angle / 2) ** 2) / (1.0 + beta))
        return State(angle, speed, speed)

    def spare(angle: float) -> float:
        return mu * rolling(angle).normal_force - share * abs(math.sin(angle))

    first = min(end, max(0.0, state.angle))  # up to the crest less and less friction is needed
    if spare(end) >= 0.0:
        return rolling(end)
    return rolling(_root(spare, first, end)) if spare(first) > 0.0 else state


def _slide(start: State, end: float, grain: Grain) -> State:
    """Return the state where sliding ends: at ``end``, in a turning point, as slip ends."""
    sliding = _Sliding(start, grain)
    last = sliding.turning_point(end)
    angle = sliding.end_of_slip(last)
    state = sliding.state(last if angle is None else angle)
    if state.normal_force <= 0.0:
        raise LeavesRow("the grain leaves the row")
    if angle is None:
        return state if last == end else State(last, 0.0, state.rim)
    return State(angle, state.speed, state.speed)


class _Sliding:
    """The arc of a grain that slides from a state on: speeds by the angle psi [rad].

    d(v^2)/dpsi = 2 sin(psi) - 2 mu (cos(psi) - v^2) with mu of the sign of slip v - w is linear in
    v^2; dw/dpsi = mu N / (beta v) is a quadrature.
    """

    def __init__(self, start: State, grain: Grain) -> None:
        self.start, slip = start, start.speed - start.rim
        self.sign = math.copysign(1.0, slip or math.sin(start.angle))
        self.starts_rolling = slip == 0.0
        self.mu, self.inertia = self.sign * grain.friction, grain.inertia
        self._cosine = (4.0 * self.mu**2 - 2.0) / (1.0 + 4.0 * self.mu**2)
        self._sine = -6.0 * self.mu / (1.0 + 4.0 * self.mu**2)

    def squared(self, angle: Any) -> Any:
        """Return v^2 at an angle, or at an array of angles."""
        at: Any = np if isinstance(angle, np.ndarray) else math  # ten times as fast at one angle
        first = self.start.angle  # differences to it, as v^2 may be small against 1
        half, middle = at.sin((angle - first) / 2.0), (angle + first) / 2.0
        grown = at.expm1(2.0 * self.mu * (angle - first))
        return (
            self.start.speed**2 * (1.0 + grown)
            - self._cosine * (2.0 * at.sin(middle) * half + math.cos(first) * grown)
            + self._sine * (2.0 * at.cos(middle) * half - math.sin(first) * grown)
        )

    def normal_force(self, angle: float) -> float:
        return math.cos(angle) - float(self.squared(angle))

    def pull(self, angle: float) -> float:
        """Return the tangential acceleration of the centre, dv/dt."""
        return math.sin(angle) - self.mu * self.normal_force(angle)

    def slip_rate(self, angle: float) -> float:
        """Return the growth of the slip's size, d|v - w|/dt."""
        gain = self.pull(angle) - self.mu / self.inertia * self.normal_force(angle)
        return self.sign * gain

    def state(self, angle: float) -> State:
        half = (angle - self.start.angle) / 2.0
        angles = self.start.angle + half * (1.0 + NODES)
        squared = self.squared(angles)
        rate = (np.cos(angles) - squared) / np.sqrt(np.maximum(TINY_SPEED**2, squared))
        rim = self.start.rim + self.mu / self.inertia * half * float(WEIGHTS @ rate)
        return State(angle, math.sqrt(max(0.0, self.squared(angle))), rim)

    def slip(self, angle: float) -> float:
        """Return the size of the slip, negative beyond its end."""
        state = self.state(angle)
        return self.sign * (state.speed - state.rim)

    def turning_point(self, end: float) -> float:
        """Return where the grain stops, ``end`` if it does not."""
        slowest, first = end, self.start.angle
        if self.pull(first) < 0.0 < self.pull(end):
            slowest = _root(self.pull, first, end)
        return end if self.squared(slowest) > 0.0 else _root(self.squared, first, slowest)

    def end_of_slip(self, last: float) -> float | None:
        """Return where slip ends up to ``last``, None if it does not.

        Its rate changes the sign at most once: up on the way down (slip forward), down on the way
        up (slip backward).
        """
        first, latest = self.start.angle, last
        at_first, at_last = self.slip_rate(first), self.slip_rate(last)
        growing = self.starts_rolling or at_first >= 0.0
        if growing and at_last >= 0.0:
            return None
        if growing and at_first > 0.0:
            first = _root(self.slip_rate, first, last)
        if not growing and at_last > 0.0:
            latest = _root(self.slip_rate, first, last)
        return _root(self.slip, first, latest) if self.slip(latest) <= 0.0 else None


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    return float(brentq(function, low, high, xtol=1e-18, rtol=1e-14))
