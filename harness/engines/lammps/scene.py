"""A scene as a plain script of LAMMPS, numbers in full; and by options that change no motion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from harness.engines.lammps.words import (
    AXES,
    MIXES_SUBMODELS,
    Atoms,
    check_release,
    group_line,
    names_of,
    numbers_of,
)
from harness.engines.lammps_language import runs_of
from harness.engines.output import release_of
from harness.engines.scripts import rendered
from harness.model.base import Vector
from harness.model.conventions import Rules
from harness.model.scene import ALL_AXES, Body, Floats, Scene

TEMPLATES = Path(__file__).with_name("templates")
SAMPLES, RESTART = "motion.dump", "motion.restart"
MOST_BINS = 8  # from the middle of the box on
# [r_i + r_j] the script of a grain in a well rounds its places: what just touches is no contact
ROUNDED_START = 1e-15
COLUMNS = (
    "id xu yu zu vx vy vz omegax omegay omegaz f_contact[1] f_contact[2] f_contact[3] tqx tqy tqz"
)


@dataclass(frozen=True, kw_only=True)
class Variation:
    """Options of LAMMPS that must not change a motion; the defaults are those of a plain script."""

    newton: bool = False  # one rank computes a pair of bodies of two ranks
    sort_every: int = 0  # [step] between sorts of bodies in memory, 0 for none
    bins: bool = False  # neighbours are searched in bins, not among all
    rebuild: bool = False  # a new neighbour list at every step, needed or not
    skin: float = 0.5  # [radius of the smallest body] of neighbour lists
    grid: tuple[int, int, int] = (1, 1, 1)  # of MPI ranks
    middle: Vector | None = None  # [m] of the box: an end of bins, and of an even number of ranks
    pause: int = 0  # [step] at which a run ends and goes on without a setup, 0 for none
    restart: bool = False  # each later setup follows a restart from a file
    coefficients: Literal["together", "by type", "mixed"] = "together"  # then bodies have own types
    units: Literal["si", "lj"] = "si"  # of the same numbers

    @property
    def ranks(self) -> int:
        """Return the number of MPI ranks."""
        return math.prod(self.grid)


PLAIN = Variation()


@lru_cache(maxsize=4096)  # refusals, checks and the reference each take them
def rules(scene: Scene, release: str | None = None) -> Rules:
    """Return the conventions by which LAMMPS runs a scene.

    ``release`` is its date, as in 29 Aug 2024, the newest unless given. Raise Unsupported for a
    scene that LAMMPS, or this release, cannot run.
    """
    script(scene, PLAIN)
    atoms = _atoms(scene, PLAIN)
    check_release((name for law in atoms.laws for name in names_of(law)), release)
    lever: Literal["radius", "contact_point"] = "radius" if atoms.is_old else "contact_point"
    return Rules(torque_lever=lever, least_overlap=ROUNDED_START if scene.stages else 0.0)


def needs_new_process(scene: Scene, variation: Variation, release: str | None) -> bool:
    """Return whether a release mixes into types the models of earlier scenes in memory."""
    early = release is not None and release_of(release) < release_of(MIXES_SUBMODELS)
    return early and _atoms(scene, variation).mixes


@lru_cache(maxsize=4096)  # the rules, the run and the report each take it
def script(scene: Scene, variation: Variation = PLAIN) -> str:
    """Return the LAMMPS script of a scene, which writes its samples to ``motion.dump``.

    Raise Unsupported for a scene that LAMMPS cannot run.
    """
    atoms, bodies = _atoms(scene, variation), scene.bodies
    discs, heats = atoms.are_discs(), any(law.heat != "none" for law in scene.all_laws)
    room, bounds = _room(scene), _bounds(scene, variation, flat=discs)
    edges = ["f" if period is None else "p" for period in scene.period]
    frozen = [body.motion == "frozen" for body in atoms.bodies]
    groups = {"free": atoms.free, "frozen": frozen, "still": [not free for free in atoms.free]}
    values = {
        "scene": scene,
        "variation": variation,
        "discs": discs,
        "grows": any(law.normal == "mdr" for law in atoms.laws),
        "edges": [*edges[:2], "p" if discs else edges[2]],
        # an edge of bins lies in the middle of the box
        "bin_size": room / max(1, int(min(room / (4.0 * _largest(scene)), MOST_BINS))),
        "bounds": bounds,
        "types": atoms.types,
        "images": [_image(scene, body, bounds) for body in bodies],
        "heats": heats,
        "capacities": _capacities(atoms),
        "groups": [line for name, members in groups.items() for line in group_line(name, members)],
        "free": atoms.free,
        "frozen": frozen,
        "movers": "all" if all(atoms.free) else "free",
        "guided": _guided(atoms),
        "weight": math.hypot(*scene.gravity),
        "pair_lines": atoms.pair_lines(),
        "wall_lines": [*atoms.wall_lines()],
        "skin": variation.skin * min(body.radius for body in bodies),
        "excludes_still": sum(not touching for touching in atoms.touching) > 1,
        "excluded": [atoms.type_pair(pair) for pair in atoms.excluded],
        "runs": [*runs_of(scene, variation.pause)],
        "samples": SAMPLES,
        "restart": RESTART,
        "columns": f"{COLUMNS} c_warmth" if heats else COLUMNS,
        **{"numbers_of": numbers_of, "any": any, "all": all, "zip": zip},
    }
    return rendered([TEMPLATES], "scene.in.j2", values)


def _atoms(scene: Scene, variation: Variation) -> Atoms:
    how = variation.coefficients
    return Atoms(scene, own_types=how != "together", mixed=how == "mixed")


def _capacities(atoms: Atoms) -> dict[float, tuple[str, list[str]]]:
    """Return group and its definition of the atoms of each heat capacity [J/K]."""
    capacities: dict[float, tuple[str, list[str]]] = {}
    for number, capacity in enumerate(sorted({body.heat_capacity for body in atoms.bodies}), 1):
        lines = group_line(f"capacity{number}", [b.heat_capacity == capacity for b in atoms.bodies])
        capacities[capacity] = f"capacity{number}" if lines else "all", lines
    return capacities


def _guided(atoms: Atoms) -> dict[str, tuple[str, list[str], str]]:
    """Return group, its definition and forces of the atoms that move along some axes alone."""
    guided, free = {}, [body for body in atoms.bodies if body.motion == "free"]
    for axes in sorted({body.axes for body in free} - {ALL_AXES}):
        name = "along_" + "".join(a for a, moves in zip(AXES, axes, strict=True) if moves)
        lines = group_line(name, [b.motion == "free" and b.axes == axes for b in atoms.bodies])
        forces = " ".join("NULL" if moves else "0.0" for moves in axes)
        guided[name] = name if lines else "all", lines, forces
    return guided


def _largest(scene: Scene) -> float:
    return max(body.radius for body in scene.bodies)


def _spread(scene: Scene) -> list[tuple[float, float]]:
    """Return the least and the largest place of bodies along each axis [m]."""
    columns: list[tuple[float, ...]] = [*zip(*(b.position for b in scene.bodies), strict=True)]
    return [(min(column), max(column)) for column in columns]


def _room(scene: Scene) -> float:
    """Return half of the width of a box that no body leaves [m]."""
    time = scene.duration
    speeds = [_speed(b.velocity, b.angular_velocity, b.radius) for b in scene.bodies]
    speeds += [math.hypot(*velocity) for s in scene.segments for velocity in s.velocities]
    walls = [
        _speed(w.velocity, w.spin, w.radius or 0.0)
        + math.hypot(*w.surface_velocity)
        + w.frequency * math.hypot(*w.amplitude)
        for w in scene.walls
    ]
    path = 2.0 * time * (max(speeds) + max(walls, default=0.0))
    spread = max(high - low for low, high in _spread(scene))
    return 10.0 * _largest(scene) + spread + path + time * time * math.hypot(*scene.gravity)


def _speed(velocity: Vector, spin: Vector, radius: float) -> float:
    return math.hypot(*velocity) + radius * math.hypot(*spin)


def _bounds(scene: Scene, variation: Variation, *, flat: bool) -> list[tuple[float, float]]:
    """Return the ends of the box along each axis [m]."""
    middle: Sequence[float] = [0.5 * (low + high) for low, high in _spread(scene)]
    middle, room = variation.middle or middle, _room(scene)
    halves = [room if period is None else 0.5 * period for period in scene.period]
    bounds = [(x - half, x + half) for x, half in zip(middle, halves, strict=True)]
    return [*bounds[:2], (-_largest(scene), _largest(scene))] if flat else bounds


def _image(
    scene: Scene, body: Body, bounds: Sequence[tuple[float, float]]
) -> tuple[list[float], str]:
    """Return the place of a body in a periodic box [m], and the words of its image if another."""
    places, images = [], []
    for x, (low, _), period in zip(body.position, bounds, scene.period, strict=True):
        image = 0 if period is None else math.floor((x - low) / period)
        images.append(image)
        places.append(x - image * (period or 0.0))
    rows = zip(images, scene.period, strict=True)
    words = " ".join("NULL" if period is None else str(image) for image, period in rows)
    return places, words if any(images) else ""


# ---- variations: the same scene by other options

ROOM = 40.0  # [radius] least length of a periodic box
CARRIED = (3.0, 2.5, 2.7)  # [radius] that a prescribed motion is carried along


class Row(NamedTuple):
    """A variation by its name, and the scene whose reference motion it must have."""

    name: str
    scene: Scene
    variation: Variation


def variations(scene: Scene) -> list[Row]:
    """Return the variations of a scene that apply to it.

    Where boundaries must be crossed, a prescribed motion without walls is carried along, which
    changes no force. A run that continues with a setup has the setup in its scene.
    """

    def row(name: str, **options: Any) -> Row:
        return Row(name, scene, Variation(**options))

    laws = Atoms(scene).laws
    mdr = any(law.normal == "mdr" for law in laws)  # it takes newton off, and one law
    rows = [
        row("neighbours from bins", bins=True),
        row("neighbours at every step", rebuild=True),
        row("thin skin", skin=_thin_skin(scene)),
    ]
    if not mdr:
        rows.append(row("newton on", newton=True))
        one_law = not scene.laws and scene.law.interface != "old" and not scene.law.two_materials
        if len(scene.bodies) > 1 and one_law:
            rows.append(row("styles by type", coefficients="by type"))
            rows.append(row("styles mixed", coefficients="mixed"))
    if all(length is None for length in scene.period):
        rows += _boundary_rows(_carried(scene), newton=not mdr)
    half, with_setup = scene.steps // 2 + 1, scene
    if not scene.segments:
        with_setup = scene.replace(setups=(*scene.setups, half))
        rows.append(row("continued without setup", pause=half))
        rows.append(Row("continued with a setup", with_setup, PLAIN))
    # LAMMPS dies in the setup after a restart of mdr, and oscillations begin anew
    if not mdr and not any(wall.frequency for wall in scene.walls):
        rows.append(Row("restarted", with_setup, Variation(restart=True)))
    return rows


def _thin_skin(scene: Scene) -> float:
    """Return a skin [radius of the smallest body], half of the shortest neck of jkr."""
    least = min(body.radius for body in scene.bodies)
    necks = [0.01]
    for law in Atoms(scene).laws:
        if law.normal == "jkr" and law.moduli and law.surface_energy:
            cube = 9.0 * math.pi * law.surface_energy * (0.5 * least) ** 2 / (4.0 * law.moduli[0])
            necks.append(0.5 * cube ** (2.0 / 3.0) / (1.5 * least) / least)
    return min(necks)


def _boundary_rows(scene: Scene, *, newton: bool) -> Iterator[Row]:
    """Yield sorts, ranks and periodic boundaries that the contact crosses halfway."""

    def row(name: str, middle: Floats, **options: Any) -> Row:
        return Row(name, scene, Variation(middle=_vector(middle), **options))

    place = _halfway(scene, scene.bodies[0].radius if len(scene.bodies) > 1 else 0.0)
    centre = _halfway(scene, 0.0)  # a sort exchanges the two while one is beyond it
    axis = _crossed_axis(scene)
    grid = (2 if axis == 0 else 1, 2 if axis == 1 else 1, 2 if axis == 2 else 1)
    sort = min(1000, max(1, scene.steps // 4))  # most runs are shorter than 1000, the default
    yield row("sorted at every step", centre, sort_every=1, bins=True, rebuild=True)
    yield row("defaults", centre, sort_every=sort, bins=True, newton=newton)
    yield row("two ranks", place, grid=grid, rebuild=True)
    if newton:
        yield row("two ranks, newton on", place, grid=grid, rebuild=True, newton=True)
    if all(wall.shape == "plane" for wall in scene.walls):
        length = ROOM * _largest(scene) + 4.0 * math.hypot(*_path(scene, 1.0))
        faced = [any(wall.direction[axis] for wall in scene.walls) for axis in range(3)]
        wrapped = scene.replace(period=tuple(None if wall else length for wall in faced))
        end = place + np.where(faced, 0.0, 0.5 * length)
        yield Row("periodic", wrapped, Variation(middle=_vector(end), rebuild=True))


def _vector(values: Floats) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


# ---- where the contact crosses a boundary


def _carried(scene: Scene) -> Scene:
    """Return a prescribed motion without walls, carried along; any other scene as it is."""
    if not scene.segments or scene.walls:
        return scene
    drift = _largest(scene) / scene.duration * np.array(CARRIED)

    def carry(velocity: Vector) -> Vector:
        return _vector(velocity + drift)

    bodies = tuple(b.replace(velocity=carry(b.velocity)) for b in scene.bodies)
    segments = tuple(s.replace(velocities=tuple(map(carry, s.velocities))) for s in scene.segments)
    return scene.replace(bodies=bodies, segments=segments)


def _path(scene: Scene, share: float) -> Floats:
    """Return how far the first body goes in a share of the run [m], were it free."""
    steps, path = share * scene.steps, np.zeros(3)
    pieces = [(s.steps, s.velocities[0]) for s in scene.segments]
    for count, velocity in pieces or [(scene.steps, scene.bodies[0].velocity)]:
        taken = min(float(count), steps)
        path += scene.step * taken * np.array(velocity)
        steps -= taken
    return path


def _normal(scene: Scene) -> Floats:
    """Return the normal of the first contact: of two bodies, or of a wall."""
    if len(scene.bodies) == 1:
        return np.array(scene.walls[0].direction if scene.walls else (0.0, 0.0, 1.0))
    first, second = scene.bodies[:2]
    distance = np.subtract(first.position, second.position)
    return np.asarray(distance / np.linalg.norm(distance))


def _halfway(scene: Scene, lever: float) -> Floats:
    """Return where the first contact is after half of the run, if it slides along its plane [m].

    ``lever`` [m] is that from the first body's centre to it.
    """
    normal, half = _normal(scene), _path(scene, 0.5)
    along = 0.0 if scene.segments else half @ normal
    return np.asarray(scene.bodies[0].position + half - (along + lever) * normal)


def _crossed_axis(scene: Scene) -> int:
    """Return the axis along which the contact goes farthest, or that its normal is nearest to."""
    path, normal = _path(scene, 1.0), _normal(scene)
    lengths = np.abs(path - (path @ normal) * normal)
    if lengths.max() < 1e-9 * scene.bodies[0].radius:
        lengths = np.abs(normal)
    return int(lengths.argmax())
