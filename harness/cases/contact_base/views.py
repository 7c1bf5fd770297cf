"""One contact scene seen in other ways: turned, mirrored, from a moving frame, in other units.

Each view makes a scene of a scene, and gives a motion of the second back as one of the first: by
the symmetries of mechanics, and of every contact law, both are the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import starmap

import numpy as np

from harness.cases.contact_base.motion import Array, Motion
from harness.parameters.contact_law import ContactLaw
from harness.parameters.contact_scene import ZERO, Body, ContactScene, Plane, Segment, Vector

Axes = tuple[Vector, Vector, Vector]

SAME: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

DIMENSIONS = {
    "normal_stiffness": (0, 1, -2),
    "youngs_modulus": (-1, 1, -2),
    "partner_youngs_modulus": (-1, 1, -2),
    "surface_energy": (0, 1, -2),
    "yield_stress": (-1, 1, -2),
    "tangential_stiffness": (0, 1, -2),
    "rolling_stiffness": (0, 1, -2),
    "rolling_damping": (0, 1, -1),
    "twisting_stiffness": (2, 1, -2),
    "twisting_damping": (2, 1, -1),
    "twisting_friction": (1, 0, 0),
}
"""Powers of length, mass and time in the coefficients of a law; the others are pure numbers."""

DAMPINGS = {"velocity": (0, 1, -1), "mass_velocity": (0, 0, -1), "viscoelastic": (-1, 0, -1)}
"""Likewise of the damping coefficient, by its rule."""


@dataclass(frozen=True)
class View:
    """Axes and a velocity [m/s]: what was at x is at M x + t v, M orthogonal.

    Angular velocities and torques are axial: a mirror turns their sign.
    """

    matrix: Axes = SAME
    velocity: Vector = ZERO

    def scene(self, scene: ContactScene) -> ContactScene:
        """Return a scene as it is seen."""
        return replace(
            scene,
            bodies=tuple(map(self._body, scene.bodies)),
            planes=tuple(map(self._plane, scene.planes)),
            gravity=self._polar(scene.gravity),
            segments=tuple(map(self._segment, scene.segments)),
        )

    def back(self, motion: Motion) -> Motion:
        """Return the motion of the scene that was looked at."""
        m = np.array(self.matrix)
        sign = np.linalg.det(m).round()
        v = np.array(self.velocity)
        return Motion(
            motion.time,
            (motion.position - motion.time[:, None, None] * v) @ m,
            (motion.velocity - v) @ m,
            sign * motion.omega @ m,
            motion.force @ m,
            sign * motion.torque @ m,
        )

    def _body(self, body: Body) -> Body:
        return replace(
            body,
            position=self._polar(body.position),
            velocity=self._seen(body.velocity),
            omega=self._axial(body.omega),
        )

    def _plane(self, plane: Plane) -> Plane:
        return Plane(
            self._polar(plane.point), self._polar(plane.normal), self._seen(plane.velocity)
        )

    def _segment(self, piece: Segment) -> Segment:
        return Segment(
            piece.steps,
            tuple(map(self._seen, piece.velocities)),
            tuple(map(self._axial, piece.omegas)),
        )

    def _polar(self, vector: Vector) -> Vector:
        return _vector(np.array(self.matrix) @ vector)

    def _seen(self, velocity: Vector) -> Vector:
        return _vector(np.array(self._polar(velocity)) + self.velocity)

    def _axial(self, vector: Vector) -> Vector:
        return _vector(np.linalg.det(self.matrix).round() * np.array(self._polar(vector)))


@dataclass(frozen=True)
class Units:
    """Units of length, mass and time: the numbers of a scene in them, as if they were SI's."""

    length: float
    mass: float
    time: float

    def scene(self, scene: ContactScene) -> ContactScene:
        """Return a scene in these units."""
        x, v, w = self._factors()[:3]
        return replace(
            scene,
            bodies=tuple(
                replace(
                    body,
                    radius=body.radius * x,
                    mass=body.mass * self.mass,
                    position=scaled(body.position, x),
                    velocity=scaled(body.velocity, v),
                    omega=scaled(body.omega, w),
                )
                for body in scene.bodies
            ),
            planes=tuple(
                Plane(scaled(plane.point, x), plane.normal, scaled(plane.velocity, v))
                for plane in scene.planes
            ),
            law=self._law(scene.law),
            step=scene.step * self.time,
            gravity=scaled(scene.gravity, v / self.time),
            segments=tuple(
                Segment(
                    piece.steps,
                    tuple(scaled(one, v) for one in piece.velocities),
                    tuple(scaled(one, w) for one in piece.omegas),
                )
                for piece in scene.segments
            ),
        )

    def back(self, motion: Motion) -> Motion:
        """Return a motion in these units in SI units."""
        parts = (motion.position, motion.velocity, motion.omega, motion.force, motion.torque)
        scaled = starmap(np.divide, zip(parts, self._factors(), strict=True))
        return Motion(motion.time / self.time, *scaled)

    def _factors(self) -> tuple[float, ...]:
        """Return those of positions, velocities, angular velocities, forces and torques."""
        x, m, t = self.length, self.mass, self.time
        return (x, x / t, 1.0 / t, m * x / t / t, m * x * x / t / t)

    def _law(self, law: ContactLaw) -> ContactLaw:
        dimensions = dict(DIMENSIONS)
        if law.damping in DAMPINGS:
            dimensions["damping_coefficient"] = DAMPINGS[law.damping]
        told = law.model_dump(exclude_none=True)
        units = np.array([self.length, self.mass, self.time])
        for name in told.keys() & dimensions.keys():
            told[name] *= float(np.prod(units ** np.array(dimensions[name], dtype=float)))
        return ContactLaw(**told)


