"""A grain on a tilted row of fixed, touching spheres: parameters, energies, starts and jobs.

A run takes one of two *routes*:

``passage``  The grain starts 10 deg behind the first crest with the energy of a grain at rest on
             that crest, passes one well, and its energy before the next crest is measured.
``steady``   It starts in a well, fast enough to leave it, and passes many wells (as in the source).

A run is judged by its *margin*: the mechanical energy, without spin, above that of a grain at rest
on the crest ahead.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Literal, Self, get_args

import numpy as np
from pydantic import Field, model_validator

from harness.cases.base import EqualSpheres
from harness.engines.base import Job, Template, Value
from harness.model.base import COUNT, Allowed, allowed_in
from harness.model.law import (
    CLIPPED,
    CONTACTS,
    PLASTIC,
    SOURCE,
    Contact,
    Law,
    NamedContact,
)
from harness.model.scene import Body, Scene, Stage
from harness.theory.incline import INERTIA, Grain, Shape, smallest_size_ratio

Route = Literal["passage", "steady"]

START_BEHIND_CREST = 10.0  # [deg] of a passage, which also ends at most as far before one
START_WITH_LITTLE_FRICTION = 1.0  # [deg] likewise: a grain rolls there with mu > 0.005
ROLLS_AT_START = 0.1  # friction with which a grain rolls at START_BEHIND_CREST, 0.06 is the least
SPEED_AFTER_SHOCK = 0.35  # [sqrt(g a)] near the critical angle of equal spheres
SETTLING_TIMES = 8.0  # of the contact's slowest rate, until it has settled after a shock
START_SPEED = 0.48  # [sqrt(g d)] of steady motion
PASSAGE, SLIDING_PASSAGE, WELL = 2.1, 8.0, 4.5  # [sqrt(d/g)] of a passage, of each well of a run
MOST_SCENE_SPHERES = 9  # a longer periodic row is the same system


class OverRow(EqualSpheres):
    """One run of a grain over a periodic row of spheres, in SI units."""

    # fmt: off
    angle: float = Field(10.2, ge=0.0, le=30.0, description="[deg] tilt of the row")
    spheres: int = Field(9, ge=4, le=100_000, description="[-] fixed spheres in the periodic row")
    wells: int = Field(10, ge=1, le=10_000, description="[-] wells to pass in the steady route")
    phase: float = Field(
        0.0, ge=0.0, le=1.0, description="[-] fraction of a step by which the start is shifted")
    time_limit: float = Field(
        400.0, gt=0.0, description="[-] longest motion, in units of sqrt(diameter / gravity)")
    # fmt: on

    @property
    def tilt(self) -> float:
        """Return the angle [rad]."""
        return math.radians(self.angle)

    @property
    def weight(self) -> float:
        """Return m g [N]."""
        return self.mass * self.gravity

    @property
    def unit_of_time(self) -> float:
        """Return sqrt(d / g) [s]."""
        return math.sqrt(self.diameter / self.gravity)

    @property
    def weight_energy(self) -> float:
        """Return m g d [J], the unit of energy."""
        return self.weight * self.diameter

    @property
    def static_overlap(self) -> float:
        """Return m g / (k d) [-], the overlap under the weight in diameters of the row."""
        return self.weight / (self.stiffness * self.diameter)

    @property
    def weight_along(self) -> tuple[float, float, float]:
        """Return gravity [m/s2] along the row, normal to it and sideways."""
        g = self.gravity
        return (g * math.sin(self.tilt), -g * math.cos(self.tilt), 0.0)

    @property
    def most_steps(self) -> int:
        """Return the steps until the time limit."""
        return math.ceil(self.time_limit * self.unit_of_time / self.step)

    def check_step(self, fewest: float) -> None:
        """Raise ValueError unless a contact has more than so many steps."""
        if self.steps_per_contact <= fewest:
            raise ValueError(
                f"steps_per_contact = {self.steps_per_contact:g} is unstable at damping ratio "
                f"{self.contact.zeta:.4g}: must be greater than {fewest:.3f}"
            )


class Incline(OverRow):
    """One run of a grain over the row; it has the row's density, and its size unless given."""

    # fmt: off
    contact: NamedContact = Field(SOURCE, description="[-] dissipation of the contact")
    steps_per_contact: float = Field(
        50.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)")
    friction: float = Field(0.0, ge=0.0, le=1e9, description="[-] Coulomb's mu of the contact")
    grain_diameter: float | None = Field(
        None, gt=0.0, description="[m] diameter of the grain, that of the row unless given")
    shape: Shape = Field(
        "sphere", description="[-] sphere or disc: moment of inertia 2/5 or 1/2 m R^2")
    tangential_stiffness: float | None = Field(
        None, gt=0.0, le=10.0, description="[-] over the normal one; 2/7 unless given, disc 1/3")
    tangential_damping: float | None = Field(
        None, ge=0.0, le=10.0, description="[-] over the normal one; 2/7 unless given, disc 1/3")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not 1e-99 < self.diameter * self.density ** (1 / 3) < 1e99:
            raise ValueError(
                f"diameter = {self.diameter:g} m with density = {self.density:g} kg/m3 gives a "
                "mass that is beyond floating point: must be from about 1e-297 to 1e297 kg"
            )
        if not self.is_plain:
            self._check_size()
        if self.static_overlap > 0.01:
            raise ValueError(
                f"stiffness = {self.stiffness:g} N/m is too soft: the grain's weight would press "
                f"it {100 * self.static_overlap:.3g} % of a diameter into the row; must be at "
                f"least {100 * self.weight / self.diameter:.4g} N/m (1 %)"
            )
        self.check_step(self.fewest_steps_per_contact)
        return self

    def _check_size(self) -> None:
        most = self.spheres * self.diameter / 2.0
        if self.grain > most:
            raise ValueError(
                f"grain_diameter = {self.grain:g} m: must be at most {most:g} m, half of a row of "
                f"{self.spheres} spheres"
            )
        if self.grain >= self.diameter:
            return  # the least ratio is below 0.83 at any friction, and takes long to find
        least = smallest_size_ratio(Grain.of(self.friction, self.shape)) * self.diameter
        if self.grain < least:
            raise ValueError(
                f"grain_diameter = {self.grain:g} m: must be at least {least * (1 + 1e-6):.6g} m "
                f"at friction {self.friction:g}, a smaller grain leaves the row below its critical "
                "angle"
            )

    @property
    def is_plain(self) -> bool:
        """Return whether the grain is as large as the row's spheres and has no friction."""
        return self.friction == 0.0 and self.grain == self.diameter

    @property
    def grain(self) -> float:
        """Return the diameter of the grain [m]."""
        return self.diameter if self.grain_diameter is None else self.grain_diameter

    @property
    def arm(self) -> float:
        """Return the distance [m] of the grain's centre from a sphere that it touches."""
        return 0.5 * (self.grain + self.diameter)

    @property
    def half_angle(self) -> float:
        """Return the half angle of a well [rad], 30 deg for a grain of the row's size."""
        return math.asin(0.5 * self.diameter / self.arm)

    @property
    def inertia(self) -> float:
        """Return beta [-] of the moment of inertia beta m R^2."""
        return INERTIA[self.shape]

    @property
    def rolling_inertia(self) -> float:
        """Return beta [-] of a grain that rolls, 0 of one without friction."""
        return self.inertia if self.friction else 0.0

    @property
    def mass(self) -> float:
        """Return the grain's mass [kg]."""
        return self.density * math.pi / 6.0 * self.grain**3

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the bound below which velocity Verlet is unstable in the well.

        Normal to the row the grain has F = 2 cos(phi)^2 times the spring and dashpot of one
        contact. With damping by the velocity of the half step v+ = v (1 - 2 F zeta a) -
        F a^2 x / dt, x+ = x + dt v+, where a = omega dt = pi / steps per contact. Jury's criterion
        is a < 2 (sqrt(zeta^2 + 1/F) - zeta). With friction F is at most 2, times the ratio of
        tangential to normal rates where that exceeds 1.
        """
        zeta, phi = self.contact.zeta_against_full_mass, self.half_angle
        factor = 2.0 * max(math.cos(phi) ** 2, math.sin(phi) ** 2)
        if self.friction > 0.0:
            share = self.inertia / (1.0 + self.inertia)
            factor = 2.0 * max(1.0, *(ratio / share for ratio in self.tangential_ratios))
        return math.pi / (2.0 * (math.sqrt(zeta * zeta + 1.0 / factor) - zeta))

    @property
    def tangential_ratios(self) -> tuple[float, float]:
        """Return tangential over normal stiffness and damping, beta / (1 + beta) unless given."""
        share = self.inertia / (1.0 + self.inertia)
        stiffness, damping = self.tangential_stiffness, self.tangential_damping
        return (share if stiffness is None else stiffness, share if damping is None else damping)

    @property
    def law(self) -> Law:
        """Return the law of the contact of grain and row."""
        law = self.contact.law(self.stiffness)
        if self.friction == 0.0:
            return law
        stiffness, damping = self.tangential_ratios
        return law.replace(
            tangential="linear_history",
            tangential_stiffness=stiffness * self.stiffness,
            tangential_damping=damping,
            friction=self.friction,
        )


def changed_contact(
    name: str,
    restitution: float | None = None,
    damping_ratio: float | None = None,
    clip: bool | None = None,
    half_mass: bool = False,
) -> Contact:
    """Return a contact of ``CONTACTS``, by the name ``custom`` where an argument changes it.

    A restitution or a damping ratio takes the place of both.
    """
    changes: dict[str, Any] = {}
    if restitution is not None or damping_ratio is not None:
        changes |= {"restitution": restitution, "damping_ratio": damping_ratio}
    if clip is not None:
        changes["tail"] = "clipped" if clip else "attractive"
    if half_mass:
        changes["effective_mass"] = "half"
    return CONTACTS[name].replace(**changes, name="custom") if changes else CONTACTS[name]


def friction_text(case: Incline) -> str:
    """Return friction, size and shape of a grain in words, empty for a plain one."""
    words = [f", friction {case.friction:g}"] if case.friction else []
    words += [f", grain of {case.grain / case.diameter:g} d"] if case.grain != case.diameter else []
    words += [", disc"] if case.friction and case.shape == "disc" else []
    return "".join(words)


# ---- energies


def crest_radius(case: Incline) -> float:
    """Return the distance [m] of a grain at rest on a crest from the sphere below it."""
    return case.arm - case.weight / case.stiffness


def crest_energy(case: Incline) -> float:
    """Return the energy [J] of a grain at rest on the first crest, pressed in."""
    return case.weight * crest_radius(case) + 0.5 * case.weight**2 / case.stiffness


def overlaps(case: Incline, x: Any, y: Any) -> tuple[Any, Any]:
    """Return the overlaps [m] with the spheres behind and ahead; negative is a gap."""
    behind = case.diameter * np.floor(x / case.diameter)
    return case.arm - np.hypot(x - behind, y), case.arm - np.hypot(x - behind - case.diameter, y)


def margin(case: Incline, well: Any, state: Sequence[Any]) -> Any:
    """Return the energy [m g d] above that of a grain at rest on the crest after ``well`` wells.

    ``well`` and ``state``, x, y [m], vx, vy [m/s], are numbers or arrays of one shape.
    """
    x, y, vx, vy = state
    height = y * math.cos(case.tilt) - x * math.sin(case.tilt)
    behind, ahead = (np.maximum(overlap, 0.0) for overlap in overlaps(case, x, y))
    springs = 0.5 * case.stiffness * (behind**2 + ahead**2)
    total = 0.5 * case.mass * (vx * vx + vy * vy) + case.weight * height + springs
    fall = case.weight * well * case.diameter * math.sin(case.tilt)
    return (total - crest_energy(case) + fall) / case.weight_energy


# ---- where a run starts and ends


def start_of(case: Incline, route: Route) -> tuple[float, float, float, float, float]:
    """Return x, y [m], vx, vy [m/s] and the spin along z [rad/s] at the start of a route."""
    return _start_behind_crest(case) if route == "passage" else _start_in_well(case)


def _start_in_well(case: Incline) -> tuple[float, float, float, float, float]:
    """Start touching both spheres, along the tangent of the one ahead, rolling with friction."""
    height = math.sqrt(case.arm**2 - 0.25 * case.diameter**2)
    speed = START_SPEED * math.sqrt(case.gravity * case.diameter)
    vx, vy = speed * height / case.arm, speed * 0.5 * case.diameter / case.arm
    return 0.5 * case.diameter, height, vx, vy, _rolling_spin(case, speed)


def _start_behind_crest(case: Incline) -> tuple[float, float, float, float, float]:
    """Start at an angle phi behind the crest with the energy of a grain at rest on it.

    A grain with friction rolls, v^2 = 2 g a (1 - cos(phi)) / (1 + beta); without, beta = 0. The
    overlap balances the normal force, N = m g ((3 + beta) cos(phi) - 2) / (1 + beta).
    """
    a, beta, behind = case.arm, case.rolling_inertia, math.radians(start_degrees(case))
    rate = math.sqrt(2.0 * case.gravity * (1.0 - math.cos(behind)) / a / (1.0 + beta))
    phi = behind + case.phase * rate * case.step
    overlap = case.weight * ((3.0 + beta) * math.cos(phi) - 2.0) / (1.0 + beta) / case.stiffness
    r, spring = a - overlap, 0.5 * case.stiffness * overlap**2
    slope = (3.0 + beta) * case.weight * math.sin(phi) / (1.0 + beta) / case.stiffness  # dr/dphi
    kinetic = crest_energy(case) - case.weight * r * math.cos(phi) - spring
    omega = math.sqrt(2.0 * kinetic / case.mass / ((1.0 + beta) * r * r + slope * slope))
    sine, cosine = math.sin(phi - case.tilt), math.cos(phi - case.tilt)
    return (
        r * sine,
        r * cosine,
        omega * (r * cosine + slope * sine),
        omega * (slope * cosine - r * sine),
        _rolling_spin(case, omega * r),
    )


def start_degrees(case: Incline) -> float:
    """Return how far behind the crest [deg] a passage starts: a grain with friction rolls there."""
    little = 0.0 < case.friction < ROLLS_AT_START
    return START_WITH_LITTLE_FRICTION if little else START_BEHIND_CREST


def _rolling_spin(case: Incline, speed: float) -> float:
    return -2.0 * speed / case.grain if case.friction else 0.0


def end_of(case: Incline, route: Route, well: Any) -> Any:
    """Return the x [m] that ends a well: the crest, or before it where a passage has settled."""
    before = settled_before(case) if route == "passage" else 0.0
    return well * case.diameter - crest_radius(case) * math.sin(case.tilt + before)


def settled_before(case: Incline) -> float:
    """Return how far before the crest [rad] a contact has settled after a shock, 10 deg at most.

    From there on the energy is conserved, and the slow way to the crest is not run. The slowest
    rate is that of x'' + 2 zeta omega x' + omega^2 x = 0. A passage of a grain that may slide ends
    on the crest.
    """
    if may_slide(case):
        return 0.0
    zeta, omega = case.contact.zeta_against_full_mass, math.sqrt(case.stiffness / case.mass)
    slowest = zeta + math.sqrt(zeta * zeta - 1.0) if zeta >= 1.0 else 1.0 / (zeta + 1e-9)
    speed = SPEED_AFTER_SHOCK * math.sqrt(case.gravity / case.arm) * case.half_angle * 6.0 / math.pi
    swept = SETTLING_TIMES * slowest / omega * speed
    return min(max(case.half_angle - case.tilt - swept, 0.0), math.radians(START_BEHIND_CREST))


def may_slide(case: Incline) -> bool:
    """Return whether friction may dissipate energy on an arc.

    A grain that rolls from rest on a crest needs the most friction at the end of the arc, at the
    angle psi = phi + tilt: beta sin(psi) / ((3 + beta) cos(psi) - 2).
    """
    psi, beta = case.half_angle + case.tilt, case.inertia
    normal = (3.0 + beta) * math.cos(psi) - 2.0
    return case.friction > 0.0 and case.friction * normal < beta * math.sin(psi)


# ---- jobs


def scene_of(case: Incline, route: Route, every: int | None = None) -> Scene:
    """Return a run as a scene, whose first body is the grain, with a stage for each well.

    Without ``every`` the start is the only sample: the ends of stages are enough to judge a run.
    """
    fall = case.weight * case.diameter * math.sin(case.tilt)
    floor = case.weight * crest_radius(case)  # a Stage's energy has no springs
    return Scene(
        bodies=_bodies(case, route),
        law=case.law,
        gravity=case.weight_along,
        period=(min(case.spheres, MOST_SCENE_SPHERES) * case.diameter, None, None),
        step=case.step,
        steps=case.most_steps,
        every=every or case.most_steps,
        stages=tuple(
            Stage(place=end_of(case, route, well), floor=floor - well * fall)
            for well in range(1, wells_of(case, route) + 1)
        ),
    )


def _bodies(case: Incline, route: Route) -> tuple[Body, ...]:
    x, y, vx, vy, spin = start_of(case, route)
    grain = _body(case, case.grain, case.mass).replace(
        position=(x, y, 0.0), velocity=(vx, vy, 0.0), angular_velocity=(0.0, 0.0, spin)
    )
    row_mass = case.density * math.pi / 6.0 * case.diameter**3
    fixed = "frozen" if case.contact.effective_mass == "full" else "held"
    sphere = _body(case, case.diameter, row_mass).replace(motion=fixed)
    return (grain, *_row(sphere, min(case.spheres, MOST_SCENE_SPHERES)))


@lru_cache(maxsize=64)
def _row(sphere: Body, count: int) -> tuple[Body, ...]:
    """Return touching spheres along x: the same objects for all cases of a search."""
    places = 2.0 * sphere.radius * np.arange(count)
    return tuple(sphere.replace(position=(float(x), 0.0, 0.0)) for x in places)


def _body(case: Incline, diameter: float, mass: float) -> Body:
    inertia = case.inertia * mass * (0.5 * diameter) ** 2 if case.shape == "disc" else None
    return Body(radius=0.5 * diameter, mass=mass, inertia=inertia)


def wells_of(case: OverRow, route: Route) -> int:
    """Return how many wells a run passes."""
    return 1 if route == "passage" else case.wells


def values_of(case: Incline, route: Route, every: int | None = None) -> dict[str, Value]:
    """Return the values of a script for a run, sampled every so many steps."""
    same = ("angle", "stiffness", "steps_per_contact", "gravity", "diameter", "density", "wells",
            "time_limit", "spheres", "phase", "friction", "shape")  # fmt: skip
    stiffness, damping = case.tangential_ratios
    sampled: dict[str, Value] = {} if every is None else {"series_every": every}
    return {
        "route": route,
        **{name: getattr(case, name) for name in same},
        "grain_diameter": case.grain_diameter or 0.0,
        "tangential_stiffness": stiffness,
        "tangential_damping": damping,
        "start": start_degrees(case),
        **case.contact.script_values,
        **sampled,
    }


_RANGES = allowed_in(Incline)
_SCRIPTED = values_of(Incline(), "steady")
TEMPLATE = Template(
    name="incline",
    variants={
        contact.name: values_of(Incline(contact=contact, steps_per_contact=steps), "steady")
        for contact, steps in ((PLASTIC, 100.0), (SOURCE, 50.0), (CLIPPED, 50.0))
    },
    notes={
        "plastic": "overdamped and clipped: no tail, no rebound; the one to extrapolate.",
        "source": "e = 1e-20 with the attractive tail, as Harper, Dufek and Breard ran it.",
        "clipped": "critical damping, tail clipped; it rebounds with e = exp(-2) = 0.135.",
    },
    allowed={
        # the angle is changed the most, and is checked first
        **{name: _RANGES[name] for name in ("angle", *_RANGES) if name in _SCRIPTED},
        "grain_diameter": Allowed(bounds={"minimum": 0}, unit="m"),  # 0: that of the row
        "damping": Allowed(words=("restitution", "ratio")),
        **allowed_in(Contact),
        "route": Allowed(words=get_args(Route)),
        # at 10 sqrt(g d) the softest contact is pressed in by a diameter, v sqrt(m / k)
        "speed": Allowed(bounds={"exclusiveMinimum": 0, "maximum": 10}, unit="sqrt(g d)"),
        "start": Allowed(bounds={"exclusiveMinimum": 0, "maximum": 30}, unit="deg"),
        "series_every": COUNT,
    },
)


def job_of(case: Incline, route: Route, every: int | None = None) -> Job:
    """Return the job of a run: in the script of its contact, a custom one in the main script.

    ``every`` is the number of steps between samples of the path, which are else not written.
    """
    variant = case.contact.name if case.contact.name in TEMPLATE.variants else TEMPLATE.main
    return Job(
        TEMPLATE,
        values_of(case, route, every),
        variant,
        sampled=every is not None,
        scene=scene_of(case, route, every),
        steps=expected_steps(case, route),
    )


def expected_steps(case: Incline, route: Route) -> float:
    """Return how many steps a run takes near the critical angle."""
    passage = SLIDING_PASSAGE if may_slide(case) else PASSAGE
    longest = passage if route == "passage" else WELL * case.wells
    return min(longest, case.time_limit) * case.unit_of_time / case.step
