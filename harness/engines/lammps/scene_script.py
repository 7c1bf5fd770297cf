"""A scene as a plain script of LAMMPS, numbers in full, to be run and edited by hand."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Literal

from harness.engines.lammps.scene_atoms import Atoms, group_line
from harness.engines.lammps.words import AXES, MIXES_SUBMODELS, check_release, numbers_of
from harness.engines.output import release_of
from harness.engines.scripts import rendered
from harness.model.base import Vector
from harness.model.conventions import Rules
from harness.model.scene import ALL_AXES, Body, Scene, Segment

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


@lru_cache(maxsize=1024)  # refusals, checks and the reference each take them
def rules(scene: Scene, release: str | None = None) -> Rules:
    """Return the conventions by which LAMMPS runs a scene.

    ``release`` is its date, as in 29 Aug 2024, the newest unless given. Raise Unsupported for a
    scene that LAMMPS, or this release, cannot run.
    """
    script(scene)
    atoms = _atoms(scene, PLAIN)
    if release is not None:
        for law in atoms.laws:
            check_release(law, release)
    lever: Literal["radius", "contact_point"] = "radius" if atoms.is_old else "contact_point"
    return Rules(torque_lever=lever, least_overlap=ROUNDED_START if scene.stages else 0.0)


def needs_new_process(scene: Scene, variation: Variation, release: str | None) -> bool:
    """Return whether a release mixes into types the models of earlier scenes in memory."""
    early = release is not None and release_of(release) < release_of(MIXES_SUBMODELS)
    return early and _atoms(scene, variation).mixes


def script(scene: Scene, variation: Variation = PLAIN) -> str:
    """Return the LAMMPS script of a scene, which writes its samples to ``motion.dump``.

    Raise Unsupported for a scene that LAMMPS cannot run.
    """
    atoms, bodies = _atoms(scene, variation), scene.bodies
    discs, heats = atoms.are_discs(), any(law.heat != "none" for law in scene.all_laws)
    room, bounds = _room(scene), _bounds(scene, variation, flat=discs)
    edges = ["f" if period is None else "p" for period in scene.period]
    frozen = [body.motion == "frozen" for body in atoms.bodies]
    still = [not free for free in atoms.free]
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
        "groups": [
            line
            for name, members in (("free", atoms.free), ("frozen", frozen), ("still", still))
            for line in group_line(name, members)
        ],
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
        "runs": [*_runs(scene, variation)],
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


def _runs(scene: Scene, variation: Variation) -> Iterator[tuple[int, Segment | None, int]]:
    """Yield the first step of runs, velocities prescribed from it on, or None, and their steps."""
    starts, number = {}, 0
    for segment in scene.segments:
        starts[number] = segment
        number += segment.steps
    begins = sorted({0, *starts, *scene.setups, variation.pause} - {scene.steps})
    for begin, end in pairwise([*begins, scene.steps]):
        yield begin, starts.get(begin), end - begin


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
