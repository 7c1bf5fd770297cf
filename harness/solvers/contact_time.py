"""The duration of the first contact of an impact, from which the step of a run is chosen.

The motion along the normal, m* x'' = -F(x, x') with the overlap x, is integrated by the classical
Runge-Kutta method with steps that are halved to find their error (Hairer, Norsett and Wanner,
Solving Ordinary Differential Equations I (1993), II.4). Two spheres that meet at an angle turn
about one another, which ends the contact earlier, by a share of some u^2 t / (4 r v): that is the
difference of two runs of the reference, in the limit of small steps. So is the duration of a
contact that yields, whose law has a memory of its own.

Forces are those of the reference; of mdr on rigid flats without the factor that a code has at
walls, and of a bulk that takes all that is displaced the limit of small steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from harness.compiled import shielded
from harness.errors import RequestError
from harness.model.base import ZERO
from harness.model.conventions import Faults, Rules
from harness.model.law import Law
from harness.model.scene import Scene, effective_mass, effective_radius
from harness.solvers import reference
from harness.solvers.contacts import System, find_press
from harness.solvers.friction import Touch
from harness.solvers.kernels import FIRST, FORCE, MOVES, Records, kernel

TOLERANCE = 1e-14  # relative, of a step of the integration
MOST_STRIDES = 1_000_000  # with those that are repeated: round-off may let none succeed
MOST_CORRECTIONS = 20  # by Newton's method, which takes some five
LONGEST = 64.0  # times the guess that a contact may take: a strong dashpot draws it out
FINE_STEPS = 5000  # of a contact, of the coarser of two runs of the reference
Phase = tuple[float, float, float]  # time [s], overlap [m] and its rate [m/s]
LIMIT = Rules(mdr_wall_force="plain", mdr_growth="whole", mdr_growth_steps=1.0)


@lru_cache(maxsize=4096)
def contact_time(scene: Scene) -> float:
    """Return how long the first contact of a scene lasts [s], whose bodies touch at the start.

    Raise RequestError for a contact that does not end.
    """
    return shielded(_contact_time, scene)


@lru_cache(maxsize=4096)
def yield_time(scene: Scene) -> float:
    """Return after which time of its first contact [s] a sphere of mdr yields; inf if never."""
    return shielded(_yield_time, scene)


def _contact_time(scene: Scene) -> float:
    impact = _impact(scene)
    if impact.yields:
        # a whole number of steps until it yields, which is noticed at one phase of them all
        unit = min(yield_time(scene), impact.elastic_time)
        coarse = unit / math.ceil(unit / impact.elastic_time * FINE_STEPS) * FINE_STEPS
        return _extrapolated(lambda steps: _stepped_time(scene, coarse / steps))
    lasts = _normal_time(_straight(scene))
    return lasts + _shift(scene, lasts, _stepped_time)


def _yield_time(scene: Scene) -> float:
    impact = _impact(scene)
    if not impact.yields:
        return math.inf
    overlap = _yield_depth(impact.law, impact.first) * (2.0 if impact.second else 1.0)
    elastic = scene.replace(law=scene.law.replace(yield_stress=None))
    until = _solve(_straight(elastic), overlap, closing=True)
    if math.isnan(until):
        return math.inf
    return until + _shift(
        elastic, until, lambda scene, step: _time_of_overlap(scene, step, overlap, 0.98 * until)
    )


def before(scene: Scene, lead: float) -> Scene:
    """Return a scene a time [s] before, when its first body flew freely."""
    bodies, g = [], np.array(scene.gravity)
    for body in scene.bodies:
        x, v = np.array(body.position), np.array(body.velocity)
        place, velocity = x - lead * v + 0.5 * lead * lead * g, v - lead * g
        moved = {"position": tuple(place.tolist()), "velocity": tuple(velocity.tolist())}
        bodies.append(body.model_copy(update=moved))
        g = np.zeros(3)  # the others do not fall
    return scene.model_copy(update={"bodies": tuple(bodies)})  # which was checked at touch


class _Impact(NamedTuple):
    """Law, m* [kg], R* [m], radii [m] (second 0 of a wall), speed [m/s] and gravity [m/s2]."""

    law: Law
    mass: float
    radius: float
    first: float
    second: float
    speed: float
    gravity: float

    @property
    def yields(self) -> bool:
        """Return whether a sphere may yield: a bulk that takes all that is displaced lets none."""
        return self.law.yield_stress is not None and not self.law.bulk_share

    @property
    def last_overlap(self) -> float:
        """Return the overlap [m] at which a contact parts: of jkr that of its largest tension."""
        law = self.law
        if law.normal != "jkr" or not law.surface_energy or law.moduli is None:
            return 0.0
        cube = 9.0 * math.pi * law.surface_energy * self.radius**2 / (4.0 * law.moduli[0])
        return float(-(cube ** (2.0 / 3.0)) / (3.0 * self.radius))

    @property
    def elastic_time(self) -> float:
        """Return the time of an elastic contact [s], about."""
        slope = self.law.stiffness(self.radius, 1.0)
        if self.law.normal == "hooke":
            return math.pi * math.sqrt(self.mass / slope)
        k = slope / 1.5
        return float(2.94 * (1.25 * self.mass * self.speed**2 / k) ** 0.4 / self.speed)


def _straight(scene: Scene) -> Scene:
    """Return the impact along the normal alone: equal ones are integrated once."""
    bodies = tuple(
        body.model_copy(update={"velocity": (0.0, 0.0, body.velocity[2]), "angular_velocity": ZERO})
        for body in scene.bodies
    )
    return scene.model_copy(update={"bodies": bodies, "law": _impact(scene).law, "laws": ()})


@lru_cache(maxsize=4096)
def _normal_law(law: Law) -> Law:
    parts = dict.fromkeys(("tangential", "rolling", "twisting"), "none")
    return law.one_material.replace(**parts, interface="current")


def _impact(scene: Scene) -> _Impact:
    first, second = scene.bodies[0], scene.bodies[1] if len(scene.bodies) > 1 else None
    falls = second is None or second.motion == "frozen"
    return _Impact(
        law=_normal_law(scene.law_of(first.type, (second or scene.walls[0]).type)),
        mass=effective_mass(first, second),
        radius=effective_radius(first, second),
        first=first.radius,
        second=second.radius if second else 0.0,
        speed=(second.velocity[2] if second else 0.0) - first.velocity[2],
        gravity=-scene.gravity[2] if falls else 0.0,
    )


def _shift(scene: Scene, unit: float, time_of: Callable[[Scene, float], float]) -> float:
    """Return by how much turning about one another changes a time of two spheres [s].

    ``time_of`` a scene and a step [s]; ``unit`` [s] is the length of :data:`FINE_STEPS`.
    """
    turns = any(any(body.velocity[:2]) or any(body.angular_velocity) for body in scene.bodies)
    if len(scene.bodies) == 1 or not turns:
        return 0.0
    straight = _straight(scene)
    return _extrapolated(
        lambda steps: time_of(scene, unit / steps) - time_of(straight, unit / steps)
    )


# ---- along the normal, by the forces of the reference


class _Approach(NamedTuple):
    """The motion along the normal, for compiled code: a contact, and what it was at the start.

    ``bulk`` [Pa] is the bulk modulus of spheres that have no other response, else 0.
    """

    system: System
    largest: float
    sides: Records
    mass: float
    radius: float
    other: float
    gravity: float
    least: float
    bulk: float


@lru_cache(maxsize=4096)
def _normal_time(straight: Scene) -> float:
    impact = _impact(straight)
    time = _solve(straight, impact.last_overlap, closing=False)
    if math.isnan(time):
        raise _endless(impact.law)
    return time


def _endless(law: Law) -> RequestError:
    names = ("damping_coefficient", "restitution", "surface_energy")
    values = {name: getattr(law, name) for name in names}
    text = ", ".join(f"{name} = {value!r}" for name, value in values.items() if value is not None)
    return RequestError(
        f"{text}: the contact does not end; less damping or attraction, or a faster impact, end it"
    )


def _solve(straight: Scene, end: float, *, closing: bool) -> float:
    """Return when the overlap first is ``end`` [m] on its way in or out [s], NaN for never."""
    impact, system = _impact(straight), reference.system_of(straight, LIMIT, Faults())
    nu, modulus = impact.law.poisson_ratio or 0.0, 2.0 * impact.law.effective_modulus
    approach = _Approach(
        system,
        largest=0.0,
        sides=system.sides[0].copy(),
        mass=impact.mass,
        radius=impact.radius,
        other=impact.second,
        gravity=impact.gravity,
        least=min(end, 0.0),
        bulk=modulus * (1.0 - nu * nu) / (3.0 - 6.0 * nu) if impact.law.bulk_share else 0.0,
    )
    start, scales = (0.0, 0.0, impact.speed), (impact.elastic_time, impact.speed)
    if closing:
        return _first(approach, start, (-1.0, 0.0), -end, *scales)[0]
    turn = _first(approach, start, (0.0, 1.0), 0.0, *scales)
    if not math.isnan(turn[0]):  # the contact remembers its largest overlap
        _acceleration(approach, turn[1], 0.0)
        approach = approach._replace(largest=turn[1], sides=system.sides[0].copy())
    return _first(approach, turn, (1.0, 0.0), end, *scales)[0]


@kernel
def _first(
    approach: _Approach, start: Phase, weights: tuple[float, float], end: float, unit: float,
    speed: float,
) -> Phase:  # fmt: skip
    """Return where the weighted sum of overlap and rate first falls to ``end``, NaN for never.

    The steps of the integration lead past it; Newton's method goes back, each time by a step from
    the last state before. ``unit`` [s] and ``speed`` [m/s] are the scales of errors.
    """
    time, x, v = start
    h, strides = 1e-3 * unit, 0
    while time < LONGEST * unit and strides < MOST_STRIDES:
        strides += 1
        next_x, next_v, error = _stride(approach, x, v, h, unit, speed)
        if error > TOLERANCE:
            h *= max(0.1, 0.9 * (TOLERANCE / error) ** 0.2)
            continue
        if weights[0] * next_x + weights[1] * next_v < end:
            for _ in range(MOST_CORRECTIONS):
                rate = weights[0] * next_v + weights[1] * _acceleration(approach, next_x, next_v)
                change = (end - weights[0] * next_x - weights[1] * next_v) / rate
                h += change
                next_x, next_v, _ = _stride(approach, x, v, h, unit, speed)
                if abs(change) <= 1e-15 * unit:
                    break
            return time + h, next_x, next_v
        time, x, v = time + h, next_x, next_v
        h *= min(4.0, 0.9 * (TOLERANCE / max(error, 1e-300)) ** 0.2)
    return math.nan, x, v


@kernel
def _stride(
    approach: _Approach, x: float, v: float, h: float, unit: float, speed: float
) -> tuple[float, float, float]:
    """Return overlap [m] and rate [m/s] after a time, and their relative error.

    By two steps of half the time, corrected by a step of the whole, of which the error is.
    """
    coarse_x, coarse_v = _step(approach, x, v, h)
    x, v = _step(approach, x, v, 0.5 * h)
    x, v = _step(approach, x, v, 0.5 * h)
    change_x, change_v = (x - coarse_x) / 15.0, (v - coarse_v) / 15.0
    error = (abs(change_x) / unit + abs(change_v)) / speed
    return x + change_x, v + change_v, error


@kernel
def _step(approach: _Approach, x: float, v: float, h: float) -> tuple[float, float]:
    """Take a step of the classical method of Runge and Kutta."""
    first = _acceleration(approach, x, v)
    second = _acceleration(approach, x + 0.5 * h * v, v + 0.5 * h * first)
    third = _acceleration(approach, x + 0.5 * h * (v + 0.5 * h * first), v + 0.5 * h * second)
    last = _acceleration(approach, x + h * (v + 0.5 * h * second), v + h * third)
    x += h * v + h * h / 6.0 * (first + second + third)
    return x, v + h / 6.0 * (first + 2.0 * (second + third) + last)


@kernel
def _acceleration(approach: _Approach, x: float, v: float) -> float:
    """Return the acceleration of the overlap [m/s2] at an overlap [m] and its rate [m/s]."""
    system, contact = approach.system, approach.system.contacts[0]
    contact.largest = approach.largest
    for k in range(2):
        system.sides[0, k] = approach.sides[k]
    overlap = max(x, approach.least)
    overlap = 1e-300 if overlap == 0.0 else overlap  # mdr divides by it
    touch = Touch((0.0, 0.0, 1.0), overlap, approach.other, ZERO)
    press = find_press(system, FIRST, touch, approach.radius, -v, MOVES)
    force = press.force
    if approach.bulk > 0.0:
        force = _bulk_force(approach) + press.eta * v
        if system.laws[contact.law].clipped:
            force = max(force, 0.0)
    return approach.gravity - force / approach.mass


@kernel
def _bulk_force(approach: _Approach) -> float:
    """Return the bulk response K A^2 d / V [N], A = pi R d: the mean of both sides."""
    total, count = 0.0, 1 if approach.other == 0.0 else 2
    for k in range(count):
        r, depth = approach.system.bodies[k].radius, approach.system.sides[0, k].depth
        volume = math.pi / 3.0 * (4.0 * r**3 - depth * depth * (3.0 * r - depth))
        total += approach.bulk * (math.pi * r * depth) ** 2 * depth / volume
    return total / count


def _yield_depth(law: Law, radius: float) -> float:
    """Return the depth [m] at which Hertz's mean pressure is Y (1 + 1.75 exp(-4.4 d / R))."""
    from scipy.optimize import brentq

    assert law.moduli is not None
    assert law.yield_stress is not None
    modulus, stress = 2.0 * law.moduli[0], law.yield_stress

    def excess(share: float) -> float:
        hertz = 4.0 * modulus / (3.0 * math.pi) * math.sqrt(share)
        return hertz - stress * (1.0 + 1.75 * math.exp(-4.4 * share))

    if excess(1.0) < 0.0:
        return math.inf
    return radius * float(brentq(excess, 0.0, 1.0, xtol=1e-300, rtol=1e-15))