class Renumbered:
    """The bodies in the other order."""

    def scene(self, scene: ContactScene) -> ContactScene:
        """Return a scene with the last body first."""
        segments = tuple(
            Segment(piece.steps, piece.velocities[::-1], piece.omegas[::-1])
            for piece in scene.segments
        )
        law = _exchanged(scene.law)
        return replace(scene, bodies=scene.bodies[::-1], law=law, segments=segments)

    def back(self, motion: Motion) -> Motion:
        """Return a motion in the first order."""
        return Motion(motion.time, *(getattr(motion, name)[:, ::-1] for name in PARTS))


def _exchanged(law: ContactLaw) -> ContactLaw:
    """Return a law with the material of the second body first."""
    if not (law.two_materials and law.materials):
        return law
    (young, poisson), (other, its) = law.materials
    return law.replace(
        youngs_modulus=other,
        poisson_ratio=its,
        partner_youngs_modulus=young,
        partner_poisson_ratio=poisson,
    )


PARTS = ("position", "velocity", "omega", "force", "torque")


def turned_back(scene: ContactScene, motion: Motion) -> ContactScene:
    """Return the scene that begins where a motion ends, with all velocities reversed."""
    bodies = tuple(
        replace(
            body,
            position=_vector(motion.position[-1, index]),
            velocity=_vector(-motion.velocity[-1, index]),
            omega=_vector(-motion.omega[-1, index]),
        )
        for index, body in enumerate(scene.bodies)
    )
    return replace(scene, bodies=bodies)


def run_backwards(motion: Motion) -> Motion:
    """Return a motion as it is in the film that is run backwards."""
    return Motion(
        motion.time[-1] - motion.time[::-1],
        motion.position[::-1],
        -motion.velocity[::-1],
        -motion.omega[::-1],
        motion.force[::-1],
        motion.torque[::-1],
    )


def scaled(vector: Vector, factor: float) -> Vector:
    """Return a vector times a factor."""
    return (vector[0] * factor, vector[1] * factor, vector[2] * factor)


def axes_about(up: Vector) -> Axes:
    """Return the matrix of a rotation that brings z to a direction."""
    z = np.array(up) / np.linalg.norm(up)
    x = np.cross(z, (0.8, -0.5, 0.33))
    x /= np.linalg.norm(x)
    a, b, c = map(_vector, np.column_stack([x, np.cross(z, x), z]))
    return (a, b, c)


def _vector(parts: Array) -> Vector:
    x, y, z = (float(part) for part in parts)
    return (x, y, z)
