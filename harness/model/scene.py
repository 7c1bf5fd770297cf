"""Scenes, in SI units: spheres, walls, laws, gravity and steps; and the motions that they make."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, model_validator

from harness.model.base import ZERO, Direction, Parameters, Positive, Vector
from harness.model.law import DAMPING, Law

Floats = NDArray[np.float64]
STAGE_COLUMNS = (
    "step", "time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s", "wz_rad_per_s",
)  # fmt: skip


Count = Annotated[int, Field(ge=1)]
Temperature = Annotated[float, Field(ge=0.0, le=1e9)]
Period = tuple[float | None, float | None, float | None]
UNBOUNDED: Period = (None, None, None)
ALL_AXES = (True, True, True)


class Body(Parameters):
    """A sphere, or a disc where its moment of inertia is that of one."""

    # fmt: off
    radius: Positive = Field(description="[m]")
    mass: Positive = Field(description="[kg]")
    inertia: Positive | None = Field(
        None, description="[kg m2] about each axis, 2/5 m r^2 unless given")
    type: Count = Field(1, description="[-] the law of a contact goes by the types of both")
    position: Vector = Field(ZERO, description="[m]")
    velocity: Vector = Field(ZERO, description="[m/s]")
    angular_velocity: Vector = Field(ZERO, description="[rad/s]")
    motion: Literal["free", "frozen", "held"] = Field(
        "free", description="[-] free: moved by forces; frozen, held: not, velocities stay, and in "
        "m* a frozen mass is infinite and a held one its own")
    axes: tuple[bool, bool, bool] = Field(
        ALL_AXES, description="[-] along which forces and gravity move a free body")
    temperature: Temperature = Field(0.0, description="[K]")
    heat_capacity: Positive = Field(1.0, description="[J/kg/K]")
    # fmt: on

    @property
    def moment_of_inertia(self) -> float:
        """Return the moment of inertia [kg m2]."""
        return 0.4 * self.mass * self.radius**2 if self.inertia is None else self.inertia


def sphere(radius: float, density: float, **more: Any) -> Body:
    """Return a solid sphere of a radius [m] and a density [kg/m3]; ``more`` are fields of Body."""
    return Body(radius=radius, mass=4.0 / 3.0 * math.pi * radius**3 * density, **more)


class Wall(Parameters):
    """A plane, a cylinder or a sphere that no force moves.

    Its place is ``point`` + velocity t + amplitude (1 - cos(frequency t)).
    """

    # fmt: off
    shape: Literal["plane", "cylinder", "sphere"] = Field("plane", description="[-]")
    point: Vector = Field(ZERO, description="[m] of a plane, of the axis, or the centre")
    direction: Direction = Field(
        (0.0, 0.0, 1.0), description="[-] normal of a plane towards the bodies, axis of a cylinder")
    radius: Positive | None = Field(None, description="[m] of a cylinder or a sphere")
    hollow: bool = Field(False, description="[-] bodies are inside the cylinder or sphere")
    type: Count = Field(1, description="[-] the law of a contact goes by the types of both")
    velocity: Vector = Field(ZERO, description="[m/s]")
    amplitude: Vector = Field(ZERO, description="[m] of the oscillation")
    frequency: float = Field(0.0, ge=0.0, description="[rad/s] of the oscillation")
    surface_velocity: Vector = Field(ZERO, description="[m/s] of a surface that slides in place")
    spin: Vector = Field(ZERO, description="[rad/s] of a cylinder or sphere about axis or centre")
    temperature: Temperature = Field(0.0, description="[K]")
    bodies: tuple[Annotated[int, Field(ge=0)], ...] | None = Field(
        None, description="[-] indices of the bodies that it acts on, all unless given"
    )
    # fmt: on

    @property
    def axis(self) -> int | None:
        """Return the axis, 0 to 2, that ``direction`` lies along, None where it is aslant."""
        axes = [axis for axis in range(3) if self.direction[axis]]
        return axes[0] if len(axes) == 1 else None

    @model_validator(mode="after")
    def _check(self) -> Self:
        is_plane = self.shape == "plane"
        if (self.radius is None) != is_plane:
            must = "must be given" if self.radius is None else "must not be given"
            raise ValueError(f"radius = {self.radius!r} m: {must} with shape = {self.shape!r}")
        for name in ("hollow", "spin"):
            value = getattr(self, name)
            if is_plane and value not in (False, ZERO):
                raise ValueError(
                    f"{name} = {value!r}: must not be given for a plane (surface_velocity is)"
                )
        return self


class Segment(Parameters):
    """A piece of prescribed motion: velocities of all bodies for so many steps."""

    steps: Count = Field(description="[-]")
    velocities: tuple[Vector, ...] = Field(description="[m/s]")
    angular_velocities: tuple[Vector, ...] = Field(description="[rad/s]")


class Stage(Parameters):
    """A stage of a run that is looked at each :data:`LOOK` steps, by the first body.

    At the first look with x beyond ``place`` the next stage begins; after the last the run is over.
    At one with velocity along -x and a mechanical energy below ``floor`` the run is over too. The
    energy m (v^2 / 2 - g . x) has no springs in it, and is zero for a body at rest at the origin.
    """

    # fmt: off
    place: float = Field(description="[m]")
    floor: float = Field(description="[J]")
    # fmt: on


LOOK = 50  # steps between two looks at the first body


class PairLaw(NamedTuple):
    """The law of contacts of two types, the smaller one first."""

    types: tuple[int, int]
    law: Law


def _pair_laws(value: Any) -> Any:
    if not isinstance(value, Mapping):
        return value
    rows = [PairLaw((min(pair), max(pair)), law) for pair, law in value.items()]
    return tuple(sorted(rows, key=lambda row: row.types))


PairLaws = Annotated[tuple[PairLaw, ...], BeforeValidator(_pair_laws)]


class Scene(Parameters):
    """Bodies and walls, the laws of their contacts, and the steps to be taken.

    Every pair of bodies interacts unless neither is free or ``pairs`` names others; every free
    body interacts with every wall whose ``bodies`` do not leave it out. With ``segments`` the
    motion is prescribed: forces move nothing, all bodies count as held. Raise RequestError for a
    step at which a contact is not stable, and for an impact that never ends.
    """

    # fmt: off
    bodies: tuple[Body, ...] = Field(min_length=1, description="[-]")
    walls: tuple[Wall, ...] = Field((), description="[-]")
    law: Law = Field(Law(), description="[-] of every contact that ``laws`` does not name")
    laws: PairLaws = Field((), description="[-] by pair of types: {(1, 2): Law(...)}")
    gravity: Vector = Field(ZERO, description="[m/s2]")
    drag: float = Field(0.0, ge=0.0, description="[kg/s] force -drag v on free bodies")
    period: Period = Field(UNBOUNDED, description="[m] along each axis, None without one")
    step: Positive = Field(description="[s]")
    steps: Count = Field(description="[-]")
    every: Count = Field(1, description="[-] steps between samples; the start is one")
    segments: tuple[Segment, ...] = Field((), description="[-] of prescribed motion")
    setups: tuple[int, ...] = Field(
        (), description="[step] at which a run begins anew: forces by the velocities of the step; "
        "0: once more before the first step")
    stages: tuple[Stage, ...] = Field(
        (), description="[-] with which the run may be over before ``steps``")
    pairs: tuple[tuple[int, int], ...] | None = Field(
        None, description="[-] indices of bodies that can touch, all unless given")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Self:
        count = len(self.bodies)
        if not self.segments and all(body.motion != "free" for body in self.bodies):
            raise ValueError("bodies: at least one must be free where no segment moves them")
        for segment in self.segments:
            if not len(segment.velocities) == len(segment.angular_velocities) == count:
                raise ValueError(f"segments: each needs velocities of {count} bodies")
        moved = sum(segment.steps for segment in self.segments)
        if self.segments and moved != self.steps:
            raise ValueError(f"steps = {self.steps}: must be {moved}, the sum of the segments'")
        if any(not 0 <= i < count or not 0 <= j < count or i == j for i, j in self.pairs or ()):
            raise ValueError(f"pairs: must be two different indices from 0 to {count - 1}")
        laws = set(self.all_laws)
        if len(laws) > 1 and any(law.normal == "mdr" for law in laws):
            raise ValueError("laws: must be one with normal = 'mdr', whose bodies keep its state")
        self._check_walls()
        if not self.segments:
            largest, spring = self.largest_step
            if self.step > largest:
                raise ValueError(
                    f"step = {self.step!r} s: must be at most {largest:.6g} s, larger ones do not "
                    f"resolve {spring}"
                )
            self._check_impacts_end()
        return self

    def _check_walls(self) -> None:
        largest = max(body.radius for body in self.bodies)
        for wall in self.walls:
            if max(wall.bodies or (0,)) >= len(self.bodies):
                last = len(self.bodies) - 1
                raise ValueError(f"bodies = {wall.bodies!r}: must be indices from 0 to {last}")
            if wall.hollow and (wall.radius or 0.0) <= largest:
                raise ValueError(
                    f"radius = {wall.radius!r} m: must be greater than {largest:.12g} m, that of "
                    "the bodies inside"
                )
        for length in self.period:
            if length is not None and not length >= 0.999 * 4.0 * largest:
                raise ValueError(
                    f"period = {length!r} m: must be at least {4.0 * largest:.12g} m, twice the "
                    "largest diameter: a body must meet one image of another"
                )

    def _check_impacts_end(self) -> None:
        for law, first, second in self._partners():
            if law.normal != "hooke" or law.clipped or DAMPING[law.damping].powers[1]:
                continue
            critical = 2.0 * math.sqrt((law.normal_stiffness or 0.0) * moving_mass(first, second))
            ratio = law.dashpot(effective_mass(first, second), first.radius, 0.0) / critical
            if ratio >= 1.0 and not any(self.gravity):
                name = "restitution" if law.restitution is not None else "damping_coefficient"
                value = getattr(law, name)
                raise ValueError(
                    f"{name} = {value!r}: must be below {value / ratio:.6g}, critical damping, or "
                    "clipped = True: the contact never ends"
                )

    @property
    def all_laws(self) -> tuple[Law, ...]:
        """Return the law of pairs without their own, and those of ``laws``."""
        return (self.law, *(row.law for row in self.laws))

    def law_of(self, first: int, second: int) -> Law:
        """Return the law of a contact of two types."""
        types = (min(first, second), max(first, second))
        return next((row.law for row in self.laws if row.types == types), self.law)

    @property
    def duration(self) -> float:
        """Return the time simulated [s]."""
        return self.step * self.steps

    @property
    def largest_step(self) -> tuple[float, str]:
        """Return the largest step [s] at which each contact, alone, is stable; and which bounds it.

        v+ = v - h (c v + w^2 x), x+ = x + h v+ is stable for c h + (w h)^2 / 2 < 2 (Jury's
        criterion), with the rates of each spring and its dashpot at the largest overlap of an
        elastic impact at the speeds of the start, or of a body at rest under its weight.
        """
        steps = [(math.inf, "")]
        for law, first, second in self._partners():
            mass, radius = moving_mass(first, second), effective_radius(first, second)
            rates = _rates(law, first, second, self._overlap(law, mass, radius))
            steps += [
                (4.0 / (c + math.sqrt(c * c + 4.0 * square)), f"{name} = {getattr(law, name)!r}")
                for name, square, c in rates
                if square or c
            ]
        return min(steps)

    def _overlap(self, law: Law, mass: float, radius: float) -> float:
        speed = max(math.hypot(*b.velocity) for b in self.bodies)
        speed += max((math.hypot(*w.velocity) for w in self.walls), default=0.0)
        weight = mass * math.hypot(*self.gravity)
        if law.normal == "hooke":
            k = law.normal_stiffness or 1.0
            return max(speed * math.sqrt(mass / k), weight / k)
        coefficient = law.stiffness(radius, 1.0) / 1.5  # F = K d^(3/2)
        impact = (1.25 * mass * speed**2 / coefficient) ** 0.4
        return float(max(impact, (weight / coefficient) ** (2.0 / 3.0)))

    def _partners(self) -> Iterator[tuple[Law, Body, Body | None]]:
        """Yield each law with two bodies that it acts between, one of each kind; None is a wall."""
        keys = [(b.radius, b.mass, b.inertia, b.type, b.motion) for b in self.bodies]
        kinds = dict(zip(keys, self.bodies, strict=True))
        for key, first in kinds.items():
            if first.motion != "free":
                continue
            for other, second in kinds.items():
                if other != key or keys.count(key) > 1:
                    yield self.law_of(first.type, second.type), first, second
            for wall in {wall.type: wall for wall in self.walls}.values():
                yield self.law_of(first.type, wall.type), first, None


@dataclass(frozen=True)
class Motion:
    """Samples of a scene's bodies, in SI units.

    ``time`` [s] has the shape (M,), ``position`` [m], ``velocity`` [m/s], ``angular_velocity``
    [rad/s], ``force`` [N] and ``torque`` [N m] have (M, N, 3), in the order of the bodies. Forces
    are those of contacts and drag, without weight. ``temperature`` [K] (M, N) is None where no
    heat flows. An engine that writes no forces leaves NaN. ``stages`` (K, 7) are the start and the
    end of each stage of a scene with stages, None of another: :data:`STAGE_COLUMNS` of the first
    body. The samples of a run that is over early end before it is.
    """

    time: Floats
    position: Floats
    velocity: Floats
    angular_velocity: Floats
    force: Floats
    torque: Floats
    temperature: Floats | None = None
    stages: Floats | None = None

    def __len__(self) -> int:
        return len(self.time)


def effective_mass(first: Body, second: Body | None) -> float:
    """Return m* [kg] of a free body and another or a wall (None); frozen masses are infinite."""
    if second is None or second.motion == "frozen":
        return first.mass
    return first.mass * second.mass / (first.mass + second.mass)


def moving_mass(first: Body, second: Body | None) -> float:
    """Return the reduced mass [kg] of a free body and another or a wall (None), of those that move.

    Unlike m* it does not count a held body, whose mass enters dashpots alone.
    """
    if second is None or second.motion != "free":
        return first.mass
    return effective_mass(first, second)


def effective_radius(first: Body, second: Body | None) -> float:
    """Return R* [m] of two bodies, or of one on a plane (None)."""
    if second is None:
        return first.radius
    return first.radius * second.radius / (first.radius + second.radius)


def _rates(
    law: Law, first: Body, second: Body | None, overlap: float
) -> Iterator[tuple[str, float, float]]:
    """Yield each spring's coefficient, its w^2 [1/s2] and the rate of its dashpot [1/s]."""
    radius, mass = effective_radius(first, second), moving_mass(first, second)
    eta = law.dashpot(effective_mass(first, second), radius, overlap)
    free = [body for body in (first, second) if body is not None and body.motion == "free"]
    turning = sum(1.0 / body.moment_of_inertia for body in free)
    slipping = 1.0 / mass + sum(b.radius**2 / b.moment_of_inertia for b in free)
    names = ("normal_stiffness", "normal_modulus", "youngs_modulus")
    name = next(n for n in names if getattr(law, n) is not None)
    yield name, law.stiffness(radius, overlap) / mass, eta / mass
    if law.has_spring:
        shear = law.tangential_modulus or 8.0 * (law.moduli[1] if law.moduli else 0.0)
        k = law.tangential_stiffness or math.sqrt(radius * overlap) * shear
        name = "tangential_stiffness" if law.tangential_stiffness else "tangential"
        yield name, k * slipping, (law.tangential_damping or 0.0) * eta * slipping
    for part, factor in (("rolling", radius**2 * turning), ("twisting", turning)):
        k, drag = getattr(law, f"{part}_stiffness") or 0.0, getattr(law, f"{part}_damping") or 0.0
        yield f"{part}_stiffness", k * factor, drag * factor
