"""Read what MFiX wrote of a run: the grain's path, or a tower in time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.cases.tower.motion import tower_run
from harness.engines.mfix.system import System, start_displacements
from harness.engines.mfix.vtp import Frame
from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory
from harness.parameters.tower import Tower

Floats = NDArray[np.float64]

SINGLE = float(np.finfo(np.float32).eps)
"""MFiX writes single precision."""


def read_path(system: System, frames: list[Frame]) -> Trajectory:
    """Return the grain's path, from the harness's origin.

    The grain is the particle with the global id 1. The path ends where it left the box.
    Raise EngineOutputError for frames that are missing or out of order, or where a held sphere
    moved; EngineNaNError for values that are not finite.
    """
    _check(system, frames)
    rows = [(frame.time, *_particle(frame, 1)) for frame in frames if 1 in _ids(frame)]
    t, x, y, vx, vy = np.array(rows).T
    return Trajectory(t, x - system.origin[0], y - system.origin[1], vx, vy)


def check_end(system: System, frames: list[Frame]) -> None:
    """Raise EngineOutputError unless the frames reach the last step."""
    last = frames[-1].time if frames else 0.0
    if last < (system.steps - 0.5) * system.step:
        raise EngineOutputError(
            f"MFiX ended at {last:g} s, before the {system.steps * system.step:g} s asked for"
        )


def read_tower(
    case: Tower,
    system: System,
    frames: list[Frame],
    forces: list[Frame],
    who: Provenance,
    profiles: bool = False,
) -> TowerRun:
    """Return the run of a tower from the frames of its particles and of its contact forces.

    MFiX writes a step's positions with the forces that led to them. In its scheme, v' = v + h a,
    x' = x + h v', the state in which the forces acted is x = x' - h v', v = v' - h a: so
    every sample is of the step before its frame, and the first is the start. Errors as
    for :func:`read_path`.
    """
    _check(system, frames)
    check_end(system, frames)
    h, particles = system.step, case.particles
    time = np.array([0.0, *(frame.time - h for frame in frames[1:])])
    shape = (len(frames), particles)
    displacement, velocity = np.zeros(shape), np.zeros(shape)
    displacement[:] = start_displacements(case)
    velocity[0, 0] = case.speed
    force = np.zeros((len(frames), case.height))
    force[0] = case.each("stiffness")[0] * np.maximum(-np.diff(displacement[0]), 0.0)
    acting = {round(frame.time / h): frame for frame in forces}
    falls = np.full(particles, case.gravity)
    if case.base == "fixed":
        falls[-1] = 0.0
    places = system.origin[1] - case.each("diameter")[0] * np.arange(particles)
    for row, frame in enumerate(frames[1:], 1):
        for i in range(len(system.mobile)):
            _, y, _, vy = _particle(frame, i + 1)
            displacement[row, i], velocity[row, i] = places[i] - y + h * vy, -vy
        found = acting.get(round(frame.time / h))
        if found is not None:
            force[row] = _of_contacts(found, places - displacement[row])
        push = np.diff(np.pad(force[row], 1)) * -1.0 / case.each("mass")[0]
        mobile = slice(len(system.mobile))
        velocity[row, mobile] -= h * (falls + push)[mobile]
    return tower_run(case, h, time, displacement, velocity, force, who, profiles=profiles)


def _of_contacts(frame: Frame, heights: Floats) -> Floats:
    """Return the contact forces (n,) [N] of a frame, each found by the place of its midpoint."""
    middles = 0.5 * (heights[:-1] + heights[1:])
    force = np.zeros(len(middles))
    found = frame.arrays["FORCE_CHAIN_FN"]
    if not np.isfinite(found).all():
        raise EngineNaNError("MFiX wrote forces that are not numbers")
    for middle, vector in zip(frame.arrays["coordinates"], found, strict=True):
        force[np.abs(middles - middle[1]).argmin()] = np.hypot(vector[0], vector[1])
    return force


def _check(system: System, frames: list[Frame]) -> None:
    """Raise EngineOutputError unless the frames are complete and what is held stayed."""
    if not frames:
        raise EngineOutputError("MFiX wrote no particles")
    numbers = np.array([frame.time for frame in frames]) / system.step
    expected = system.every * np.arange(len(frames))
    expected[-1] = round(numbers[-1])
    if np.abs(numbers - expected).max() > 0.1 or 1 not in _ids(frames[0]):
        raise EngineOutputError(
            f"MFiX wrote {len(frames)} frames that are not every {system.every} steps of "
            f"{system.step:g} s from the start"
        )
    for frame in (frames[min(1, len(frames) - 1)], frames[-1]):
        for number, sphere in enumerate(system.held, len(system.mobile) + 1):
            if number not in _ids(frame) or frame.time == 0.0:
                continue  # a particle that is held is not written
            x, y, *_ = _particle(frame, number)
            if np.hypot(x - sphere.x, y - sphere.y) > 10.0 * SINGLE * max(system.box):
                raise EngineOutputError(
                    f"MFiX moved a sphere that is to be held, {frame.time:g} s after the start: "
                    "this version does not hold particles at a mass outflow of no velocity"
                )


def _ids(frame: Frame) -> list[int]:
    try:
        return [int(number) for number in frame.arrays["Particle_ID"][:, 0]]
    except KeyError:
        raise EngineOutputError("MFiX wrote particles without their global ids") from None


def _particle(frame: Frame, number: int) -> tuple[float, float, float, float]:
    """Return x, y, vx, vy of the particle with a global id: its place in the file may change."""
    ids = _ids(frame)
    if number not in ids:
        raise EngineOutputError(f"MFiX lost particle {number} before {frame.time:g} s")
    row = ids.index(number)
    x, y, _ = frame.arrays["coordinates"][row]
    vx, vy, _ = frame.arrays["Velocity"][row]
    if not np.isfinite([x, y, vx, vy]).all():
        raise EngineNaNError(f"MFiX wrote values that are not numbers at {frame.time:g} s")
    return float(x), float(y), float(vx), float(vy)