# ---- by the reference, in the limit of small steps


def _extrapolated(time_at: Callable[[int], float]) -> float:
    """Return Richardson's limit of first order of a time at so many steps."""
    return 2.0 * time_at(2 * FINE_STEPS) - time_at(FINE_STEPS)


@lru_cache(maxsize=4096)  # impacts with and without friction have one straight part
def _stepped_time(scene: Scene, step: float) -> float:
    """Return the time from touch to the end of the first contact in the reference [s]."""
    impact, steps = _impact(scene), int(LONGEST) * FINE_STEPS * 2
    for simulation in _looks(scene, step, steps, 0, FINE_STEPS // 4):
        rest = float(simulation.system.sides["rest"][0].sum())  # of spheres that yielded
        end = rest if impact.yields else impact.last_overlap
        gap, speed = _separation(simulation, end)
        if gap > 0.0 and speed > 0.0 and not simulation.system.state[0, FORCE].any():
            # since it flies freely
            flight = 2.0 * gap / (speed + math.sqrt(speed * speed + 2.0 * impact.gravity * gap))
            return (simulation.step_number - 0.5) * step - flight
    raise _endless(scene.law)


def _time_of_overlap(scene: Scene, step: float, overlap: float, start: float) -> float:
    """Return the time from touch to an overlap [m] in the reference, looked for from ``start``."""
    end = _impact(scene).last_overlap
    for simulation in _looks(scene, step, FINE_STEPS * 4, int(start / step), 1):
        gap, speed = _separation(simulation, end)
        if gap <= -overlap:
            break
    return (simulation.step_number - 0.5) * step - (gap + overlap) / speed


def _looks(
    scene: Scene, step: float, steps: int, first: int, every: int
) -> Iterator[reference.Simulation]:
    """Yield a run from half a step before touch, every so many steps after the ``first``."""
    fine = scene.model_copy(update={"step": step, "steps": steps, "every": steps})  # as checked
    run = before(fine, 0.5 * step)
    simulation = reference.Simulation(run, LIMIT)
    simulation.advance(first)
    while not simulation.over:
        simulation.advance(every)
        yield simulation


def _separation(simulation: reference.Simulation, end: float) -> tuple[float, float]:
    """Return how far bodies are beyond an overlap ``end`` [m], and how fast they go on [m/s]."""
    state, radii = simulation.system.state, simulation.system.bodies["radius"]
    if len(radii) == 1:
        return float(state[0, 0, 2] - radii[0] + end), float(state[0, 1, 2])
    separation, moving = state[0, 0] - state[1, 0], state[0, 1] - state[1, 1]
    # where a straight line leaves the sphere of this radius
    reach = float(radii[0] + radii[1]) - end
    distance, speed = float(np.linalg.norm(separation)), float(np.linalg.norm(moving))
    along = float(separation @ moving) / speed
    if along <= 0.0 or distance <= reach:
        return distance - reach, along * speed / distance
    root = math.sqrt(along * along - (distance - reach) * (distance + reach))
    return along - root, speed
