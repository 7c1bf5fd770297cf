"""Stages of a path that was sampled: for engines that do not look at a body while they run."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.model.motion import Floats
from harness.model.scene import LOOK, Scene

Integers = NDArray[np.int64]


def stages_of(scene: Scene, step: Integers, x: Floats, v: Floats) -> Floats | None:
    """Return the stages of a path (M, 2) of the first body, by looks at its samples.

    None for a scene without stages. The last row is undecided where the path ends too early.
    """
    if not scene.stages:
        return None
    looked = ((step % LOOK == 0) | (step == scene.steps)) & (step <= scene.steps)
    rows = np.column_stack([step, step * scene.step, x, v, np.zeros(len(step))])[looked]
    mass, gravity = scene.bodies[0].mass, np.array(scene.gravity[:2])
    energy = mass * (0.5 * (rows[:, 4:6] ** 2).sum(axis=1) - rows[:, 2:4] @ gravity)
    ends, stage = [0], 0
    for place in range(1, len(rows)):
        beyond = rows[place, 2] > scene.stages[stage].place
        stops = rows[place, 4] < 0.0 and energy[place] < scene.stages[stage].floor
        if beyond:
            stage += 1
        if beyond or stops:
            ends.append(place)
        if stage == len(scene.stages) or (stops and not beyond):
            break
    else:
        ends += [len(rows) - 1] * (ends[-1] < len(rows) - 1)
    return np.asarray(rows[ends])


def decided(scene: Scene, stages: Floats) -> bool:
    """Return whether a path is over: beyond the last place, given up, or out of time."""
    *_, last = stages
    mass, gravity = scene.bodies[0].mass, np.array(scene.gravity[:2])
    passed = sum(row[2] > stage.place for row, stage in zip(stages[1:], scene.stages, strict=False))
    if passed == len(scene.stages) or last[0] >= scene.steps:
        return True
    energy = mass * (0.5 * (last[4:6] ** 2).sum() - last[2:4] @ gravity)
    return bool(last[4] < 0.0 and energy < scene.stages[passed].floor)
