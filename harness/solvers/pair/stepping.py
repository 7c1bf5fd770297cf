"""A scene step by step, as LAMMPS moves it: velocity Verlet, forces by velocities at half a step.

The reference integration (:mod:`harness.solvers.pair.integration`) has no step. Known defects of
releases have: what a setup repeats, a restart forgets or another particle turns round happens at a
step, and what Coulomb's limit makes of a spring happens at every one of them. This scheme states
the law of a contact as that does, and :class:`Departures` in which a release departs from it.
Without any it follows LAMMPS to round-off.

A step: half a kick, positions, forces at the new positions with the velocities of half a step, half
a kick. A spring is turned into the plane of the contact, as long as it was, then takes the slip of
the whole step; at Coulomb's limit it is cut back to what the limit leaves (Luding 2008, section
4.2). The setup of a run computes forces with the velocities of the full step and moves no spring,
but cuts back those beyond the limit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise
from typing import Any, Literal, NamedTuple

import numpy as np

from harness.errors import RequestError
from harness.parameters.rules import Rules
from harness.parameters.scene import ZERO, ContactScene, Segment
from harness.solvers.pair.friction import contact_radius, normal_force, slider_of, torque
from harness.solvers.pair.geometry import geometry, levers, normal_and_gap, vector
from harness.solvers.pair.normal import MAGNIFIED, ellipse, held, last_overlap, sunk, tsuji
from harness.solvers.pair.rates import add_force
from harness.solvers.pair.records import (
    BODY,
    CONTACT,
    TANGENTIAL,
    TWIST_NONE,
    TWISTING,
    Floats,
    System,
    Vector,
    across,
    compiled,
    cross,
    dot,
    length,
    plus,
    scaled,
)
from harness.solvers.pair.system import system_of

TURNED, PROJECTED = range(2)
"""How a spring is brought into the plane of the contact: as long as it was, or its part in it."""


class NotSteppedError(RequestError):
    """A law that remembers more of a contact than springs."""


Modes = tuple[int, bool, bool, bool, bool, bool]
"""How springs are brought into the plane, and five of the departures."""


@dataclass(frozen=True)
class Departures:
    """What a release does otherwise.

    ``tangential_radius``: a linear tangential spring is multiplied by the contact radius in m.
    ``cap_without_radius``: a spring that Coulomb's limit cuts back is left without the contact
    radius that multiplies it. ``setup``: "wall_at_rest" takes a moving plane for one at rest in
    the setup of every run. ``restart``: tangential springs are lost at the stops. ``exchange``:
    springs of rolling and twisting are multiplied by -1 at the exchanges. ``again``: at a stop the
    coefficient of tsuji's dashpot is taken for a restitution, and has another in its place.
    ``touches_at_no_overlap``: bodies that just touch are in contact. ``parts_at_no_overlap``: jkr
    has no neck. ``adhesion_fades``: mdr takes the area that sticks for 0.99 of the present one at
    each step that leaves it as large as that, and parts at overlap 0. ``twisting_limit_by_rate``:
    a torque of twisting at its limit has the sign of the rate, and is 0 where nothing twists.
    ``rolling_in_setup``: the setup adds a torque along the spin of the first body on a plane, this
    share of the limit of rolling.
    """

    tangential_radius: bool = False
    cap_without_radius: bool = False
    setup: Literal["full_step_velocity", "wall_at_rest"] = "full_step_velocity"
    restart: Literal["kept", "springs_lost"] = "kept"
    exchange: Literal["kept", "turning_springs_turned"] = "kept"
    again: Literal["kept", "restitution_from_coefficient"] = "kept"
    touches_at_no_overlap: bool = False
    parts_at_no_overlap: bool = False
    adhesion_fades: bool = False
    twisting_limit_by_rate: bool = False
    rolling_in_setup: float = 0.0


class Steps(NamedTuple):
    """Samples of a run: times (S,), positions, velocities, omegas, forces, torques (S, N, 3).

    Forces and torques are those of the contacts.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    omegas: Floats
    forces: Floats
    torques: Floats


