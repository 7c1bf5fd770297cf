"""Read the output of MFiX: where its particles were, and the forces between them.

It is in VTP files of a region, as ``WRITE_VTP_FILE`` of MFiX 21.3.2 writes them (``vtp_mod.f``): an
XML head, then raw big-endian blocks, all values in single precision, each block after the number
of its bytes, offsets counted from the underscore.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harness.engines.mfix.system import System
from harness.engines.output import Table
from harness.errors import EngineNaNError, EngineOutputError
from harness.parameters.scene import ContactScene

Floats = NDArray[np.float64]

TIME = re.compile(rb"<!-- Time =\s*([-+.\dEeDd]+)\s+sec")
POINTS = re.compile(rb'NumberOfPoints="\s*(\d+)')
ARRAY = re.compile(rb'<DataArray type="Float32" Name="([^"]+)"([^>]*)offset="\s*(\d+)\s*"')
RAW = re.compile(rb'<AppendedData encoding="raw">\s*_')
END = b"</VTKFile>"


@dataclass(frozen=True)
class Frame:
    """What one file holds: the time [s] and its arrays by name, (points, components) each."""

    time: float
    arrays: dict[str, Floats]


def read_frames(folder: Path, name: str) -> list[Frame]:
    """Return the frames ``NAME_0000.vtp`` ... of a folder by their times, then their numbers.

    Raise EngineOutputError for a file that is cut or not of this kind.
    """
    paths = sorted(folder.glob(f"{name}_*.vtp"), key=lambda path: (len(path.name), path.name))
    frames = [read_frame(path.read_bytes(), path.name) for path in paths]
    return sorted(frames, key=lambda frame: frame.time)


def read_frame(content: bytes, name: str) -> Frame:
    """Return the frame of one file's content; ``name`` is for the message. Errors as above."""
    if not content.rstrip().endswith(END):
        raise EngineOutputError(f"MFiX wrote {name} only in part: {len(content)} bytes")
    raw, time, points = RAW.search(content), TIME.search(content), POINTS.search(content)
    if raw is None or time is None or points is None:
        raise EngineOutputError(f"MFiX wrote {name} without the head of a VTP file")
    count = int(points[1])
    head, blocks = content[: raw.start()], content[raw.end() :]
    arrays: dict[str, Floats] = {}
    for array in ARRAY.finditer(head):
        components = 3 if b'NumberOfComponents="3"' in array[2] else 1
        values = _block(blocks, int(array[3]), count * components)
        if values is None:
            raise EngineOutputError(f"MFiX wrote {name} with {array[1].decode()} cut short")
        arrays[array[1].decode()] = values.reshape(count, components)
    return Frame(float(time[1].upper().replace(b"D", b"E")), arrays)


def _block(blocks: bytes, offset: int, count: int) -> Floats | None:
    """Return the values at an offset, or None unless there are as many as expected."""
    size = blocks[offset : offset + 4]
    data = blocks[offset + 4 : offset + 4 + 4 * count]
    if len(size) < 4 or int.from_bytes(size, "big") != 4 * count or len(data) < 4 * count:
        return None
    return np.frombuffer(data, dtype=">f4").astype(np.float64)


SINGLE = float(np.finfo(np.float32).eps)
"""MFiX writes single precision."""


def path_table(system: System, scene: ContactScene, frames: list[Frame]) -> Table:
    """Return the motion of the mobile particles, in the scene's coordinates; fixed ones rest.

    A particle is known by its global id. The path ends where one left the box.
    Raise EngineOutputError for frames that are missing or out of order, or where a held sphere
    moved; EngineNaNError for values that are not finite.
    """
    frames = _checked(system, frames)
    numbers = range(1, len(system.mobile) + 1)
    inside = [frame for frame in frames if set(numbers) <= set(_ids(frame))]
    states = np.array([[particle(frame, number) for number in numbers] for frame in inside])
    step = np.array([round(frame.time / system.step) for frame in inside], dtype=np.float64)
    return _table(system, scene, step, states[..., :2], states[..., 2:])


def forced_table(
    system: System, scene: ContactScene, frames: list[Frame], forces: list[Frame]
) -> Table:
    """Return the motion of particles in a line, with the force of each contact.

    MFiX writes a step's positions with the forces that led to them. In its scheme, v' = v + h a,
    x' = x + h v', the state in which the forces acted is x = x' - h v', v = v' - h a: so
    every sample is of the step before its frame, and the first frame, of the start, has none.
    Errors as for :func:`path_table`.
    """
    frames = _checked(system, frames)[1:]
    h, mobile = system.step, len(system.mobile)
    step = np.array([round(frame.time / h) - 1 - system.first for frame in frames])
    states = np.array([[particle(frame, i + 1) for i in range(mobile)] for frame in frames])
    states = states.reshape(len(frames), mobile, 4)
    place, velocity = states[..., :2] - h * states[..., 2:], states[..., 2:]
    heights = np.tile([sphere.y for sphere in system.spheres], (len(frames), 1))
    heights[:, :mobile] = place[..., 1]
    acting = {round(frame.time / h): frame for frame in forces}
    force = np.zeros((len(frames), heights.shape[1] - 1))
    for row, frame in enumerate(frames):
        acting_now = acting.get(round(frame.time / h))
        if acting_now is not None:
            force[row] = _of_contacts(acting_now, heights[row])
    push = np.diff(np.pad(force, ((0, 0), (1, 1))), axis=1) / system.mass
    velocity = velocity - h * np.array(system.gravity)
    velocity[..., 1] -= h * push[:, :mobile]
    table = dict(_table(system, scene, step.astype(np.float64), place, velocity))
    table["contact_force_N"] = force
    return table


