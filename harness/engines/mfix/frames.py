"""The motion of a system's particles, read from the frames that MFiX writes.

A frame is a VTP file as ``vtp_mod.f`` of 21.3.2 writes it: an XML head, then raw big-endian blocks
in single precision, each after the number of its bytes, offsets counted from the underscore.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from harness.engines.mfix.scenes import System
from harness.engines.scene_tables import stages_of
from harness.errors import EngineNaNError, EngineOutputError
from harness.model.motion import Floats, Motion

TIME = re.compile(rb"<!-- Time =\s*([-+.\dEeDd]+)\s+sec")
POINTS = re.compile(rb'NumberOfPoints="\s*(\d+)')
ARRAY = re.compile(rb'<DataArray type="Float32" Name="([^"]+)"([^>]*)offset="\s*(\d+)\s*"')
RAW = re.compile(rb'<AppendedData encoding="raw">\s*_')


class Frame(NamedTuple):
    """The content of a file: the time [s] and its arrays by name, (points, components) each."""

    time: float
    arrays: dict[str, Floats]


def read_frames(folder: Path, name: str) -> list[Frame]:
    """Return the frames ``NAME_0000.vtp`` ... of a folder by their times, then their numbers."""
    paths = sorted(folder.glob(f"{name}_*.vtp"), key=lambda path: (len(path.name), path.name))
    frames = [read_frame(path.read_bytes(), path.name) for path in paths]
    return sorted(frames, key=lambda frame: frame.time)


def read_frame(content: bytes, name: str) -> Frame:
    """Return the frame of one file's content, whose name errors give.

    Raise EngineOutputError for a file that is cut or of another kind, EngineNaNError for values
    that are not finite.
    """
    raw, time, points = RAW.search(content), TIME.search(content), POINTS.search(content)
    if not (raw and time and points and content.rstrip().endswith(b"</VTKFile>")):
        raise EngineOutputError(f"MFiX wrote {name} only in part: {len(content)} bytes")
    arrays: dict[str, Floats] = {}
    for array in ARRAY.finditer(content[: raw.start()]):
        shape = int(points[1]), 3 if b'NumberOfComponents="3"' in array[2] else 1
        size, start = 4 * shape[0] * shape[1], raw.end() + int(array[3])
        data, key = content[start + 4 : start + 4 + size], array[1].decode()
        if int.from_bytes(content[start : start + 4], "big") != size or len(data) < size:
            raise EngineOutputError(f"MFiX wrote {name} with {key} cut short")
        arrays[key] = np.frombuffer(data, ">f4").astype(np.float64).reshape(shape)
        if not np.isfinite(arrays[key]).all():
            raise EngineNaNError(f"MFiX wrote {name} with {key} that are not numbers")
    return Frame(float(time[1].upper().replace(b"D", b"E")), arrays)


def motion(system: System, grains: list[Frame], chains: list[Frame]) -> Motion:
    """Return the motion of a run; ``chains`` are the frames of its forces, of a line alone.

    Without forces they are NaN. A run over a row ends where its stages do, or where it was cut.
    Raise EngineOutputError for missing frames, a run that ended early, a fixed sphere that moved.
    """
    scene, h, numbers = system.scene, system.scene.step, range(1, system.mobile + 1)
    frames = {round(frame.time / h): frame for frame in grains}  # of several at a time the last
    states = [_states(frame) for frame in frames.values()]
    _check(system, [frame.time / h for frame in frames.values()], states)
    inside = [(at, row) for at, row in zip(frames, states, strict=True) if {*numbers} <= {*row}]
    inside = inside[int(system.line) :]  # there are no forces in the frame of the start
    step = np.array([at for at, _ in inside])
    state = np.array([[row[number] for number in numbers] for _, row in inside])
    place, velocity = np.split(state.reshape(-1, system.mobile, 4), 2, axis=-1)
    force = np.full(place.shape, np.nan)
    if system.line:
        acting = {round(chain.time / h): chain for chain in chains}
        chained = [acting.get(at) for at in step.tolist()]
        place, velocity, force = _a_step_before(system, place, velocity, chained)
        step = step - 1 - system.first_step
    stages = stages_of(scene, step, (place[:, 0] - system.origin) @ system.axes.T,
                       velocity[:, 0] @ system.axes.T)  # fmt: skip
    last = scene.steps if stages is None else int(stages[-1, 0])
    kept = (step % scene.every == 0) & (step <= last)
    parts = (place - system.origin, velocity, force)
    x, v, f = (_in_scene(system, part[kept] @ system.axes.T) for part in parts)
    for number, body in enumerate(scene.bodies[system.mobile :], system.mobile):
        x[:, number], v[:, number] = body.position, body.velocity
        f[:, number] = -f[:, :number].sum(axis=1) if system.line else np.nan
    zero = np.zeros_like(x)
    return Motion(step[kept] * h, x, v, zero, f, np.where(np.isnan(f), np.nan, zero), None, stages)


def _in_scene(system: System, part: Floats) -> Floats:
    """Return vectors of mobile spheres (M, mobile, 2) as those of all bodies (M, N, 3)."""
    vectors = np.zeros((len(part), len(system.scene.bodies), 3))
    vectors[:, : system.mobile, :2] = part
    return vectors


def _a_step_before(
    system: System, place: Floats, velocity: Floats, chained: list[Frame | None]
) -> tuple[Floats, Floats, Floats]:
    """Return places, velocities and forces of a step before the frames, in a line.

    MFiX writes a step's positions with the forces that led to them: v' = v + h a, x' = x + h v', so
    they acted at x = x' - h v', v = v' - h a.
    """
    scene, h = system.scene, system.scene.step
    place = place - h * velocity
    rows = zip(chained, place[..., 1], strict=True)
    contacts = np.array([_forces(system, chain, heights) for chain, heights in rows])
    force = np.zeros_like(place)  # a contact pushes the sphere above it up, and the one below down
    force[..., 1] = np.diff(np.pad(contacts, ((0, 0), (1, 1))), axis=1)[:, : system.mobile]
    gravity = np.array(scene.gravity[:2]) @ system.axes
    velocity = velocity - h * (gravity + force / scene.bodies[0].mass)
    return place, velocity, force


def _states(frame: Frame) -> dict[int, Floats]:
    """Return x, y [m], vx, vy [m/s] by global id: the order in a file may change."""
    if "Particle_ID" not in frame.arrays:
        raise EngineOutputError("MFiX wrote particles without their global ids")
    state = np.hstack([frame.arrays[name][:, :2] for name in ("coordinates", "Velocity")])
    return dict(zip(frame.arrays["Particle_ID"][:, 0].astype(int).tolist(), state, strict=True))


def _forces(system: System, chain: Frame | None, heights: Floats) -> Floats:
    """Return the contact forces of particles in a line [N], each found by the contact's height."""
    heights = np.concatenate([heights, system.place[system.mobile :, 1]])
    middles, force = 0.5 * (heights[:-1] + heights[1:]), np.zeros(len(heights) - 1)
    if chain is not None:  # else nothing touches
        points = zip(chain.arrays["coordinates"], chain.arrays["FORCE_CHAIN_FN"], strict=True)
        for point, vector in points:
            force[np.abs(middles - point[1]).argmin()] = vector[1]
    return force


def _check(system: System, clock: list[float], states: list[dict[int, Floats]]) -> None:
    """Raise EngineOutputError for bad frames, by their steps on the clock and particles."""
    expected = system.every * np.arange(len(clock))
    expected[0], expected[-1] = system.first_step, round(clock[-1])
    if np.abs(np.array(clock) - expected).max() > 0.1 or 1 not in states[0]:
        raise EngineOutputError(
            f"MFiX wrote {len(clock)} frames that are not every {system.every} steps from the start"
        )
    if not system.scene.stages and clock[-1] < system.first_step + system.steps - 0.5:
        raise EngineOutputError(f"MFiX ended at step {clock[-1]:.0f} of {system.steps}")
    for state in states[1:2] + states[-1:]:  # a particle that is held is not written
        for number in state.keys() & set(range(system.mobile + 1, len(system.place) + 1)):
            moved = state[number][:2] - system.place[number - 1]
            if np.hypot(*moved) > 1.2e-6 * max(system.box):  # ten roundings in single precision
                raise EngineOutputError(
                    "MFiX moved a sphere that is to be held at a mass outflow of no velocity"
                )