def advance(
    scene: ContactScene,
    rules: Rules,
    departures: Departures | None = None,
    *,
    stops: Sequence[int] = (),
    exchanges: Sequence[int] = (),
) -> Steps:
    """Return the samples of a scene, step by step; ``stops`` and ``exchanges`` are steps.

    Raise NotSteppedError for a law that remembers more of a contact than springs.
    """
    if departures is not None and departures.adhesion_fades:
        return _fading(scene, rules)
    run = _SteppedScene(scene, rules, departures or Departures())
    starts = dict(
        zip(accumulate((0, *(s.steps for s in scene.segments))), scene.segments, strict=False)
    )
    places = sorted({*range(0, scene.steps + 1, scene.every), *starts, *stops, *exchanges})
    samples = []
    for number, until in pairwise((*places, scene.steps)):
        if number and number % scene.every == 0:
            samples.append(run.sample(number))
        if number in starts:
            run.prescribe(starts[number])
        if number in exchanges:
            run.exchange()
        if number in stops:
            run.restart()
        if number == 0 or number in starts or number in stops:
            run.set_up()
        if number == 0:
            samples.append(run.sample(0))
        run.go_on(until - number)
    return Steps(*(np.array(part) for part in zip(*samples, strict=True)))


STUCK = 0.99
"""Of the contact radius, that sticks as mdr's adhesion fades."""