def _table(
    system: System, scene: ContactScene, step: Floats, place: Floats, velocity: Floats
) -> dict[str, Floats]:
    """Return the table of places and velocities in the box, (M, mobile, 2) each."""
    place = place - np.array(system.origin)
    if system.upright:
        place, velocity = (
            np.stack([0.0 - value[..., 1], value[..., 0]], axis=-1) for value in (place, velocity)
        )
    rest = np.broadcast_to(scene.position[scene.fixed], (len(step), int(scene.fixed.sum()), 2))
    place = np.concatenate([place, rest], axis=1)
    velocity = np.concatenate([velocity, np.zeros_like(rest)], axis=1)
    return {
        "step": step,
        "time_s": step * system.step,
        "x_m": place[..., 0],
        "y_m": place[..., 1],
        "vx_m_per_s": velocity[..., 0],
        "vy_m_per_s": velocity[..., 1],
    }


def check_end(system: System, frames: list[Frame]) -> None:
    """Raise EngineOutputError unless the frames reach the last step."""
    last = frames[-1].time if frames else 0.0
    end = (system.first + system.steps) * system.step
    if last < end - 0.5 * system.step:
        raise EngineOutputError(f"MFiX ended at {last:g} s, before the {end:g} s asked for")


def _of_contacts(frame: Frame, heights: Floats) -> Floats:
    """Return the contact forces (n,) [N] of a frame, each found by the place of its midpoint."""
    middles = 0.5 * (heights[:-1] + heights[1:])
    force = np.zeros(len(middles))
    vectors = frame.arrays["FORCE_CHAIN_FN"]
    if not np.isfinite(vectors).all():
        raise EngineNaNError("MFiX wrote forces that are not numbers")
    for middle, vector in zip(frame.arrays["coordinates"], vectors, strict=True):
        force[np.abs(middles - middle[1]).argmin()] = np.hypot(vector[0], vector[1])
    return force


def _checked(system: System, frames: list[Frame]) -> list[Frame]:
    """Return the frames, of several at one time the last.

    Raise EngineOutputError unless they are complete and what is held stayed.
    """
    if not frames:
        raise EngineOutputError("MFiX wrote no particles")
    clock = {round(frame.time / system.step): frame for frame in frames}
    frames = list(clock.values())
    numbers = np.array([frame.time for frame in frames]) / system.step
    expected = system.every * np.arange(len(frames))
    expected[0], expected[-1] = system.first, round(numbers[-1])
    if np.abs(numbers - expected).max() > 0.1 or 1 not in _ids(frames[0]):
        raise EngineOutputError(
            f"MFiX wrote {len(frames)} frames that are not every {system.every} steps of "
            f"{system.step:g} s from the start"
        )
    for frame in (frames[min(1, len(frames) - 1)], frames[-1]):
        for number, sphere in enumerate(system.held, len(system.mobile) + 1):
            if number not in _ids(frame) or frame is frames[0]:
                continue  # a particle that is held is not written
            x, y, *_ = particle(frame, number)
            if np.hypot(x - sphere.x, y - sphere.y) > 10.0 * SINGLE * max(system.box):
                raise EngineOutputError(
                    f"MFiX moved a sphere that is to be held, {frame.time:g} s after the start: "
                    "this version does not hold particles at a mass outflow of no velocity"
                )
    return frames


def _ids(frame: Frame) -> list[int]:
    try:
        return [int(number) for number in frame.arrays["Particle_ID"][:, 0]]
    except KeyError:
        raise EngineOutputError("MFiX wrote particles without their global ids") from None


def row_of(frame: Frame, number: int) -> int:
    """Return where the particle with a global id is: its place in the file may change."""
    ids = _ids(frame)
    if number not in ids:
        raise EngineOutputError(f"MFiX lost particle {number} before {frame.time:g} s")
    return ids.index(number)


def particle(frame: Frame, number: int) -> tuple[float, float, float, float]:
    """Return x, y [m], vx, vy [m/s] of the particle with a global id.

    Raise EngineOutputError for one that is lost, EngineNaNError for values that are not finite.
    """
    row = row_of(frame, number)
    x, y, _ = frame.arrays["coordinates"][row]
    vx, vy, _ = frame.arrays["Velocity"][row]
    if not np.isfinite([x, y, vx, vy]).all():
        raise EngineNaNError(f"MFiX wrote values that are not numbers at {frame.time:g} s")
    return float(x), float(y), float(vx), float(vy)
