"""The case ``columns``: the incline's grain over columns of particles that give way.

Each sphere of the incline's row is the top of a column normal to it, of n particles that move along
its axis; the last one is fixed. The source explains the lower angle of thick layers by the impulse
that such a column takes. But without friction every impulse on the grain stands normal to the
sphere ahead: the half of the velocity along it survives the shock whatever the column does. Stiff
columns that damp as the grain's contact does give nothing back, and leave the 10.2078 deg of one
sphere; elastic ones give part of it back, which can only raise the angle.

At rest the grain presses a top with N along the contact's normal, at an angle beta to the column,
which bears L = N cos(beta) besides its own weight. Its contacts are the grain's (0) and those below
its particles 1 ... n - 1; compressions are c_0 = N/k and c_i = (L + i w)/k with the weight
w = m g cos(theta) of a particle along the column. Overlaps are c (overlap law) or T c (deformable
law, T = tridiag(1/2, 1, 1/2)). All is linear in the loads: above the columns' rest without a grain
the energy is (N delta_0 + L s) / 2, with the overlap delta_0 and the sinking s of the top.

A run is judged at the crest ahead by the grain's own energy. What the columns hold is not counted:
at rest on a crest they hold the same each time. That is why a passage goes on to the crest itself.
"""

from __future__ import annotations

import math
from itertools import product
from typing import Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from harness.cases.incline.system import (
    START_BEHIND_CREST,
    START_SPEED,
    Incline,
    Route,
    wells_of,
)
from harness.cases.incline.system import TEMPLATE as INCLINE_TEMPLATE
from harness.cases.incline.system import values_of as incline_values
from harness.cases.plane import EqualSpheres
from harness.cases.tower.parameters import Law
from harness.engines.base import Job, Template
from harness.model.allowed import allowed_in
from harness.model.base import ZERO
from harness.model.law import Law as ContactLaw
from harness.model.scene import Body, Scene, Stage

Floats = NDArray[np.float64]
Inside = Literal["damped", "elastic"]
MOST_SUNK = 0.1  # [d] of a column under its own weight: more is another geometry
OF_FRICTION = (
    "friction", "grain_diameter", "shape", "tangential_stiffness", "tangential_damping",
)  # fmt: skip


class Columns(EqualSpheres):
    """One run of a grain over columns of ``n`` particles, in SI units.

    With ``n`` = 1 it is the incline. The contact of the grain with a top is the incline's,
    coefficient by coefficient, whatever ``n``.
    """

    # fmt: off
    angle: float = Field(10.2, ge=0.0, le=30.0, description="[deg] tilt of the row")
    spheres: int = Field(4, ge=4, le=100_000, description="[-] columns in the periodic row")
    wells: int = Field(10, ge=1, le=10_000, description="[-] wells to pass in the steady route")
    phase: float = Field(
        0.0, ge=0.0, le=1.0, description="[-] fraction of a step by which the start is shifted")
    time_limit: float = Field(
        400.0, gt=0.0, description="[-] longest motion, in units of sqrt(diameter / gravity)")
    n: int = Field(4, ge=1, le=100, strict=True, description="[-] particles of a column")
    law: Law = Field(
        "overlap", description="[-] contact law, the source's or that of DEM codes")
    inside: Inside = Field(
        "damped", description="[-] contacts within columns: with the grain's dashpot or without")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Self:
        case = self.incline  # raises RequestError for what the incline refuses
        pairs = 0.5 * self.n * (self.n - 1) * (2.0 if self.deformable else 1.0)
        if (sunk := pairs * case.static_overlap) > MOST_SUNK:
            raise ValueError(
                f"stiffness = {self.stiffness:g} N/m is too soft for columns of n = {self.n}: "
                f"under their own weight they would sink by {sunk:.3g} diameters; must be at "
                f"least {self.stiffness * sunk / MOST_SUNK:.4g} N/m ({MOST_SUNK:g} diameters)"
            )
        if self.steps_per_contact <= (fewest := self.fewest_steps_per_contact):
            raise ValueError(
                f"steps_per_contact = {self.steps_per_contact:g} is unstable at damping ratio "
                f"{self.contact.zeta:.4g}: must be greater than {fewest:.3f}"
            )
        return self

    @property
    def incline(self) -> Incline:
        """Return the incline with the same parameters."""
        return Incline(**{n: v for n, v in self if n in Incline.model_fields})

    @property
    def deformable(self) -> bool:
        """Return whether the source's law couples the contacts of a particle."""
        return self.law == "deformable" and self.n > 1

    @property
    def weight(self) -> float:
        """Return the weight of a particle [N]."""
        return self.mass * self.gravity

    @property
    def tilt(self) -> float:
        """Return the angle [rad]."""
        return math.radians(self.angle)

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the bound below which velocity Verlet is unstable.

        Where the spring of the fastest motion is ``lambda`` contacts' and its dashpot ``mu``
        contacts', Jury's criterion asks for lambda a^2 + 4 zeta mu a < 4 with a = omega dt. Both
        are 4 over columns, the largest sum of a row of D M^-1 D^T (of the contacts of a grain in a
        well: 2 + 1/2 + 1). The deformable law divides the spring by the lowest eigenvalue of T,
        tau = 2 sin^2(pi / (2 (n + 1))): D M^-1 D^T <= 4 - 2 T + 1/2, so lambda = 4.5 / tau - 2.
        """
        if self.n == 1:
            return self.incline.fewest_steps_per_contact
        spring = 4.0
        if self.deformable:
            spring = 4.5 / (2.0 * math.sin(math.pi / (2.0 * (self.n + 1))) ** 2) - 2.0
        dashpot = 8.0 * self.contact.zeta_against_full_mass / spring
        return math.pi / (math.sqrt(dashpot**2 + 4.0 / spring) - dashpot)


# ---- rest


class Loaded(NamedTuple):
    """A grain's contact and the column below: overlap [m], sinking of the top [m], energy [J]."""

    overlap: float
    sunk: float
    energy: float


