"""A scene in MFiX's terms, and the motion of its particles read from what MFiX writes.

MFiX has no keyword that holds a particle. It does take over the velocity of a particle within
a radius of a mass outflow, and no longer adds forces to it (``EXITING``; 21.3.2,
``mass_outflow_dem.f`` and ``cfnewvalues.f``): at an outflow of no velocity it stays. Two
things follow. It is taken over after the first step only, so that it is put where that step
brings it to its place. And it must come after the mobile ones in ``particle_input.dat``: the
neighbour search would count the contact twice otherwise (``desgrid_mod.f``). For the same
reason no boundary is cyclic: a grain that crosses one comes back behind the others.
The error of the first step falls with the third order.

The outflow is the floor of the box. So a scene's fixed particles must be level; particles in a
line along x stand upright in the box, x downward, and only the last may be fixed.

Output is in VTP files of a region, as ``WRITE_VTP_FILE`` of MFiX 21.3.2 writes them
(``vtp_mod.f``): an XML head, then raw big-endian blocks, all values in single precision, each block
after the number of its bytes, offsets counted from the underscore.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.engines.output import Table
from harness.errors import EngineNaNError, EngineOutputError, RequestError
from harness.parameters.law import Contact
from harness.parameters.scene import ContactScene

Scheme = Literal["EULER", "ADAMS_BASHFORTH"]
"""MFiX's names of its integrators (``DES_INTG_METHOD``)."""

REFERENCE: dict[Scheme, str] = {
    "EULER": "mfix-euler",
    "ADAMS_BASHFORTH": "mfix-adams-bashforth",
}
"""The reference DEM's names of them."""

FIRST_STEP: dict[Scheme, float] = {"EULER": 1.0, "ADAMS_BASHFORTH": 0.5}
"""The part of h a by which the first step's displacement h v + part h^2 a falls behind or ahead:
x+ = x + h (v + h a), and x + h/2 (v + v + h a)."""

LEAST_FACTOR = 10.0
"""What MFiX takes at least for ``DTSOLID_FACTOR`` (21.3.2, ``check_solids_dem.f``)."""


def steps_per_contact(factor: float, contact: Contact) -> float:
    """Return the steps per pi sqrt(m/k) that MFiX takes at a ``DTSOLID_FACTOR``.

    MFiX divides the duration of a damped contact, with m_eff = m/2 also against
    a fixed sphere, pi / sqrt(k/m_eff - (eta / (2 m_eff))^2), by the factor. With eta = 2 zeta
    sqrt(k m_eff) that is pi sqrt(m/k) / sqrt(2 (1 - zeta^2)): at e = 1e-20 it is ten times
    as long, and MFiX's default factor of 50 means 4.8 steps. Raise RequestError for a factor
    that is not positive, or a contact without such a duration (zeta >= 1) or without m/2.
    """
    if not (math.isfinite(factor) and factor > 0.0):
        raise RequestError(f"factor = {factor!r}: must be finite and greater than 0")
    return factor * _steps_of_factor_one(contact)


def factor(steps: float, contact: Contact) -> float:
    """Return the ``DTSOLID_FACTOR`` of so many steps per pi sqrt(m/k).

    The inverse of :func:`steps_per_contact`, with its errors. Raise RequestError below the
    10 that MFiX takes at least.
    """
    wanted = steps / _steps_of_factor_one(contact)
    if not wanted >= LEAST_FACTOR:
        least = LEAST_FACTOR * _steps_of_factor_one(contact)
        raise RequestError(
            f"steps_per_contact = {steps:g} is DTSOLID_FACTOR = {wanted:.4g} in MFiX, which takes "
            f"{LEAST_FACTOR:g} or more: must be at least {least:.4g} with this contact"
        )
    return wanted


def _steps_of_factor_one(contact: Contact) -> float:
    if contact.effective_mass != "half":
        raise RequestError(
            "effective_mass = 'full': MFiX takes half the mass, must be 'half' "
            "(--set contact.effective_mass=half, of critical-angle --half-mass)"
        )
    if contact.zeta >= 1.0:
        raise RequestError(
            f"damping ratio = {contact.zeta:g}: MFiX's contact time asks for less than 1"
        )
    return math.sqrt(2.0 * (1.0 - contact.zeta**2))


def nominal_restitution(zeta: float) -> float:
    """Return the restitution that states a damping ratio below 1."""
    return math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))


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


def upright_line(scene: ContactScene, steps: int) -> Layout:
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


def over_a_row(scene: ContactScene) -> Layout:
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


def over_spheres(scene: ContactScene, steps: int) -> Layout:
    """Return particles over level fixed ones, with room to fly about for the whole run."""
    d, time = float(scene.diameter[0]), steps * scene.step
    x0, y0 = (float(value) for value in scene.position[scene.fixed].min(axis=0))
    x, y = scene.position[:, 0] - x0, scene.position[:, 1] - y0
    speed = np.abs(scene.velocity).max(axis=0)
    pulls = 0.5 * np.maximum(np.array([abs(scene.gravity[0]), scene.gravity[1]]), 0.0) * time**2
    reach = float(speed[0] * time + pulls[0]) + 3.0 * d
    floor = 0.5 * d
    start = reach - min(float(x.min()), 0.0)
    top = floor + 2.0 * d + max(float(y.max()), d) + float(speed[1] * time + pulls[1])
    spheres = tuple(
        Sphere(start + float(x), floor + float(y), float(vx), float(vy))
        for x, y, (vx, vy) in zip(x, y, scene.velocity, strict=True)
    )
    count = np.count_nonzero(~scene.fixed)
    box = (float(np.ptp(x)) + 2.0 * reach, top)
    return Layout(spheres[:count], spheres[count:], (start - x0, floor - y0), box)


