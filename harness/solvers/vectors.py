"""Vectors of compiled steps: tuples of three numbers, which stay in registers."""

from __future__ import annotations

import math

from harness.model.base import Vector
from harness.model.motion import Floats
from harness.solvers.kernels import kernel


@kernel
def vector(values: Floats) -> Vector:
    """Return an array (3,) as a vector."""
    return (values[0], values[1], values[2])


@kernel
def store(place: Floats, values: Vector) -> None:
    """Put a vector in an array (3,)."""
    place[0], place[1], place[2] = values


@kernel
def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(factor: float, a: Vector) -> Vector:
    """Return a vector times a factor."""
    return (factor * a[0], factor * a[1], factor * a[2])


@kernel
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def size(a: Vector) -> float:
    """Return the length of a vector."""
    return math.sqrt(dot(a, a))


@kernel
def project(a: Vector, n: Vector) -> Vector:
    """Return the part of a vector across the unit vector ``n``."""
    return minus(a, scale(dot(a, n), n))
