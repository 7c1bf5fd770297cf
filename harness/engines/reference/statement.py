"""The scenes that the reference DEM can run: one mobile particle on equal fixed spheres."""

from __future__ import annotations

import numpy as np

from harness.engines.reference.row import Grain
from harness.engines.scene import Scene

EQUAL = 1e-9
"""[d] by which fixed spheres may lie off the row."""


def unstated(scene: Scene) -> str:
    """Return why a scene cannot be run, or nothing where it can.

    The fixed spheres are one, or an endless row along x in which they touch.
    """
    d = scene.diameter[0]
    if scene.columns is not None:
        return _columns_unstated(scene, scene.columns.height)
    if scene.fixed[0] or not scene.fixed[1:].all():
        return f"it moves one particle, the first, not {np.count_nonzero(~scene.fixed)}"
    if scene.forces:
        return "it writes no forces"
    if scene.fixed.size == 1:
        return "it needs a fixed sphere"
    if np.abs(scene.diameter / d - 1.0).max() > EQUAL:
        return "its spheres have one diameter"
    if scene.period is None:
        return "" if scene.fixed.size == 2 else "several fixed spheres must be an endless row"
    count = scene.fixed.size - 1
    row = scene.position[1:] - scene.position[1]
    apart = np.abs(row - np.outer(np.arange(count) * d, (1.0, 0.0))).max()
    if max(apart, abs(scene.period - count * d)) > EQUAL * count * d:
        return "its fixed spheres touch in an endless row along x"
    return ""


def _columns_unstated(scene: Scene, n: int) -> str:
    """Return why columns cannot be run: they stand a diameter apart, the first one at x = 0."""
    d, held = float(scene.diameter[0]), scene.position[1:]
    count = len(held) // n
    along = np.repeat(d * np.arange(count), n)
    if scene.spring != "linear" or scene.forces:
        return "over columns it has the linear spring, and writes no forces"
    apart = np.abs(held[:, 0] - along).max()
    if scene.period is None or max(apart, abs(scene.period - count * d)) > EQUAL * count * d:
        return "its columns touch in an endless row along x from 0 on"
    return ""


def origin_of(scene: Scene) -> tuple[float, float]:
    """Return the centre [m] of the first fixed sphere; of columns, where their axes begin."""
    if scene.columns is not None:
        return 0.0, 0.0
    return float(scene.position[1, 0]), float(scene.position[1, 1])


def grain_of(scene: Scene) -> Grain:
    """Return the mobile particle, its place from the first fixed sphere."""
    x, y = (float(value) for value in scene.position[0])
    x0, y0 = origin_of(scene)
    return Grain(x - x0, y - y0, *(float(value) for value in scene.velocity[0]))
