"""Scenes in MFiX's terms: rows, lines along gravity, and drops on level spheres; its frames.

No keyword of MFiX fixes a particle. A particle within a radius of a mass outflow takes the
outflow's velocity and no forces (21.3.2, ``mass_outflow_dem.f``): at one of no velocity it stays,
after its first step, with whose velocity it starts. Held ones come last, and no boundary is cyclic:
contacts would count twice (``desgrid_mod.f``). The outflow is the floor of the box: fixed particles
must be level, and a line of particles along x is upright, x downward, the last on the floor.

A frame is a VTP file as ``vtp_mod.f`` of 21.3.2 writes it: an XML head, then raw big-endian blocks
in single precision, each after the number of its bytes, offsets counted from the underscore.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from harness.engines.scenes import (
    check_scene,
    check_words,
    contact_mass,
    partners,
    refuse_any,
    stages_of,
)
from harness.engines.scripts import rendered
from harness.errors import EngineNaNError, EngineOutputError, Unsupported
from harness.model.conventions import Rules
from harness.model.scene import LOOK, Floats, Motion, Scene

KEYWORDS, PARTICLES = "mfix.dat", "particle_input.dat"  # the names that MFiX looks for
TEMPLATES = Path(__file__).with_name("templates")
Pair = tuple[float, float]
UPRIGHT = np.array([[0.0, -1.0], [1.0, 0.0]])
Scheme = Literal["EULER", "ADAMS_BASHFORTH"]  # ``DES_INTG_METHOD``
# the part of h^2 a in the first step's displacement
FIRST_STEP: dict[Scheme, float] = {"EULER": 1.0, "ADAMS_BASHFORTH": 0.5}
LEAST_FACTOR = 10.0  # of ``DTSOLID_FACTOR`` (``check_solids_dem.f``)
LEAST_RESTITUTION = 1e-20  # the source's; at 0 MFiX divides by zero
BEHIND, BEYOND = 2, 2  # spheres of a row behind its first one, and beyond the last stage
EQUAL = 1e-9  # relative difference of masses, or places, that are equal
SEARCH_CELL = 2.4  # [d] the search looks half a cell about a particle, and must reach a diameter
MOST_FRAMES = 100_000  # files that a run writes at most
ROUNDINGS = 1.2e-6  # [box] ten roundings of a place in single precision
TIME = re.compile(rb"<!-- Time =\s*([-+.\dEeDd]+)\s+sec")
POINTS = re.compile(rb'NumberOfPoints="\s*(\d+)')
ARRAY = re.compile(rb'<DataArray type="Float32" Name="([^"]+)"([^>]*)offset="\s*(\d+)\s*"')
RAW = re.compile(rb'<AppendedData encoding="raw">\s*_')


def rules(scene: Scene, scheme: Scheme = "EULER") -> Rules:
    """Return MFiX's conventions; raise Unsupported for a scene that it cannot run."""
    system_of(scene, scene.steps, scheme)
    name: Any = f"mfix_{scheme.lower()}"
    return Rules(scheme=name, frozen_mass="own", least_overlap=1e-15, looks_set_up=False)


