"""Inclines from a start of one's own, in the reference DEM, which takes scenes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.routes import Start
from harness.cases.incline.runs import read
from harness.cases.incline.template import scene_of, values_of
from harness.cases.runs import complete
from harness.engines.reference.engine import MOST_STEPS, Reference
from harness.engines.scene import Scene
from harness.errors import RequestError
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import Spring


def scene_from(case: Incline, start: Start, spring: Spring = "linear") -> Scene:
    """Return the scene of the steady route with the grain at another start."""
    scene = scene_of(values_of(case, "steady"), spring)
    x, y, vx, vy = start.state()
    position, velocity = np.array(scene.position), np.array(scene.velocity)
    position[0], velocity[0] = (x, y), (vx, vy)
    return replace(scene, position=position, velocity=velocity)


def steady_runs(engine: Reference, cases: Sequence[Incline], start: Start) -> list[InclineRun]:
    """Run cases by the steady route from a start and return their results in order.

    Raise the first EngineError, RequestError for a step that the integrator cannot take.
    """
    spring = engine.traits.spring
    outputs = complete(engine.run_scenes([scene_from(case, start, spring) for case in cases]))
    return [
        read(case, "steady", output, spring) for case, output in zip(cases, outputs, strict=True)
    ]


def follow(
    engine: Reference, case: Incline, start: Start, duration: float, *, every: int = 1
) -> Trajectory:
    """Return the path over ``duration`` [s] from a start, sampled every so many steps.

    The last step reaches the duration or passes it. Raise RequestError for a
    duration that is not positive or asks for more than 1e15 steps, EngineError when
    the run fails.
    """
    if not (math.isfinite(duration) and 0.0 < duration <= MOST_STEPS * case.step):
        raise RequestError(
            f"duration = {duration!r} s: must be greater than 0 and at most "
            f"{MOST_STEPS * case.step:.4g} s ({MOST_STEPS:g} steps)"
        )
    steps = math.ceil(duration / case.step * (1.0 - 1e-12))
    scene = scene_from(case, start, engine.traits.spring)
    return engine.follow(replace(scene, steps=steps, every=every))