Floats = NDArray[np.float64]


@dataclass(frozen=True)
class System:
    """A run of MFiX in SI units: spheres of one size, mobile ones first, in a box from (0, 0).

    ``origin`` is where the scene's origin is in the box, ``upright`` says that the scene's x
    points downward in it; ``gravity`` has two components. ``steps`` are all, a frame is written
    every so many steps of the clock, which starts at ``first`` steps. ``forces``: frames of
    contact forces are written as well.
    """

    name: str
    mobile: tuple[Sphere, ...]
    held: tuple[Sphere, ...]
    origin: tuple[float, float]
    box: tuple[float, float]
    diameter: float
    mass: float
    stiffness: float
    contact: Contact
    gravity: tuple[float, float]
    step: float
    steps: int
    every: int
    upright: bool = False
    forces: bool = False
    scheme: Scheme = "EULER"

    @property
    def first(self) -> int:
        """Return the steps that the clock shows at the start.

        Forces are those of the step before a frame. With a clock that starts at ``every`` - 1
        frames are written after 1, 1 + ``every``, ... steps, whose forces acted in the states
        at 0, ``every``, ... steps.
        """
        return self.every - 1 if self.forces else 0

    @property
    def density(self) -> float:
        """Return the density [kg/m3] of a sphere."""
        return self.mass * 6.0 / math.pi / self.diameter**3

    @property
    def factor(self) -> float:
        """Return the ``DTSOLID_FACTOR`` of the step; raise RequestError where MFiX has none."""
        period = math.pi * math.sqrt(self.mass / self.stiffness)
        return factor(period / self.step, self.contact)

    @property
    def restitution(self) -> float:
        """Return the nominal restitution that states the contact's damping ratio."""
        nominal = self.contact.stated_restitution
        return nominal_restitution(self.contact.zeta) if nominal is None else nominal

    @property
    def spheres(self) -> tuple[Sphere, ...]:
        """Return all spheres as MFiX reads them, held ones with what their first step takes."""
        return (*self.mobile, *(self._at_rest_after_a_step(sphere) for sphere in self.held))

    def _at_rest_after_a_step(self, sphere: Sphere) -> Sphere:
        """Return a held sphere with the velocity that gravity and contacts take in a step."""
        ax, ay = self.gravity
        eta = 2.0 * self.contact.zeta * math.sqrt(0.5 * self.stiffness * self.mass)
        for other in self.mobile:
            dx, dy = sphere.x - other.x, sphere.y - other.y
            distance = math.hypot(dx, dy)
            if distance < self.diameter:
                nx, ny = dx / distance, dy / distance
                approach = other.vx * nx + other.vy * ny
                push = self.stiffness * (self.diameter - distance) + eta * approach
                ax, ay = ax + push * nx / self.mass, ay + push * ny / self.mass
        part = FIRST_STEP[self.scheme] * self.step
        return replace(sphere, vx=0.0 - ax * part, vy=0.0 - ay * part)


def system_of(
    name: str, scene: ContactScene, steps: int, every: int, scheme: Scheme = "EULER"
) -> System:
    """Return the system of the first ``steps`` of a scene, a frame every so many steps.

    Raise RequestError for a scene that MFiX cannot hold, or whose forces a scheme does not tell.
    """
    _check(scene, scheme)
    flat = not (np.ptp(scene.position[:, 1]) or scene.gravity[1] or scene.velocity[:, 1].any())
    upright = scene.mass.size > 1 and flat
    fixed = scene.position[scene.fixed]
    if upright:
        steps += 1
        layout = upright_line(scene, steps)
    elif scene.forces:
        raise RequestError("its forces are those of particles in a line")
    elif not fixed.size or np.ptp(fixed[:, 1]) > 0.0:
        raise RequestError("it holds particles on the floor of its box: fixed ones must be level")
    elif scene.period is None:
        layout = over_spheres(scene, steps)
    else:
        steps = every * math.ceil(steps / every)
        layout = over_a_row(scene)
    gx, gy = scene.gravity
    return System(
        name=re.sub(r"\W", "_", name).upper()[:40],
        **layout._asdict(),
        diameter=float(scene.diameter[0]),
        mass=float(scene.mass[0]),
        stiffness=scene.stiffness,
        contact=scene.contact,
        gravity=(gy, -gx) if upright else (gx, gy),
        step=scene.step,
        steps=steps,
        every=every,
        upright=upright,
        forces=scene.forces,
        scheme=scheme,
    )


def _check(scene: ContactScene, scheme: Scheme) -> None:
    for values, name in ((scene.diameter, "diameter"), (scene.mass, "mass")):
        if np.ptp(values) > EQUAL * values[0]:
            raise RequestError(f"its spheres have one {name}")
    mobile = np.count_nonzero(~scene.fixed)
    if scene.fixed[:mobile].any():
        raise RequestError("its fixed particles must come last")
    if scene.forces and scheme != "EULER":
        # a frame has the forces of the step before: the state they belong to follows from it there
        raise RequestError(f"it tells the forces of a state in scheme EULER only, not in {scheme}")


# ---- what MFiX writes

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
