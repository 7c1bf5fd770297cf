"""Vectors of three numbers for compiled code: tuples, so that nothing is allocated."""

from __future__ import annotations

import math

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
