"""The duration of the first contact of an impact, from which the step of a run is chosen.

The motion along the normal, m* x'' = -F(x, x') with the overlap x, is integrated by an adaptive
Runge-Kutta method of order 8 (Hairer, Norsett and Wanner, 1993). Two spheres that meet at an angle
turn about one another, which ends the contact earlier, by a share of some u^2 t / (4 r v): that is
the difference of two runs of the reference, in the limit of small steps. So is the duration of a
contact that yields, whose law has a memory of its own.

Sources of the forces are those of :mod:`harness.model.law`; of mdr its limit of small steps, on
rigid flats without the factor that a code has at walls.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from harness.errors import RequestError
from harness.model.base import ZERO
from harness.model.conventions import Faults, Rules
from harness.model.law import DAMPING, Law
from harness.model.scene import Floats, Scene, effective_mass, effective_radius
from harness.solvers import mdr, reference
from harness.solvers.contacts import jkr_radius
from harness.solvers.kernels import FORCE

TOLERANCE = 1e-13  # relative, of a step of the integration
MOST_STEPS = 100_000  # with those that are repeated
STEPS_AT_ONCE = 900  # an integration takes some 80; after 1000 it would be given up as stiff
MOST_CORRECTIONS = 20  # by Newton's method, which takes some five
LONGEST = 64.0  # times the guess that a contact may take: a strong dashpot draws it out
FINE_STEPS = 5000  # of a contact, of the coarser of two runs of the reference
_Phase = tuple[float, Floats]  # time, overlap and its rate, in the units of an impact
LIMIT = Rules(mdr_wall_force="plain", mdr_growth="whole", mdr_growth_steps=1.0)


@lru_cache(maxsize=4096)
def contact_time(scene: Scene) -> float:
    """Return how long the first contact of a scene lasts [s], whose bodies touch at the start.

    Raise RequestError for a contact that does not end.
    """
    impact = _impact(scene)
    if impact.yields:
        # a whole number of steps until it yields, which is noticed at one phase of them all
        unit = min(yield_time(scene), impact.elastic_time)
        coarse = unit / math.ceil(unit / impact.elastic_time * FINE_STEPS) * FINE_STEPS
        return _extrapolated(lambda steps: _stepped_time(scene, coarse / steps))
    lasts = _normal_time(impact)
    return lasts + _shift(scene, lasts, _stepped_time)


@lru_cache(maxsize=4096)
def yield_time(scene: Scene) -> float:
    """Return after which time of its first contact [s] a sphere of mdr yields; inf if never."""
    impact = _impact(scene)
    if not impact.yields:
        return math.inf
    overlap = _yield_depth(impact.law, impact.first) * (2.0 if impact.second else 1.0)
    until = _solve(impact, overlap, closing=True)
    if until is None:
        return math.inf
    elastic = scene.replace(law=scene.law.replace(yield_stress=None))
    return until + _shift(
        elastic, until, lambda scene, step: _time_of_overlap(scene, step, overlap, 0.98 * until)
    )


def before(scene: Scene, lead: float) -> Scene:
    """Return a scene a time [s] before, when its first body flew freely."""
    bodies, g = [], np.array(scene.gravity)
    for body in scene.bodies:
        x, v = np.array(body.position), np.array(body.velocity)
        place, velocity = x - lead * v + 0.5 * lead * lead * g, v - lead * g
        bodies.append(body.replace(position=place.tolist(), velocity=velocity.tolist()))
        g = np.zeros(3)  # the others do not fall
    return scene.replace(bodies=tuple(bodies))


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


def _impact(scene: Scene) -> _Impact:
    first, second = scene.bodies[0], scene.bodies[1] if len(scene.bodies) > 1 else None
    law = scene.law_of(first.type, (second or scene.walls[0]).type).one_material
    falls = second is None or second.motion == "frozen"
    return _Impact(
        law=law.replace(tangential="none", rolling="none", twisting="none", interface="current"),
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
    bodies = (
        body.replace(velocity=(0.0, 0.0, body.velocity[2]), angular_velocity=ZERO)
        for body in scene.bodies
    )
    straight = scene.replace(bodies=tuple(bodies))
    return _extrapolated(
        lambda steps: time_of(scene, unit / steps) - time_of(straight, unit / steps)
    )


# ---- along the normal


@lru_cache(maxsize=4096)
def _normal_time(impact: _Impact) -> float:
    time = _solve(impact, impact.last_overlap, closing=False)
    if time is None:
        raise _endless(impact.law)
    return time


def _endless(law: Law) -> RequestError:
    names = ("damping_coefficient", "restitution", "surface_energy")
    values = {name: getattr(law, name) for name in names}
    text = ", ".join(f"{name} = {value!r}" for name, value in values.items() if value is not None)
    return RequestError(
        f"{text}: the contact does not end; less damping or attraction, or a faster impact, end it"
    )


def _solve(impact: _Impact, end: float, *, closing: bool) -> float | None:
    """Return when the overlap first is ``end`` [m] on its way in or out [s], None for never."""
    unit, speed = impact.elastic_time, impact.speed
    force = _force(impact)
    length, pull = speed * unit, impact.gravity * unit / speed
    factor = unit / speed / impact.mass
    turned = 0.0  # largest overlap of a contact that remembers it [m]

    def rates(_: float, y: Floats) -> tuple[float, float]:
        x = float(y[0]) * length
        resisting = force(max(x, min(end, 0.0)), float(y[1]) * speed, turned)
        return float(y[1]), pull - factor * resisting

    start: _Phase = (0.0, np.array([0.0, 1.0]))
    if closing:
        reached = _first(rates, start, (-1.0, 0.0), -end / length)
    else:
        turning = _first(rates, start, (0.0, 1.0), 0.0)
        if turning is None:
            return None
        turned = float(turning[1][0]) * length
        reached = _first(rates, turning, (1.0, 0.0), end / length)
    return None if reached is None else reached[0] * unit


def _first(
    rates: Callable[[float, Floats], tuple[float, float]],
    start: _Phase,
    weights: tuple[float, float],
    end: float,
) -> _Phase | None:
    """Return where the weighted sum of overlap and rate first falls to ``end``, None for never.

    The steps of the integration lead past it; Newton's method goes back, each time by a step from
    the last state before.
    """
    from scipy.integrate import ode

    last, steps = start, 0

    def excess(y: Floats) -> float:
        return float(weights[0] * y[0] + weights[1] * y[1]) - end

    def stops(time: float, y: Floats) -> Literal[-1, 0]:
        nonlocal last, steps
        if excess(y) < 0.0 and time > start[0]:
            return -1
        last, steps = (time, y.copy()), steps + 1
        return 0 if steps % STEPS_AT_ONCE else -1

    def integrator() -> ode:
        return ode(rates).set_integrator(
            "dop853", rtol=TOLERANCE, atol=1e-3 * TOLERANCE, nsteps=MOST_STEPS
        )

    solver = integrator()
    solver.set_solout(stops)
    solver.set_initial_value(start[1], start[0])
    while solver.t < LONGEST and excess(solver.integrate(LONGEST)) >= 0.0:
        pass
    if excess(solver.y) >= 0.0:
        return None
    (origin, state), time, y = last, solver.t, solver.y
    for _ in range(MOST_CORRECTIONS):
        rate, acceleration = rates(time, y)
        change = -excess(y) / (weights[0] * rate + weights[1] * acceleration)
        time += change
        y = integrator().set_initial_value(state, origin).integrate(time)
        if abs(change) <= TOLERANCE * time:
            break
    return time, y


def _force(impact: _Impact) -> Callable[[float, float, float], float]:
    """Return the normal force [N] as a function of overlap [m], its rate [m/s] and the largest."""
    law, mass = impact.law, impact.mass
    elastic, (p, q, s) = _elastic(impact), DAMPING[law.damping].powers
    factor = reference.dashpot_coefficient(law, Faults()) * mass**p
    stiffness = law.normal_stiffness
    slope = 2.0 * (law.moduli[0] if law.moduli else 0.0) * (1.0 if impact.second else 2.0)

    def force(x: float, rate: float, largest: float) -> float:
        spring, a = elastic(x, largest)
        eta = factor * a**q
        if s:
            secant = stiffness or (spring / x if x > 0.0 else 0.0)
            eta *= math.sqrt(mass * max(secant, 0.0))
        elif law.damping == "mdr":
            eta *= math.sqrt(mass * slope * a)
        total = spring + eta * rate
        return max(total, 0.0) if law.clipped else total

    return force


def _elastic(impact: _Impact) -> Callable[[float, float], tuple[float, float]]:
    """Return elastic force [N] and contact radius [m] as a function of overlap and largest [m]."""
    law, radius = impact.law, impact.radius
    gamma = law.surface_energy or 0.0
    if law.normal == "mdr":
        return _elastic_mdr(impact)
    if law.normal_stiffness is not None:
        k = law.normal_stiffness
        return lambda x, _: (k * x, math.sqrt(radius * max(x, 0.0)))
    modulus = law.effective_modulus

    def hertz(x: float, _: float) -> tuple[float, float]:
        a = math.sqrt(radius * max(x, 0.0))
        pull = 4.0 * math.pi * gamma * radius if law.normal == "dmt" else 0.0
        return 4.0 / 3.0 * modulus * a * x - pull, a

    def jkr(x: float, _: float) -> tuple[float, float]:
        a = jkr_radius(modulus, gamma, radius, x)
        tension = 4.0 * math.sqrt(math.pi * gamma * modulus * a**3)
        return 4.0 / 3.0 * modulus * a**3 / radius - tension, a

    return jkr if law.normal == "jkr" and gamma else hertz


# ---- mdr: each side on a rigid flat (Zunker and Kamrin 2024)


def _elastic_mdr(impact: _Impact) -> Callable[[float, float], tuple[float, float]]:
    law, radii = impact.law, (impact.first, impact.second)
    assert law.moduli is not None
    modulus, gamma = 2.0 * law.moduli[0], law.surface_energy or 0.0
    nu = law.poisson_ratio or 0.0
    bulk = modulus * (1.0 - nu * nu) / (3.0 * (1.0 - 2.0 * nu)) if law.bulk_share else 0.0

    def side(depth: float, largest: float, r: float) -> tuple[float, float]:
        if bulk:  # K A^2 d / V, A = pi R d: nothing is left to the ellipse
            volume = 4.0 / 3.0 * math.pi * r**3 - math.pi / 3.0 * depth**2 * (3.0 * r - depth)
            return bulk * (math.pi * r * depth) ** 2 * depth / volume, math.sqrt(r * depth)
        if gamma and largest > depth:
            return _stuck(modulus, gamma, r, depth, largest)
        depth = max(depth, 0.0)
        a = 0.5 * math.sqrt((4.0 * r - depth) * depth)
        return mdr.ellipse_force(modulus, 4.0 * r, 2.0 * r, depth), a

    def force(x: float, largest: float) -> tuple[float, float]:
        first, second = radii
        if not second:
            return side(x, largest, first)
        most = max(x, largest)
        share = (2.0 * second - most) / (2.0 * (first + second - most))
        first_force, a = side(share * x, share * largest, first)
        other = side((1.0 - share) * x, (1.0 - share) * largest, second)[0]
        return 0.5 * (first_force + other), a

    return force


def _stuck(
    modulus: float, gamma: float, r: float, depth: float, largest: float
) -> tuple[float, float]:
    """Return force [N] and contact radius [m] of a side that sticks as it opens."""
    length, height, width = 2.0 * math.pi * gamma / modulus, 4.0 * r, 2.0 * r
    a = 0.5 * math.sqrt((4.0 * r - largest) * largest)
    least = mdr.least_neck(length, height, width)
    lets_go, g, slope = mdr.neck(length, height, width, a)
    for _ in range(100):
        if depth >= lets_go or a <= least:
            break
        change = (lets_go - depth) / slope
        a = max(a - change, least)
        lets_go, g, slope = mdr.neck(length, height, width, a)
        if change <= 4e-16 * a:
            break
    return mdr.ellipse_force(modulus, height, width, g) + 2.0 * modulus * a * (depth - g), a


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
    run = before(scene.replace(step=step, steps=steps, every=steps), 0.5 * step)
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