def loaded(case: Columns, force: float, beta: float) -> Loaded:
    """Return the contact and the column under a ``force`` [N] at ``beta`` [rad] to the column."""
    load, k, half = force * math.cos(beta), case.stiffness, 0.5 if case.deformable else 0.0
    added = (force + half * load) / k
    top = (_top_compliance(case) * load + half * force) / k
    overlap = added + half * case.weight * math.cos(case.tilt) / k
    return Loaded(overlap, top, 0.5 * (force * added + load * top))


def sinking(case: Columns, force: float = 0.0, beta: float = 0.0) -> Floats:
    """Return how deep the particles of a column at rest lie below touching [m], (n,), top first."""
    own = np.arange(1, case.n) * case.weight * math.cos(case.tilt)
    press = np.concatenate([[force], force * math.cos(beta) + own]) / case.stiffness
    overlap = press.copy()
    if case.deformable:
        overlap[1:] += 0.5 * press[:-1]
        overlap[:-1] += 0.5 * press[1:]
    return np.concatenate([np.cumsum(overlap[:0:-1])[::-1], [0.0]])


def _top_compliance(case: Columns) -> int:
    """Return the sinking of a column's top under a load on it, in load / k."""
    return 2 * case.n - 3 if case.deformable else case.n - 1


def _on_crest(case: Columns) -> Loaded:
    return loaded(case, case.weight, case.tilt)


def crest_energy(case: Columns) -> float:
    """Return the energy [J] of a grain at rest on the first crest: its height, no springs."""
    crest = _on_crest(case)
    top = float(sinking(case)[0]) + crest.sunk
    return case.weight * (case.diameter - crest.overlap - top * math.cos(case.tilt))


def crest_place(case: Columns, well: int) -> float:
    """Return the x [m] of the crest after ``well`` wells."""
    radius = case.diameter - _on_crest(case).overlap
    return well * case.diameter - radius * math.sin(case.tilt)


def allowed_margin(case: Columns) -> float:
    """Return the margin [J] up to which a grain that moves back is trapped.

    The grain's own energy is not highest at the crest: the sinking of the top changes there as the
    load turns, by (compliance m g / k) sin(theta) per radian, which adds m g (s' cos(theta))^2 / 2
    d. Four times this is allowed.
    """
    turn = _top_compliance(case) * case.weight / case.stiffness
    turn *= math.sin(case.tilt) * math.cos(case.tilt)
    return 2.0 * case.weight / case.diameter * turn**2


# ---- starts


def start_load(case: Columns) -> tuple[float, float]:
    """Return the force [N] of the grain on the first top where a passage starts, and its beta."""
    phi = _start_angle(case)
    return case.weight * (3.0 * math.cos(phi) - 2.0), phi - case.tilt


def _start_angle(case: Columns) -> float:
    behind = math.radians(START_BEHIND_CREST)
    rate = math.sqrt(2.0 * case.gravity * (1.0 - math.cos(behind)) / case.diameter)
    return behind + case.phase * rate * case.step


