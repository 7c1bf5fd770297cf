"""Rigid grain on a row of spheres with Coulomb friction: arcs, shocks, critical angle.

Equations, units and symbols are those of :mod:`harness.theory.incline`. An arc is
v dv/dpsi = sin(psi) - f and beta v dw/dpsi = f, with the friction f against slip, the normal force
N = cos(psi) - v^2 and the angle psi from the vertical, positive behind the crest. The grain rolls
as long as beta / (1 + beta) |sin(psi)| <= mu N; otherwise it slides with |f| = mu N. Shocks are
plastic. The critical angle is the tilt at which a grain that leaves a crest from rest just reaches
the next one.

Slight friction leaves the grain almost without spin, retards it, and raises the critical angle: of
equal spheres to 10.687 deg at mu = 0.016. There (mu < 0.022) steady motion carries spin over the
crest, which a start from rest lacks, and persists down to at most 0.018 deg below that angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from harness.errors import RequestError
from harness.theory import incline
from harness.theory.incline import INERTIA, Shape

ANGLE_TOLERANCE = 1e-12  # [rad]
MOST_ROUNDS = 60  # of three wells each, until motion is steady
LARGEST_FRICTION = 100.0  # nothing slides beyond, but for the last 1e-3 deg before flight
TINY_SPEED = 1e-8  # [sqrt(g a)] of turning points, where the quadrature of w divides by v
FRICTIONLESS = "closed form, no friction"
ROLLING = "closed form, rolls without slip"
INTEGRATED = "integrated: rigid grain, Coulomb friction in shock and on arcs"

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
        """Return a grain of a shape, with a friction up to the largest that makes a difference."""
        return cls(min(friction, LARGEST_FRICTION), INERTIA[shape])


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


# ---- critical angle and bounds


def angle_with_friction(friction: float, shape: Shape, half_angle_deg: float) -> tuple[float, str]:
    """Return the critical angle [deg] of rigid grains without rebound, and its model.

    Raise LeavesRow for a grain that leaves the row at a smaller tilt.
    """
    beta = INERTIA[shape]
    if friction == 0.0:
        if half_angle_deg > largest_half_angle(Grain(0.0, beta)):
            raise LeavesRow("the grain leaves the row below its critical angle")
        return incline.critical_angle_without_loss(half_angle_deg, 0.0), FRICTIONLESS
    if friction >= incline.rolling_friction(half_angle_deg, beta):
        return incline.critical_angle_without_loss(half_angle_deg, beta), ROLLING
    return integrated_critical_angle(half_angle_deg, Grain.of(friction, shape)), INTEGRATED


def integrated_critical_angle(half_angle_deg: float, grain: Grain) -> float:
    """Return theta_c [deg], the root of the margin over one well.

    Raise LeavesRow for a grain that leaves the row at a smaller tilt.
    """
    phi = math.radians(half_angle_deg)
    steepest = min(phi, _takeoff(grain) - phi)
    if steepest <= 0.0 or passage_margin(steepest, grain, phi) < 0.0:
        raise LeavesRow("the grain leaves the row below its critical angle")
    return math.degrees(_root(lambda angle: passage_margin(angle, grain, phi), 0.0, steepest))


def largest_half_angle(grain: Grain) -> float:
    """Return the half angle [deg] of the smallest grain that stays on the row at theta_c."""
    takeoff = _takeoff(grain)

    def margin(phi: float) -> float:
        if grain.friction == 0.0:
            half = math.degrees(phi)
            shock = incline.kept_speed(half, 0.0) ** 2
            return incline.passage_margin(math.degrees(takeoff) - half, shock, half)
        return passage_margin(takeoff - phi, grain, phi)

    return math.degrees(_root(margin, takeoff / 2.0, takeoff))


@cache
def smallest_size_ratio(grain: Grain) -> float:
    """Return the least size R/r of a grain that stays on the row at its critical angle."""
    return incline.size_ratio(largest_half_angle(grain))


def integrated_no_flight_bound(half_angle_deg: float, grain: Grain) -> float | None:
    """Return the tilt [deg] above which a grain leaves the row on its way to steady motion.

    It starts from rest on a crest. None where its motion is not found steady within 180 wells, as
    with slight friction, which sets it spinning slowly, and of grains as large as ten spheres.
    """
    phi = math.radians(half_angle_deg)
    low, high = math.radians(integrated_critical_angle(half_angle_deg, grain)), phi
    while high - low > 1e-8:
        middle = (low + high) / 2.0
        stays = _stays(middle, grain, phi)
        if stays is None:
            return None
        low, high = (middle, high) if stays else (low, middle)
    return math.degrees(low)


def kept_energy(angle_deg: float, half_angle_deg: float, grain: Grain) -> tuple[float, float]:
    """Return kinetic energies [m g a] before and after the shock of a start from rest."""
    angle, phi = math.radians(angle_deg), math.radians(half_angle_deg)
    before = over_arc(CREST, phi + angle, grain)
    speeds = (before.speed, before.rim), shock(before, grain, phi)
    first, second = ((v * v + grain.inertia * w * w) / 2.0 for v, w in speeds)
    return first, second


def passage_margin(angle: float, grain: Grain, half_angle: float) -> float:
    """Return the energy [m g a] on the crest of a grain that starts from rest on the last one.

    Where it does not reach the crest, the energy that it lacks, negative. Angles in rad. Raise
    LeavesRow for flight.
    """
    end = over_arc(after_well(CREST, angle, grain, half_angle), 0.0, grain)
    if end.angle < 0.0:
        return -2.0 * math.sin(end.angle / 2.0) ** 2
    return (1.0 + grain.inertia) / 2.0 * end.speed**2


def _takeoff(grain: Grain) -> float:
    """Return the angle [rad] at which a grain from rest on the crest flies off."""
    if grain.friction == 0.0:
        return math.radians(incline.flight_angle(0.0))
    latest = math.radians(incline.flight_angle(grain.inertia))  # rolling; sliding is faster
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
            first = after_well(state, angle, grain, half_angle)
            second = after_well(first, angle, grain, half_angle)
            state = after_well(second, angle, grain, half_angle)
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


# ---- one well: an arc, a shock


def after_well(state: State, angle: float, grain: Grain, half_angle: float) -> State:
    """Return the state behind the shock after an arc; tilt and half angle of the well [rad]."""
    before = over_arc(state, half_angle + angle, grain)
    return State(angle - half_angle, *shock(before, grain, half_angle))


def shock(state: State, grain: Grain, half_angle: float) -> tuple[float, float]:
    """Return speeds of centre and rim after the plastic shock of a half angle [rad].

    The tangential impulse is the one that ends slip, at most mu times the normal one; slip never
    changes its sign, because neither impulse turns the other.
    """
    forward, normal = (state.speed * f(2.0 * half_angle) for f in (math.cos, math.sin))
    ending_slip = (state.rim - forward) * grain.inertia / (1.0 + grain.inertia)
    limit = grain.friction * normal
    tangential = max(-limit, min(limit, ending_slip))
    if tangential == ending_slip:
        rolling = forward + tangential
        return rolling, rolling
    return forward + tangential, state.rim - tangential / grain.inertia


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
        first = self.start.angle  # differences to it, as v^2 may be small against 1
        half, middle = np.sin((angle - first) / 2.0), (angle + first) / 2.0
        grown = np.expm1(2.0 * self.mu * (angle - first))
        return (
            self.start.speed**2 * (1.0 + grown)
            - self._cosine * (2.0 * np.sin(middle) * half + np.cos(first) * grown)
            + self._sine * (2.0 * np.cos(middle) * half - np.sin(first) * grown)
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
