"""Where a scene's particles lie in MFiX's box: upright in a line, over a row, over spheres."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from harness.engines.scene import Scene
from harness.errors import RequestError

LIFT = 1e-12
"""[d] by which a particle over a row is lifted: where it just touches, rounding shall not make
an overlap, which the attractive tail would hold back."""

BEHIND, BEYOND = 1, 2
"""Spheres of a row behind its first one, and beyond where the last stage ends."""

EQUAL = 1e-9
"""Relative difference of masses, or diameters, that are equal."""


@dataclass(frozen=True)
class Sphere:
    """Position [m] and velocity [m/s] of a particle."""

    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0


class Layout(NamedTuple):
    """Mobile and held spheres, where the scene's origin is in the box, and the box."""

    mobile: tuple[Sphere, ...]
    held: tuple[Sphere, ...]
    origin: tuple[float, float]
    box: tuple[float, float]


def upright_line(scene: Scene, steps: int) -> Layout:
    """Return particles in a line, upright, the first on top, the last held or clear of the floor.

    The first particle's place is the origin.
    """
    if scene.fixed[:-1].any():
        raise RequestError("of particles in a line it holds the last alone")
    d, time, falls = float(scene.diameter[0]), steps * scene.step, max(scene.gravity[0], 0.0)
    along, velocity = scene.position[:, 0], scene.velocity[:, 0]
    if np.any(np.diff(along) <= 0.0):
        raise RequestError("particles in a line must come in order")
    speed = float(np.abs(velocity).max())
    fall = 0.0 if scene.fixed[-1] else speed * time + 0.5 * falls * time**2
    lowest = 0.5 * d if scene.fixed[-1] else 2.0 * d + fall
    top = lowest + float(along[-1] - along[0])
    spheres = tuple(
        Sphere(2.0 * d, top - float(x - along[0]), 0.0, 0.0 - float(v))
        for x, v in zip(along, velocity, strict=True)
    )
    count = np.count_nonzero(~scene.fixed)
    origin = (2.0 * d, top + float(along[0]))
    box = (4.0 * d, top + 2.0 * d + speed * time)
    return Layout(spheres[:count], spheres[count:], origin, box)


def over_a_row(scene: Scene) -> Layout:
    """Return a particle over a row that is long enough for the stages of a periodic one."""
    d, row = float(scene.diameter[0]), 0.5 * float(scene.diameter[0])
    if np.count_nonzero(~scene.fixed) != 1 or not scene.stages:
        raise RequestError(
            "it has no periodic row: a scene must say by its stages how far its particle goes"
        )
    x0, y0 = scene.position[1]
    end = max(stage.place for stage in scene.stages) - x0
    ahead = math.ceil(end / d * (1.0 - EQUAL)) + BEYOND
    first = (BEHIND + 1.5) * d
    x, y = (float(value) for value in scene.position[0] - scene.position[1])
    grain = Sphere(first + x, row + y + LIFT * d, *(float(v) for v in scene.velocity[0]))
    held = tuple(Sphere(first + i * d, row) for i in range(-BEHIND, ahead + 1))
    box = ((BEHIND + ahead + 3) * d, 6.0 * d)
    return Layout((grain,), held, (float(first - x0), float(row - y0)), box)


def over_spheres(scene: Scene, steps: int) -> Layout:
    """Return particles over level fixed ones, with room to fly about for the whole run."""
    d, time = float(scene.diameter[0]), steps * scene.step
    x0, y0 = (float(value) for value in scene.position[scene.fixed].min(axis=0))
    x, y = scene.position[:, 0] - x0, scene.position[:, 1] - y0
    speed = np.abs(scene.velocity).max(axis=0)
    pulls = 0.5 * np.maximum(np.array([abs(scene.gravity[0]), scene.gravity[1]]), 0.0) * time**2
    reach = float(speed[0] * time + pulls[0]) + 3.0 * d
    floor = 0.5 * d
    left = reach - min(float(x.min()), 0.0)
    top = floor + 2.0 * d + max(float(y.max()), d) + float(speed[1] * time + pulls[1])
    spheres = tuple(
        Sphere(left + float(x), floor + float(y), float(vx), float(vy))
        for x, y, (vx, vy) in zip(x, y, scene.velocity, strict=True)
    )
    count = np.count_nonzero(~scene.fixed)
    box = (float(np.ptp(x)) + 2.0 * reach, top)
    return Layout(spheres[:count], spheres[count:], (left - x0, floor - y0), box)