@dataclass(frozen=True)
class System:
    """A run of MFiX: a scene in a box from (0, 0), with a frame every so many steps.

    ``places`` (N, 2) are all spheres in the box [m], mobile ones first. Vectors of the scene are
    those times ``axes`` (2, 2) in the box, where ``origin`` is the scene's. Of a ``line`` the
    contact forces are written too.
    """

    scene: Scene
    steps: int
    every: int
    scheme: Scheme
    line: bool
    places: Floats
    origin: Pair
    box: Pair

    @property
    def axes(self) -> Floats:
        """Return the rotation of the scene into the box: a line is upright, x downward."""
        return UPRIGHT if self.line else np.eye(2)

    @property
    def mobile(self) -> int:
        """Return the number of mobile spheres."""
        return sum(body.motion == "free" for body in self.scene.bodies)

    @property
    def text(self) -> str:
        """Return the inputs, one after the other."""
        return "\n".join(f"# {file}\n{text}" for file, text in self.inputs.items())

    @property
    def inputs(self) -> dict[str, str]:
        """Return the texts of the inputs by the names of their files."""
        values = self.keywords()
        size = (0.5 * values["diameter"], values["density"])
        spheres = zip(self.places.tolist(), self.start_velocity().tolist(), strict=True)
        lines = (" ".join(map(_fortran, (*place, *size, *moves))) for place, moves in spheres)
        written = {name: _fortran(value) for name, value in values.items()}
        keywords = rendered([TEMPLATES], "mfix.dat.j2", written)
        return {KEYWORDS: keywords, PARTICLES: "".join(f"{line}\n" for line in lines)}

    def start_velocity(self) -> Floats:
        """Return all velocities at the start [m/s], of fixed ones what their first step takes."""
        scene, n = self.scene, self.mobile
        law, mass, d = scene.law, scene.bodies[0].mass, 2.0 * scene.bodies[0].radius
        moving = np.array([body.velocity[:2] for body in scene.bodies[:n]]) @ self.axes
        separation = self.places[n:, None] - self.places[None, :n]
        distance = np.hypot(separation[..., 0], separation[..., 1])
        normal = separation / distance[..., None]
        push = (law.normal_stiffness or 0.0) * (d - distance)
        push += law.dashpot(0.5 * mass, 1.0, 0.0) * (moving * normal).sum(axis=-1)
        pushed = (np.where(distance < d, push, 0.0)[..., None] * normal).sum(axis=1) / mass
        acceleration = scene.gravity[:2] @ self.axes + pushed
        return np.vstack([moving, -acceleration * FIRST_STEP[self.scheme] * scene.step])

    def keywords(self) -> dict[str, Any]:
        """Return the values of ``mfix.dat``."""
        scene, (width, height), body = self.scene, self.box, self.scene.bodies[0]
        d, zeta, (gx, gy) = 2.0 * body.radius, _damping_ratio(scene), scene.gravity[:2] @ self.axes
        return {
            "line": self.line,
            # half a step less: MFiX rounds the number of steps up, in single precision
            "stop": (self.steps - 0.5) * scene.step,
            "gravity_x": float(gx),
            "gravity_y": float(gy),
            "width": width,
            "height": height,
            "columns": max(3, math.floor(0.5 * width / d)),
            "rows": max(3, math.floor(0.5 * height / d)),
            "search_columns": max(1, math.floor(width / (SEARCH_CELL * d))),
            "search_rows": max(1, math.floor(height / (SEARCH_CELL * d))),
            "diameter": d,
            "density": body.mass * 6.0 / math.pi / d**3,
            "particles": len(self.places),
            "stiffness": scene.law.normal_stiffness,
            "restitution": math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2)),
            "factor": _factor(scene),
            "scheme": self.scheme,
            "interval": self.every * scene.step,
        }


def _fortran(value: Any) -> Any:
    """Return a float as the shortest Fortran double that reads back the same."""
    if not isinstance(value, float):
        return value
    mantissa, _, exponent = repr(float(value)).partition("e")
    point = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{point}d{int(exponent)}" if exponent else point


def system_of(scene: Scene, steps: int, scheme: Scheme) -> System:
    """Return the system of the first ``steps`` of a scene.

    Raise Unsupported for a scene that MFiX cannot hold, or whose contacts it does not have.
    """
    _check_contacts(scene)
    across = [body.position[1] - scene.bodies[0].position[1] for body in scene.bodies]
    across += [scene.gravity[1], *(body.velocity[1] for body in scene.bodies)]
    line = len(scene.bodies) > 1 and not any(across)  # several spheres that move along x alone
    _check_places(scene, scheme, line=line)
    every = _interval(scene, steps, line=line)
    if scene.period[0] is not None:
        steps = every * math.ceil(steps / every)
        return System(scene, steps, every, scheme, line, *_row(scene))
    steps += line  # frames of forces are those of a step before
    axes = UPRIGHT if line else np.eye(2)
    places = np.array([body.position[:2] for body in scene.bodies]) @ axes
    origin, box = _box(scene, places, axes, steps * scene.step)
    return System(scene, steps, every, scheme, line, places + origin, origin, box)