def start_of(case: Columns, route: Route) -> tuple[float, float, float, float]:
    """Return x, y [m], vx, vy [m/s] at the start of a route.

    A passage has the energy of the crest, with contact and column in balance; the column starts at
    rest, as its speed is of order 1/k. Steady motion starts in a well.
    """
    d, weight = case.diameter, case.weight
    if route == "steady":
        speed = START_SPEED * math.sqrt(case.gravity * d)
        height = math.sqrt(0.75) * d - float(sinking(case)[0])
        return 0.5 * d, height, speed * math.sqrt(0.75), 0.5 * speed
    phi, (force, beta) = _start_angle(case), start_load(case)
    here, crest = loaded(case, force, beta), _on_crest(case)
    change = -3.0 * weight * math.sin(phi)  # of the force, with phi
    half = 0.5 if case.deformable else 0.0
    load_change = change * math.cos(beta) - force * math.sin(beta)
    slope, r = -(change + half * load_change) / case.stiffness, d - here.overlap
    kinetic = weight * (d - crest.overlap - r * math.cos(phi)) + crest.energy - here.energy
    kinetic += weight * (here.sunk - crest.sunk) * math.cos(case.tilt)
    omega = math.sqrt(2.0 * kinetic / case.mass / (r * r + slope * slope))
    sine, cosine = math.sin(beta), math.cos(beta)
    return (
        r * sine,
        r * cosine - float(sinking(case)[0]) - here.sunk,
        omega * (r * cosine + slope * sine),
        omega * (slope * cosine - r * sine),
    )


# ---- jobs and runs


def job_of(case: Columns, route: Route = "passage", every: int | None = None) -> Job:
    """Return the job of a run: of one particle that of the incline's row, too."""
    scene = None if case.deformable else scene_of(case, route, every)
    return Job(TEMPLATE, values_of(case, route, every), sampled=every is not None, scene=scene)


def values_of(case: Columns, route: Route, every: int | None = None) -> dict[str, Any]:
    """Return the values of the script: the incline's without friction, and the columns' own."""
    values = incline_values(case.incline, route, every)
    plain = {name: value for name, value in values.items() if name not in OF_FRICTION}
    return {**plain, "n": case.n, "law": case.law, "inside": case.inside}


TEMPLATE = Template(
    name="columns",
    variants={"": values_of(Columns(), "passage")},
    allowed={
        **{n: limits for n, limits in INCLINE_TEMPLATE.allowed.items() if n not in OF_FRICTION},
        **allowed_in(Columns),
    },
)


def scene_of(case: Columns, route: Route = "passage", every: int | None = None) -> Scene:
    """Return the grain, the first body, over columns, with a stage for each well.

    Its laws are those of the overlap law; under the deformable law the columns rest elsewhere.
    """
    d, plain = case.diameter, case.incline
    fall = case.weight * d * math.sin(case.tilt)
    floor = crest_energy(case) + allowed_margin(case)
    steps = math.ceil(case.time_limit * plain.unit_of_time / plain.step)
    eta = case.contact.dashpot(case.stiffness, plain.mass)
    law = ContactLaw(
        normal_stiffness=case.stiffness,
        damping="velocity",
        damping_coefficient=eta,
        clipped=case.contact.clipped,
    )
    elastic = {(1, 1): law.replace(damping="none")} if case.inside == "elastic" else {}
    return Scene(
        bodies=_bodies(case, route),
        law=law,
        laws=elastic,
        gravity=(case.gravity * math.sin(case.tilt), -case.gravity * math.cos(case.tilt), 0.0),
        period=(case.spheres * d, None, None),
        step=plain.step,
        steps=steps,
        every=every or steps,
        stages=tuple(
            Stage(place=crest_place(case, well), floor=floor - well * fall)
            for well in range(1, wells_of(plain, route) + 1)
        ),
        pairs=_neighbours(case) if case.n > 1 else None,
    )


def _neighbours(case: Columns) -> tuple[tuple[int, int], ...]:
    """Return the grain with each top, and the neighbours within a column."""
    places = product(range(case.spheres), range(case.n))
    return tuple((i * case.n + j if j else 0, i * case.n + j + 1) for i, j in places)


def _bodies(case: Columns, route: Route) -> tuple[Body, ...]:
    x, y, vx, vy = start_of(case, route)
    grain = Body(
        radius=0.5 * case.diameter,
        mass=case.mass,
        type=2,
        position=(x, y, 0.0),
        velocity=(vx, vy, 0.0),
    )
    particle = grain.replace(type=1, velocity=ZERO)
    depth = case.diameter * np.arange(case.n) + sinking(case)
    first = case.diameter * np.arange(case.n) + sinking(case, *start_load(case))
    bodies = [grain]
    for i in range(case.spheres):
        below = first if i == 0 and route == "passage" else depth
        for j, deep in enumerate(below):
            body = particle.replace(position=(i * case.diameter, -float(deep), 0.0))
            last = j == case.n - 1
            guided = body.replace(axes=(False, True, False))
            bodies.append(body.replace(motion="frozen") if last else guided)
    return tuple(bodies)