def _fading(scene: ContactScene, rules: Rules) -> Steps:
    """Return the samples of a pull along z in which the adhesion of mdr fades."""
    (piece,), system = scene.segments, system_of(scene, rules)
    law, contact = system.law, system.contacts[0]
    flats = 1.0 if contact["second"] < 0 else 2.0
    radius, modulus = float(contact["first_radius"]), 2.0 * float(law["stiffness"])
    count, still = scene.steps + 1, np.zeros((scene.steps + 1, len(scene.bodies), 3))
    times = np.linspace(0.0, scene.duration, count)
    places = np.array([body.position for body in scene.bodies]) + still
    places[:, 0] += times[:, None] * np.array(piece.velocities[0])
    forces, stuck = still.copy(), 0.0
    for k in range(count):
        depth = normal_and_gap(places[k].repeat(BODY // 3, axis=0).ravel(), system, 0)[1] / flats
        if depth <= 0.0:
            continue
        bare = ellipse(modulus, 4.0 * radius, 2.0 * radius, depth)
        if bare.radius >= stuck:
            stuck = STUCK * bare.radius
        else:
            largest = sunk(modulus, float(law["surface"]), radius, stuck)[0]
            surface, least = float(law["surface"]), float(contact["least"])
            bare = held(modulus, surface, radius, least, depth, largest)
        more = math.exp(MAGNIFIED[0] * depth / radius + MAGNIFIED[1])
        forces[k, 0, 2] = bare.force * (
            1.0 + more if law["wall_magnified"] and flats < 2.0 else 1.0
        )
    forces[:, 1:] = -forces[:, :1]
    velocities = np.array(piece.velocities) + still
    samples: tuple[Floats, ...] = (times, places, velocities, still, forces, still)
    return Steps(*(part[:: scene.every] for part in samples))


class _SteppedScene:
    """A scene on its way, seen from its walls: state, contact radii of the last step, forces."""

    def __init__(self, scene: ContactScene, rules: Rules, departures: Departures) -> None:
        law, drifts = scene.law, {plane.velocity for plane in scene.planes}
        if law.lags or (law.normal == "mdr" and law.surface_energy):
            raise NotSteppedError("normal = 'mdr' with yield, bulk response or adhesion")
        if len(drifts) > 1:
            raise RequestError("planes: must all have one velocity")
        self.scene, self.departures = scene, departures
        self.wall = np.array(drifts.pop() if drifts else ZERO)
        self.rules = rules
        self.at_rest = tuple(replace(plane, velocity=ZERO) for plane in scene.planes)
        self.system = system_of(replace(scene, planes=self.at_rest), rules)
        self.y = np.zeros(BODY * len(scene.bodies) + CONTACT * len(self.system.contacts))
        self.bodies = self.y[: BODY * len(scene.bodies)].reshape(-1, 3, 3)
        self.springs = self.y[self.bodies.size :].reshape(-1, CONTACT)[:, 1:]
        for b, body in enumerate(scene.bodies):
            self.bodies[b] = (body.position, np.array(body.velocity) - self.wall, body.omega)
        classic = law.tangential in ("linear_history_classic", "mindlin_classic")
        self.modes = (
            PROJECTED if classic else TURNED,
            departures.tangential_radius,
            departures.cap_without_radius,
            departures.touches_at_no_overlap,
            departures.parts_at_no_overlap,
            departures.twisting_limit_by_rate,
        )
        self.radii = np.zeros(len(self.system.contacts))
        self.acting = np.zeros((len(scene.bodies), 6))

    def prescribe(self, segment: Segment) -> None:
        self.bodies[:, 1] = np.array(segment.velocities) - self.wall
        self.bodies[:, 2] = np.array(segment.omegas)

    def exchange(self) -> None:
        if self.departures.exchange == "turning_springs_turned":
            self.springs[:, 3:] *= -1.0

    def restart(self) -> None:
        if self.departures.restart == "springs_lost":
            self.springs[:, :3] = 0.0
        if self.departures.again == "restitution_from_coefficient":
            law = self.scene.law
            assert law.restitution is not None
            changed = law.replace(restitution=tsuji(law.restitution))
            self.system = system_of(
                replace(self.scene, planes=self.at_rest, law=changed), self.rules
            )

    def set_up(self) -> None:
        seen = self.wall if self.departures.setup == "wall_at_rest" else np.zeros(3)
        self.bodies[:, 1] += seen
        contacts(self.y, self.system, self.modes, 0.0, self.radii, self.acting)
        self.bodies[:, 1] -= seen
        if self.departures.rolling_in_setup:
            body, spin = self.scene.bodies[0], np.array(self.scene.bodies[0].omega)
            load = abs(float(self.acting[0, :3] @ np.array(self.scene.planes[0].direction)))
            limit = (self.scene.law.rolling_friction or 0.0) * body.radius * load
            size = float(np.linalg.norm(spin)) or 1.0
            self.acting[0, 3:] += self.departures.rolling_in_setup * limit * spin / size

    def go_on(self, steps: int) -> None:
        h = self.scene.step
        take_steps(self.y, steps, h, self.system, self.modes, self.radii, self.acting)

    def sample(self, number: int) -> tuple[Any, ...]:
        time, here = number * self.scene.step, self.bodies.copy()
        here[:, 0] += time * self.wall
        here[:, 1] += self.wall
        acting = self.acting.copy()
        for b, body in enumerate(self.scene.bodies):
            if body.frozen:
                acting[b] = 0.0
        return time, here[:, 0], here[:, 1], here[:, 2], acting[:, :3], acting[:, 3:]


@compiled
def take_steps(
    y: Floats,
    steps: int,
    h: float,
    system: System,
    modes: Modes,
    radii: Floats,
    acting: Floats,
) -> None:
    """Move bodies and springs on; ``acting`` (bodies, 6) goes from one step to the next."""
    for _ in range(steps):
        _kick(y, 0.5 * h, system, acting)
        for b in range(len(system.bodies)):
            for k in range(3):
                y[BODY * b + k] += h * y[BODY * b + 3 + k]
        contacts(y, system, modes, h, radii, acting)
        _kick(y, 0.5 * h, system, acting)


@compiled
def _kick(y: Floats, h: float, system: System, acting: Floats) -> None:
    for b in range(len(system.bodies)):
        body = system.bodies[b]
        for k in range(3):
            y[BODY * b + 3 + k] += h * (acting[b, k] * body.inverse_mass + body.gravity[k])
            y[BODY * b + 6 + k] += h * acting[b, 3 + k] * body.inverse_inertia


@compiled
def contacts(
    y: Floats,
    system: System,
    modes: Modes,
    h: float,
    radii: Floats,
    acting: Floats,
) -> None:
    """Set ``acting`` to the contacts' forces [N] and torques [N m]; h = 0: no spring moves.

    ``radii`` are the contact radii of the step before [m], 0 where bodies were apart.
    """
    acting[:] = 0.0
    for c in range(len(system.contacts)):
        at = BODY * len(system.bodies) + CONTACT * c
        _, overlap, _ = normal_and_gap(y, system, c)
        last = 0.0
        if radii[c] > 0.0 and not modes[4]:
            record = system.contacts[c]
            law = system.law
            last = last_overlap(law.normal, law.stiffness, law.surface, record.curvature, law.fold)
        if overlap < last or (overlap == last and not modes[3]):
            y[at : at + CONTACT] = 0.0
            radii[c] = 0.0
            continue
        y[at] = overlap
        _contact(y, system, modes, h, radii, acting, c)


@compiled
def _contact(
    y: Floats,
    system: System,
    modes: Modes,
    h: float,
    radii: Floats,
    acting: Floats,
    c: int,
) -> None:
    law = system.law
    i, j = system.contacts[c].first, system.contacts[c].second
    g = geometry(y, system, c)
    normal = normal_force(g, system, c, 1)
    force = normal.force
    if law.clipped:
        force = max(force, 0.0)
    load = normal.load if law.surface > 0.0 else abs(force)
    total, couple, moment = scaled(force, g.normal), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    radius, _ = contact_radius(g, normal, system, c)
    on = (law.tangential, law.rolling, law.twisting != TWIST_NONE)
    for kind in range(3):
        if not on[kind]:
            continue
        slider = slider_of(kind, g, normal, system, c, False)
        place = BODY * len(system.bodies) + CONTACT * c + 1 + 3 * kind
        q = vector(y, place)
        stiffness, unit = slider.stiffness, 1.0
        if kind == TANGENTIAL:
            if law.rescaled and radius < radii[c]:
                q = scaled(radius / radii[c], q)
            if modes[1] or modes[2]:
                unit = radius
            if modes[1]:
                stiffness *= unit
        if h > 0.0 and stiffness > 0.0:
            gain = slider.gain
            if kind == TANGENTIAL and modes[0] == PROJECTED:
                q = across(plus(q, gain * h, slider.velocity), g.normal)
            else:
                q = plus(_in_plane(q, g.normal, kind), gain * h, slider.velocity)
        held = scaled(-slider.dashpot, slider.velocity)
        f = plus(held, -stiffness, q)
        cap = slider.friction * load
        if length(f) > cap:
            twists = dot(slider.velocity, g.normal) if kind == TWISTING else 0.0
            f = _limited(f, cap, q, kind, modes, twists, stiffness, g.normal)
            if stiffness > 0.0 and (kind == TWISTING or length(q) > 0.0):
                relaxed = scaled(-1.0 / stiffness, plus(f, -1.0, held))
                q = scaled(unit, relaxed) if modes[2] and kind == TANGENTIAL else relaxed
        for k in range(3):
            y[place + k] = q[k]
        if kind == TANGENTIAL:
            total, moment = plus(total, 1.0, f), cross(g.normal, f)
        else:
            couple = plus(couple, 1.0, torque(kind, f, g, system.contacts[c].curvature))
    radii[c] = max(radius, 1e-300)
    first, second = levers(system, c, law.torque_lever, g.overlap)
    add_force(acting, i, 1.0, total, plus(couple, -first[0], moment))
    if j >= 0:
        add_force(acting, j, -1.0, total, plus(couple, second[0], moment))


@compiled
def _limited(
    f: Vector,
    cap: float,
    q: Vector,
    kind: int,
    modes: Modes,
    twists: float,
    stiffness: float,
    normal: Vector,
) -> Vector:
    """Return a force beyond Coulomb's limit at the limit.

    As LAMMPS has it, none where the dashpot alone is beyond it, as in a setup.
    """
    if kind == TWISTING:
        if modes[5]:
            return scaled(-cap * ((twists > 0.0) - (twists < 0.0)), normal)
    elif stiffness > 0.0 and length(q) == 0.0:
        return (0.0, 0.0, 0.0)
    return scaled(cap / length(f), f)


@compiled
def _in_plane(q: Vector, normal: Vector, kind: int) -> Vector:
    """Return a spring turned into the plane, as long as it was; one of twisting to the normal."""
    size = length(q)
    if kind == TWISTING:
        along = dot(q, normal)
        return scaled(size if along > 0.0 else -size, normal)
    projected = across(q, normal)
    now = length(projected)
    return scaled(size / now, projected) if now > 0.0 else projected