def _check_contacts(scene: Scene) -> None:
    """Raise Unsupported for contacts that MFiX does not have."""
    check_scene(scene)
    law, bodies, (first, *_) = scene.law, scene.bodies, scene.bodies
    check_words(law, "LSD", normal="hooke", tangential="none", rolling="none", twisting="none",
                damping="none velocity mass_velocity damping_ratio coeff_restitution")  # fmt: skip
    across = [scene.gravity[2]]
    for body in bodies:
        across += [body.position[2], body.velocity[2], *body.angular_velocity]
    damped = law.damping != "none"
    unequal = any(
        b.radius != first.radius or abs(b.mass - first.mass) > EQUAL * first.mass for b in bodies
    )
    refuse_any(
        (scene.walls, "takes no walls here"),
        (scene.segments or scene.setups, "takes one run under its forces"),
        (any(across), "takes spheres in the plane of x and y that do not turn"),
        (unequal, "its spheres have one diameter and one mass"),
        (any(body.motion != "free" and any(body.velocity) for body in bodies),
         "its fixed spheres are at rest"),
        (damped and law.clipped, "keeps the attractive tail (clipped = False)"),
        (damped and any(body.motion == "frozen" for body in bodies),
         "counts a fixed sphere with its own mass in m*: effective mass half, motion = held"),
    )  # fmt: skip
    log = math.log(LEAST_RESTITUTION)
    most = -log / math.hypot(math.pi, log)
    if not _damping_ratio(scene) <= most * (1.0 + EQUAL):
        raise Unsupported(f"takes damping ratios up to {most:.6g} (restitution 1e-20)")
    if not _factor(scene) >= LEAST_FACTOR * (1.0 - EQUAL):
        raise Unsupported(
            f"takes a DTSOLID_FACTOR of {LEAST_FACTOR:g} or more, not {_factor(scene):.4g}: the "
            f"step must be at most {scene.step * _factor(scene) / LEAST_FACTOR:.6g} s here"
        )


def _damping_ratio(scene: Scene) -> float:
    """Return eta / (2 sqrt(k m/2)) of the contacts."""
    first, second = partners(scene)[0]
    eta = scene.law.dashpot(contact_mass(scene, first, second), 1.0, 0.0)
    stiffness = scene.law.normal_stiffness or 0.0
    return eta / (2.0 * math.sqrt(0.5 * stiffness * scene.bodies[0].mass))


def _factor(scene: Scene) -> float:
    """Return MFiX's steps of a damped contact of m/2."""
    omega = math.sqrt(2.0 * (scene.law.normal_stiffness or 0.0) / scene.bodies[0].mass)
    return math.pi / (omega * math.sqrt(1.0 - _damping_ratio(scene) ** 2)) / scene.step


def _check_places(scene: Scene, scheme: Scheme, *, line: bool) -> None:
    """Raise Unsupported for spheres that are no line, no row and not above level fixed ones."""
    free = [body.motion == "free" for body in scene.bodies]
    levels = {body.position[1] for body in scene.bodies if body.motion != "free"}
    along = [body.position[0] for body in scene.bodies]
    count, row, stages = sum(free), scene.period[0] is not None, scene.stages
    refuse_any(
        (all(free), "some of its particles must be fixed"),
        (not all(free[:count]), "its fixed particles must come last"),
        (line and scheme != "EULER", "it gives forces of lines in scheme EULER only"),
        (not line and len(levels) > 1, "its fixed particles must be level"),
        (line and (count < len(free) - 1 or np.any(np.diff(along) <= 0.0)),
         "particles in a line must come in order, and the last alone be fixed"),
        (row and (line or count != 1 or not stages),
         "it takes one particle over a row, and stages that give its end"),
        (not row and stages, "its stages are those of a row"),
        (row and not _is_touching_row(scene), "its row is of touching spheres"),
    )  # fmt: skip


