"""A few spheres and planes that meet by one contact law: what is set up, in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.errors import RequestError
from harness.parameters.law import Contact, ContactLaw

if TYPE_CHECKING:
    from harness.parameters.plane_scene import Columns, Stage

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Body:
    """A sphere: radius [m], mass [kg], centre [m], velocity [m/s], angular velocity [rad/s].

    A frozen one neither moves nor turns by forces; its velocities stay as they are, and as a
    partner in contact its mass is infinite. It may be hollow, with the others inside: a spherical
    wall, of negative radius.
    """

    radius: float
    mass: float
    position: Vector
    velocity: Vector = ZERO
    omega: Vector = ZERO
    frozen: bool = False

    def __post_init__(self) -> None:
        hollow = self.frozen and self.radius < 0.0
        for name, value in (
            ("radius", abs(self.radius) if hollow else self.radius),
            ("mass", self.mass),
        ):
            if not (math.isfinite(value) and value > 0.0):
                raise RequestError(f"{name} = {value!r}: must be a finite number greater than 0")
        for name in ("position", "velocity", "omega"):
            _finite(name, getattr(self, name))

    @property
    def inertia(self) -> float:
        """Return 2/5 m r^2 [kg m2]."""
        return 0.4 * self.mass * self.radius**2


@dataclass(frozen=True)
class Plane:
    """A wall: a point of it [m], its normal into the room, of any length, and its velocity [m/s].

    The point is that of the start.
    """

    point: Vector
    normal: Vector
    velocity: Vector = ZERO

    def __post_init__(self) -> None:
        _finite("point", self.point)
        _finite("normal", self.normal)
        _finite("velocity", self.velocity)
        if not any(self.normal):
            raise RequestError("normal = (0, 0, 0): a plane needs a direction")

    @property
    def direction(self) -> Vector:
        """Return the normal with length 1."""
        length = math.hypot(*self.normal)
        x, y, z = self.normal
        return (x / length, y / length, z / length)


@dataclass(frozen=True)
class Segment:
    """A piece of prescribed motion: how many steps, velocity and omega of every body in it."""

    steps: int
    velocities: tuple[Vector, ...]
    omegas: tuple[Vector, ...]


@dataclass(frozen=True)
class ContactScene:
    """Bodies, planes, the law of every contact, gravity [m/s2], step [s], steps, sampling.

    Every pair interacts, but two frozen bodies. With ``segments`` the motion is prescribed,
    forces move nothing, and ``steps`` must be the sum of the segments' steps.

    In the plane of x and y (:func:`in_plane`) ``gravity`` has two components, and there may be
    more. ``contact`` is what the law follows from, for codes that are told a ratio or a
    restitution. ``period`` [m] is that of x, None without one. ``every`` may be 0: then the start,
    the end and the ends of ``stages`` are wanted. ``decided`` tells from the table so far whether
    the run may end earlier.

    Raise RequestError for a scene that is none.
    """

    bodies: tuple[Body, ...]
    planes: tuple[Plane, ...]
    law: ContactLaw
    step: float
    steps: int
    every: int = 1
    gravity: tuple[float, ...] = ZERO
    segments: tuple[Segment, ...] = field(default=())
    contact: Contact = field(default=Contact(damping_ratio=0.0), repr=False)
    period: float | None = None
    stages: tuple[Stage, ...] = ()
    forces: bool = False
    columns: Columns | None = None
    decided: Callable[[Mapping[str, Floats]], bool] | None = None

    def __post_init__(self) -> None:
        if not any(not body.frozen for body in self.bodies) and not self.segments:
            raise RequestError("bodies: at least one must be free to move")
        if not (math.isfinite(self.step) and self.step > 0.0):
            raise RequestError(f"step = {self.step!r} s: must be a finite number greater than 0")
        for name, least in (("steps", 1), ("every", 1 if len(self.gravity) == 3 else 0)):
            if getattr(self, name) < least:
                raise RequestError(f"{name} = {getattr(self, name)}: must be at least {least}")
        _finite("gravity", (*self.gravity, 0.0)[:3])
        if self.law.two_materials and len(self.bodies) + bool(self.planes) != 2:
            raise RequestError(
                "partner_youngs_modulus, partner_poisson_ratio: need two bodies, or one and planes"
            )
        for segment in self.segments:
            if not len(segment.velocities) == len(segment.omegas) == len(self.bodies):
                raise RequestError(
                    f"segments: each needs a velocity and an omega for {len(self.bodies)} bodies"
                )
        moved = sum(segment.steps for segment in self.segments)
        if self.segments and moved != self.steps:
            raise RequestError(f"steps = {self.steps}: must be {moved}, the sum of the segments'")

    @property
    def duration(self) -> float:
        """Return the time simulated [s]."""
        return self.step * self.steps

    # In the plane, as engines take it: spheres (N, 2) and (N,), spring and dashpot, in SI units.
    position = cached_property(lambda self: np.array([body.position[:2] for body in self.bodies]))
    velocity = cached_property(lambda self: np.array([body.velocity[:2] for body in self.bodies]))
    mass = cached_property(lambda self: np.array([body.mass for body in self.bodies]))
    diameter = cached_property(lambda self: np.array([2.0 * body.radius for body in self.bodies]))
    fixed = cached_property(lambda self: np.array([body.frozen for body in self.bodies]))
    stiffness = property(lambda self: self.law.normal_stiffness)
    damping_ratio = property(lambda self: self.contact.zeta)
    tail = property(lambda self: self.contact.tail)
    effective_mass = property(lambda self: self.contact.effective_mass)

    def with_spheres(self, **arrays: ArrayLike) -> Self:
        """Return a copy with other arrays of :func:`spheres`, by name."""
        names = ("position", "velocity", "mass", "diameter", "fixed")
        current = {name: getattr(self, name) for name in names}
        return replace(self, bodies=spheres(**{**current, **arrays}))


def spheres(
    position: ArrayLike, velocity: ArrayLike, mass: ArrayLike, diameter: ArrayLike, fixed: ArrayLike
) -> tuple[Body, ...]:
    """Return N spheres in the plane, of arrays (N, 2) and (N,) in SI units."""
    rows = (np.asarray(array).tolist() for array in (position, velocity, mass, diameter, fixed))
    return tuple(
        Body(0.5 * d, m, (*x, 0.0), (*v, 0.0), frozen=held)
        for x, v, m, d, held in zip(*rows, strict=True)
    )


def in_plane(
    bodies: tuple[Body, ...], contact: Contact, stiffness: float, *, every: int | None, **more: Any
) -> ContactScene:
    """Return a scene of equal spheres in the plane without friction.

    Samples every so many steps, None: of the start, the end and the ends of stages. ``more`` are
    other fields of the scene.
    """
    if every is not None and every < 1:
        raise RequestError(f"every = {every}: must be at least 1 step")
    law = contact.law(stiffness, bodies[0].mass)
    return ContactScene(bodies, (), law, contact=contact, every=every or 0, **more)


def sphere_mass(radius: float, density: float) -> float:
    """Return 4/3 pi r^3 rho [kg]."""
    return 4.0 / 3.0 * math.pi * radius**3 * density


def _finite(name: str, vector: tuple[float, ...]) -> None:
    if len(vector) != 3 or not all(math.isfinite(value) for value in vector):
        raise RequestError(f"{name} = {vector!r}: must be three finite numbers")
