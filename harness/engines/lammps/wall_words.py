"""Walls in the words of LAMMPS: fix wall/gran where a style has them, else regions."""

from __future__ import annotations

import math
from collections.abc import Iterator

from harness.errors import Unsupported
from harness.model.base import ZERO, Vector, unit_vector
from harness.model.law import Law
from harness.model.scene import Wall

AXES = "xyz"


def wall_lines(name: str, group: str, wall: Wall, words: str, law: Law) -> Iterator[str]:
    """Yield the lines of a wall that touches a group of bodies by a law, in ``words``.

    Raise Unsupported for a wall that neither a style nor a region states.
    """
    if wall.bodies is not None:
        raise Unsupported("walls act on all bodies here")
    warm = f" temperature {wall.temperature!r}" if law.heat != "none" else ""
    style = None if law.normal == "mdr" else _style(wall)
    if style is not None:
        yield f"fix {name} {group} wall/gran {words} {style}{warm}"
        return
    yield from _region(name, wall)
    yield f"fix {name} {group} wall/gran/region {words} region {name}{warm}"


def _oscillates(wall: Wall) -> bool:
    return wall.frequency > 0.0 and any(wall.amplitude)


def _style(wall: Wall) -> str | None:
    """Return a wall in the words of fix wall/gran, None where it needs a region."""
    if wall.shape == "plane":
        return _plane_style(wall)
    central = wall.hollow and wall.point[:2] == (0.0, 0.0) and _axis(wall.direction) == 2
    if wall.shape == "cylinder" and central and not _oscillates(wall):
        return _cylinder_style(wall)
    return None


def _plane_style(wall: Wall) -> str | None:
    axis = _axis(wall.direction)
    sliding = tuple(a + b for a, b in zip(wall.velocity, wall.surface_velocity, strict=True))
    if axis is None or wall.velocity[axis] or wall.surface_velocity[axis]:
        return None
    height = repr(wall.point[axis])
    places = f"{height} NULL" if wall.direction[axis] > 0.0 else f"NULL {height}"
    words = f"{AXES[axis]}plane {places}"
    if _oscillates(wall):
        swung = [k for k in range(3) if wall.amplitude[k]]
        if len(swung) > 1 or any(sliding):
            raise Unsupported("walls oscillate along one axis, and do not slide at the same time")
        period = 2.0 * math.pi / wall.frequency
        return f"{words} wiggle {AXES[swung[0]]} {wall.amplitude[swung[0]]!r} {period!r}"
    slid = [k for k in range(3) if sliding[k]]
    if len(slid) > 1:
        return None
    return f"{words} shear {AXES[slid[0]]} {sliding[slid[0]]!r}" if slid else words


def _cylinder_style(wall: Wall) -> str | None:
    along = wall.velocity[2] + wall.surface_velocity[2]
    across = (*wall.velocity[:2], *wall.surface_velocity[:2], *wall.spin[:2])
    if any(across) or (along and wall.spin[2]):
        return None
    words, radius = f"zcylinder {wall.radius!r}", wall.radius or 0.0
    if wall.spin[2]:
        return f"{words} shear x {-wall.spin[2] * radius!r}"
    return f"{words} shear z {along!r}" if along else words


def _region(name: str, wall: Wall) -> Iterator[str]:
    """Yield a region and, where it moves, the variables of its motion."""
    if _oscillates(wall):
        raise Unsupported("walls of mdr, curved and tilted ones do not oscillate")
    if wall.surface_velocity != ZERO:
        raise Unsupported("walls of mdr, curved and tilted ones do not slide in place")
    moves = []
    if any(wall.velocity):
        for axis, speed in zip(AXES, wall.velocity, strict=True):
            yield f"variable {name}_{axis} equal {speed!r}*step*dt"
        moves.append("move " + " ".join(f"v_{name}_{axis}" for axis in AXES))
    if any(wall.spin):
        yield f"variable {name}_turn equal {_turning(wall)!r}*step*dt"
        # of length 1: LAMMPS multiplies the velocity of the surface by the length of the axis
        about = wall.direction if wall.shape == "cylinder" else unit_vector(wall.spin)
        moves.append(f"rotate v_{name}_turn {_numbers(wall.point)} {_numbers(about)}")
    side = "" if wall.shape == "plane" else f" side {'in' if wall.hollow else 'out'}"
    yield " ".join([f"region {name} {_shape(wall)}{side} units box", *moves])


def _shape(wall: Wall) -> str:
    if wall.shape == "plane":
        return f"plane {_numbers(wall.point)} {_numbers(wall.direction)}"
    if wall.shape == "sphere":
        return f"sphere {_numbers(wall.point)} {wall.radius!r}"
    axis = _axis(wall.direction)
    if axis is None:
        raise Unsupported("cylinders lie along x, y or z")
    across = [x for k, x in enumerate(wall.point) if k != axis]
    return f"cylinder {AXES[axis]} {_numbers(across)} {wall.radius!r} INF INF"


def _turning(wall: Wall) -> float:
    """Return the angular velocity of a region [rad/s], about its axis where it has one."""
    rate = math.hypot(*wall.spin)
    if wall.shape == "sphere":
        return rate
    along = sum(a * b for a, b in zip(wall.spin, wall.direction, strict=True))
    if not math.isclose(abs(along), rate, rel_tol=1e-12):
        raise Unsupported("cylinders turn about their axis alone")
    return along


def _axis(direction: Vector) -> int | None:
    """Return the axis that a direction lies along, None for any other."""
    axes = [axis for axis in range(3) if direction[axis]]
    return axes[0] if len(axes) == 1 else None


def _numbers(values: tuple[float, ...] | list[float]) -> str:
    return " ".join(map(repr, values))