def _is_touching_row(scene: Scene) -> bool:
    row = sorted(body.position[0] for body in scene.bodies[1:])
    d, length = 2.0 * scene.bodies[0].radius, scene.period[0] or 0.0
    touching = np.allclose(np.diff(row), d, rtol=EQUAL, atol=0.0)
    return bool(touching and math.isclose(length, len(row) * d, rel_tol=EQUAL))


def _interval(scene: Scene, steps: int, *, line: bool) -> int:
    """Return the steps between two frames: 1 in a line, up to a look where there are stages.

    Raise Unsupported where that makes too many files.
    """
    every = 1 if line else scene.every
    if scene.stages:
        sampled = scene.every < scene.steps
        rarer = 1 if sampled else math.ceil(steps / (LOOK * MOST_FRAMES))
        every = math.gcd(scene.every, LOOK) if sampled else LOOK * rarer
    if steps > MOST_FRAMES * every:
        raise Unsupported(f"writes at most {MOST_FRAMES} files, not each {every} of {steps} steps")
    return every


def _row(scene: Scene) -> tuple[Floats, Pair, Pair]:
    """Return places, origin and box of a sphere over a row that reaches beyond the last stage."""
    place = np.array([body.position[:2] for body in scene.bodies])
    d, first = 2.0 * scene.bodies[0].radius, place[1:][np.argmin(place[1:, 0])]
    number = np.arange(1 - BEHIND, math.ceil((scene.stages[-1].place - first[0]) / d) + BEYOND + 1)
    row = first + np.column_stack([number * d, np.zeros(len(number))])
    lift = np.array([0.0, 1e-12 * d])  # rounding of a touch must not make an overlap
    origin = ((BEHIND + 0.5) * d - float(first[0]), 0.5 * d - float(first[1]))
    return np.vstack([place[0] + lift, row]) + origin, origin, ((len(number) + 2) * d, 6.0 * d)


def _box(scene: Scene, place: Floats, axes: Floats, time: float) -> tuple[Pair, Pair]:
    """Return origin and box of spheres over fixed ones on its floor, for a time [s]."""
    d, gravity = 2.0 * scene.bodies[0].radius, np.array(scene.gravity[:2]) @ axes
    fixed = [body.motion != "free" for body in scene.bodies]
    low = place[fixed].min(axis=0)
    x, y = (place - low).T
    speed = np.abs([body.velocity[:2] for body in scene.bodies] @ axes).max(axis=0)
    flight = speed * time + 0.5 * np.maximum([abs(gravity[0]), gravity[1]], 0.0) * time**2
    reach = float(flight[0]) + 3.0 * d
    origin = (reach - min(float(x.min()), 0.0) - float(low[0]), 0.5 * d - float(low[1]))
    height = 2.5 * d + max(float(y.max()), d) + float(flight[1])
    return origin, (float(np.ptp(x)) + 2.0 * reach, height)


