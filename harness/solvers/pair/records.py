"""Records in which compiled code reads bodies, planes, contacts and their law, and its vectors.

A vector is a tuple of three numbers, so that nothing is allocated.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.compiled import Function, jit

Vector = tuple[float, float, float]


def compiled(function: Function) -> Function:
    """Compile ``function`` at its first call, in IEEE arithmetic, keeping its Python type.

    Other threads go on meanwhile.
    """
    return jit(function, error_model="numpy", nogil=True)


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def length(a: Vector) -> float:
    """Return the magnitude."""
    return math.sqrt(dot(a, a))


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled
def scaled(factor: float, a: Vector) -> Vector:
    """Return factor * a."""
    return (factor * a[0], factor * a[1], factor * a[2])


@compiled
def plus(a: Vector, factor: float, b: Vector) -> Vector:
    """Return a + factor * b."""
    return (a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2])


@compiled
def across(a: Vector, unit: Vector) -> Vector:
    """Return the part of a that is perpendicular to a unit vector."""
    return plus(a, -dot(a, unit), unit)


@compiled
def direction(a: Vector) -> Vector:
    """Return a with length 1, and a zero vector as it is."""
    size = length(a)
    return scaled(1.0 / size, a) if size > 0.0 else a


Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# ---- records

BODY = 9
"""Numbers of a body in the state: position, velocity, angular velocity."""

CONTACT = 10
"""Numbers of a contact: the overlap, then the springs: tangential, rolling, twisting."""

TANGENTIAL, ROLLING, TWISTING = range(3)
TWIST_NONE, TWIST_SDS, TWIST_MARSHALL = range(3)


LAW = np.dtype(
    [
        ("normal", "i8"),
        ("stiffness", "f8"),
        ("surface", "f8"),
        ("fold", "?"),
        ("wall_magnified", "?"),
        ("yields", "?"),  # of mdr, as the next five
        ("yield_stress", "f8"),
        ("bulk", "?"),
        ("bulk_modulus", "f8"),
        ("shear_modulus", "f8"),
        ("poisson", "f8"),
        ("damping", "i8"),
        ("damping_coefficient", "f8"),
        ("clipped", "?"),
        ("tangential", "?"),
        ("tangential_stiffness", "f8"),
        ("by_radius", "?"),  # Mindlin: the stiffness is that times the contact radius
        ("hertzian", "?"),  # its contact radius is sqrt(R* overlap), whatever the normal force
        ("by_force", "?"),  # the state is the force over the coefficient, not a displacement
        ("rescaled", "?"),
        ("tangential_damping", "f8"),
        ("friction", "f8"),
        ("pull_loads", "?"),  # what attraction adds to the load of Coulomb's limit
        ("rolling", "?"),
        ("rolling_coefficients", "f8", 3),
        ("twisting", "i8"),
        ("twisting_coefficients", "f8", 3),
        ("marshall_by_radius", "?"),
        ("cut_back", "?"),
        ("damping_in_cap", "i8"),
        ("torque_lever", "i8"),
        ("velocity_lever", "i8"),
        ("wall_lever", "i8"),
        ("levered", "?"),  # rolling and twisting at a wall
        ("mean_spin", "?"),
        ("turns", "?"),  # springs turn with the normal
    ],
    align=True,
)
"""The law and its rules as numbers."""

OF_FRICTION = ("hertzian", "pull_loads", "cut_back", "damping_in_cap", "torque_lever",
               "velocity_lever", "wall_lever", "mean_spin", "turns")  # fmt: skip
"""Fields that nothing asks for without friction."""

OF_MDR = ("yields", "yield_stress", "bulk", "bulk_modulus", "shear_modulus", "poisson")
"""Fields that nothing asks for but mdr with yield or a bulk response."""

BODIES = np.dtype(
    [("radius", "f8"), ("inverse_mass", "f8"), ("inverse_inertia", "f8"), ("gravity", "f8", 3)]
)
"""Inverse mass and inertia, and gravity, are 0 for a body that forces do not move."""

PLANES = np.dtype([("point", "f8", 3), ("normal", "f8", 3)])

CONTACTS = np.dtype(
    [
        ("first", "i8"),
        ("second", "i8"),
        ("curvature", "f8"),  # R*
        ("mass", "f8"),  # m*
        ("overlap", "f8"),  # of the contact while it lasts, set as it begins
        ("speed", "f8"),
        ("onset", "f8"),  # of mdr: depth in a flat at which it yields
        ("swells", "f8"),  # likewise, from which on its radius grows
        ("stage", "i8"),  # elastic, yields, swells
        ("largest", "f8"),  # overlap from which it opens, 0 until then
        ("last", "f8"),  # overlap at which it ends
        ("least", "f8"),  # contact radius at which it ends where it sticks
        ("first_radius", "f8"),
        ("second_radius", "f8"),  # of the first again at a wall
        ("factor", "f8"),  # on the elastic stiffness
    ]
)
"""Of two bodies; the second is -1 - p where it is plane p."""

Records = Any
"""A NumPy record array of one of these types, or a record: compiled code takes a pointer to it."""


class System(NamedTuple):
    """Bodies, planes, contacts and the law between them, as records."""

    bodies: Records
    planes: Records
    contacts: Records
    law: Records