# ---- frames


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
    Raise EngineOutputError for missing frames, a run that ended early, a lost mobile
    sphere, a fixed one that moved.
    """
    scene, h, numbers = system.scene, system.scene.step, range(1, system.mobile + 1)
    frames = {round(frame.time / h): frame for frame in grains}  # of several at a time the last
    states = [_states(frame) for frame in frames.values()]
    _check(system, [frame.time / h for frame in frames.values()], states)
    inside = [(at, row) for at, row in zip(frames, states, strict=True) if {*numbers} <= {*row}]
    if not scene.stages and len(inside) < len(frames):
        raise EngineOutputError(
            f"MFiX lost a mobile sphere: {len(inside)} of {len(frames)} frames have all of them"
        )
    step = np.array([at for at, _ in inside])
    state = np.array([[row[number] for number in numbers] for _, row in inside])
    place, velocity = np.split(state, 2, axis=-1)
    force = np.full(place.shape, np.nan)
    if system.line:  # of the start there are no forces
        forces = {round(chain.time / h): chain for chain in chains}
        place, velocity, force = _a_step_before(
            system, place[1:], velocity[1:], [forces.get(at) for at in step[1:].tolist()]
        )
        step = step[1:] - 1
    x, v, f = (_in_scene(system, part) for part in (place - system.origin, velocity, force))
    stages = stages_of(scene, step, x[:, 0, :2], v[:, 0, :2])
    last = scene.steps if stages is None else int(stages[-1, 0])
    kept = (step % scene.every == 0) & (step <= last)
    x, v, f, zero = x[kept], v[kept], f[kept], np.zeros_like(x[kept])
    for number, body in enumerate(scene.bodies[system.mobile :], system.mobile):
        x[:, number], v[:, number] = body.position, body.velocity
        f[:, number] = -f[:, :number].sum(axis=1) if system.line else np.nan
    return Motion(step[kept] * h, x, v, zero, f, np.where(np.isnan(f), np.nan, zero), None, stages)


def _in_scene(system: System, part: Floats) -> Floats:
    """Return vectors of mobile spheres (M, mobile, 2) as those of all bodies (M, N, 3)."""
    vectors = np.zeros((len(part), len(system.scene.bodies), 3))
    vectors[:, : system.mobile, :2] = part @ system.axes.T
    return vectors


def _a_step_before(
    system: System, place: Floats, velocity: Floats, chains: list[Frame | None]
) -> tuple[Floats, Floats, Floats]:
    """Return places, velocities and forces of a step before the frames, in a line.

    MFiX writes a step's positions with the forces that led to them: v' = v + h a, x' = x + h v', so
    they acted at x = x' - h v', v = v' - h a.
    """
    scene, h = system.scene, system.scene.step
    place = place - h * velocity
    rows = zip(chains, place[..., 1], strict=True)
    contacts = np.array([_forces(system, chain, heights) for chain, heights in rows])
    force = np.zeros_like(place)  # a contact pushes the sphere above it up, and the one below down
    force[..., 1] = np.diff(np.pad(contacts, ((0, 0), (1, 1))), axis=1)[:, : system.mobile]
    gravity = np.array(scene.gravity[:2]) @ system.axes
    return place, velocity - h * (gravity + force / scene.bodies[0].mass), force


def _states(frame: Frame) -> dict[int, Floats]:
    """Return x, y [m], vx, vy [m/s] by global id: the order in a file may change."""
    if "Particle_ID" not in frame.arrays:
        raise EngineOutputError("MFiX wrote particles without their global ids")
    state = np.hstack([frame.arrays[name][:, :2] for name in ("coordinates", "Velocity")])
    return dict(zip(frame.arrays["Particle_ID"][:, 0].astype(int).tolist(), state, strict=True))


def _forces(system: System, chain: Frame | None, heights: Floats) -> Floats:
    """Return the contact forces of particles in a line [N], each found by the contact's height."""
    heights = np.concatenate([heights, system.places[system.mobile :, 1]])
    middles, force = 0.5 * (heights[:-1] + heights[1:]), np.zeros(len(heights) - 1)
    if chain is not None:  # else nothing touches
        points = zip(chain.arrays["coordinates"], chain.arrays["FORCE_CHAIN_FN"], strict=True)
        for point, vector in points:
            force[np.abs(middles - point[1]).argmin()] = vector[1]
    return force


def _check(system: System, clock: list[float], states: list[dict[int, Floats]]) -> None:
    """Raise EngineOutputError for bad frames, by their steps on the clock and particles."""
    expected = system.every * np.arange(len(clock))
    expected[-1] = round(clock[-1])
    if np.abs(np.array(clock) - expected).max() > 0.1 or 1 not in states[0]:
        raise EngineOutputError(
            f"MFiX wrote {len(clock)} frames that are not every {system.every} steps from the start"
        )
    if not system.scene.stages and clock[-1] < system.steps - 0.5:
        raise EngineOutputError(f"MFiX ended at step {clock[-1]:.0f} of {system.steps}")
    fixed = range(system.mobile + 1, len(system.places) + 1)
    for state in states[1:2] + states[-1:]:  # a particle that is held is not written
        for number in state.keys() & {*fixed}:
            moved = state[number][:2] - system.places[number - 1]
            if np.hypot(*moved) > ROUNDINGS * max(system.box):
                raise EngineOutputError(
                    "MFiX moved a sphere that is to be held at a mass outflow of no velocity"
                )
