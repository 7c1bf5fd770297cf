"""A scene as a plain script of LAMMPS, numbers in full, to be run and edited by hand."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from harness.engines.lammps.scene_atoms import Atoms, group_line
from harness.engines.lammps.words import AXES, MIXES_SUBMODELS, check_release, numbers_of
from harness.engines.output import release_of
from harness.model.base import Vector
from harness.model.conventions import Rules
from harness.model.scene import ALL_AXES, Body, Scene, Segment

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
    parts = _Script(scene, variation)
    lines, number = [*parts.settings(), *parts.box(), *parts.surroundings()], 0
    for segment, steps in _runs(scene, variation):
        if number and variation.restart:
            lines += [f"write_restart {RESTART}", "clear", *parts.settings()]
            lines += [f"read_restart {RESTART}", *parts.heat_store(), *parts.surroundings(number)]
        if segment is not None:
            rows = zip(segment.velocities, segment.angular_velocities, strict=True)
            lines += [_moving(atom, *row) for atom, row in enumerate(rows, 1)]
        setup = " pre no" if number and number == variation.pause else ""
        lines.append(f"run {steps}{setup} post no")
        number += steps
    return "\n".join([*lines, ""])


def _atoms(scene: Scene, variation: Variation) -> Atoms:
    how = variation.coefficients
    return Atoms(scene, own_types=how != "together", mixed=how == "mixed")


def _runs(scene: Scene, variation: Variation) -> Iterator[tuple[Segment | None, int]]:
    """Yield velocities that are prescribed from a step on, or None, and the steps of a run."""
    starts, number = {}, 0
    for segment in scene.segments:
        starts[number] = segment
        number += segment.steps
    begins = sorted({0, *starts, *scene.setups, variation.pause} - {scene.steps})
    for begin, end in zip(begins, [*begins[1:], scene.steps], strict=True):
        yield starts.get(begin), end - begin


class _Script:
    """The parts of the script of a scene."""

    def __init__(self, scene: Scene, variation: Variation) -> None:
        self.scene, self.variation = scene, variation
        self.atoms = _atoms(scene, variation)
        self.discs = self.atoms.are_discs()
        self.heats = any(law.heat != "none" for law in scene.all_laws)
        self.largest = max(body.radius for body in scene.bodies)
        columns: list[tuple[float, ...]] = [*zip(*(b.position for b in scene.bodies), strict=True)]
        self.spread = [(min(column), max(column)) for column in columns]
        self.room = self._room()

    @property
    def bin_size(self) -> float:
        """Return the size of bins, of which an edge lies in the middle of the box [m]."""
        return self.room / min(max(1, int(self.room / (4.0 * self.largest))), MOST_BINS)

    def _room(self) -> float:
        """Return half of the width of a box that no body leaves [m]."""
        scene, time = self.scene, self.scene.duration
        speeds = [_speed(b.velocity, b.angular_velocity, b.radius) for b in scene.bodies]
        speeds += [math.hypot(*velocity) for s in scene.segments for velocity in s.velocities]
        walls = [
            _speed(w.velocity, w.spin, w.radius or 0.0)
            + math.hypot(*w.surface_velocity)
            + w.frequency * math.hypot(*w.amplitude)
            for w in scene.walls
        ]
        path = 2.0 * time * (max(speeds) + max(walls, default=0.0))
        spread = max(high - low for low, high in self.spread)
        return 10.0 * self.largest + spread + path + time * time * math.hypot(*scene.gravity)

    def settings(self) -> list[str]:
        """Return the lines before the box."""
        v, edges = self.variation, ["f" if p is None else "p" for p in self.scene.period]
        grows = any(law.normal == "mdr" for law in self.atoms.laws)
        lines = [f"units {v.units}", f"atom_style sphere{' 1' if grows else ''}"]
        if self.discs:
            lines.append("dimension 2")
            edges[2] = "p"
        sort = f"{v.sort_every} {self.bin_size!r}" if v.sort_every else "0 0"
        lines += [
            f"atom_modify map array sort {sort}",
            f"newton {'on' if v.newton else 'off'}",
            "comm_modify vel yes",
            f"boundary {' '.join(edges)}",
        ]
        if v.ranks > 1:
            lines.append(f"processors {' '.join(map(str, v.grid))}")
        return lines

    def box(self) -> list[str]:
        """Return the box and the atoms in it."""
        bounds = self._bounds()
        lines = [
            f"region box block {numbers_of(x for pair in bounds for x in pair)} units box",
            f"create_box {max(self.atoms.types)} box",
            *self.heat_store(),
        ]
        for atom, (body, kind) in enumerate(
            zip(self.scene.bodies, self.atoms.types, strict=True), 1
        ):
            lines += self._atom_lines(atom, kind, body, [low for low, _ in bounds])
        return lines

    def _bounds(self) -> list[tuple[float, float]]:
        middle: Sequence[float] = [0.5 * (low + high) for low, high in self.spread]
        middle = self.variation.middle or middle
        halves = [self.room if p is None else 0.5 * p for p in self.scene.period]
        bounds = [(x - half, x + half) for x, half in zip(middle, halves, strict=True)]
        return [*bounds[:2], (-self.largest, self.largest)] if self.discs else bounds

    def _atom_lines(self, atom: int, kind: int, body: Body, lows: Sequence[float]) -> list[str]:
        """Return the lines of an atom, in its image of a periodic box."""
        periods, places, images = self.scene.period, [], []
        for x, low, period in zip(body.position, lows, periods, strict=True):
            image = 0 if period is None else math.floor((x - low) / period)
            images.append(image)
            places.append(x - image * (period or 0.0))
        warmth = f" temperature {body.temperature!r}" if self.heats else ""
        lines = [
            f"create_atoms {kind} single {numbers_of(places)} units box",
            f"set atom {atom} diameter {2.0 * body.radius!r} mass {body.mass!r}{warmth}",
            _moving(atom, body.velocity, body.angular_velocity),
        ]
        if any(images):
            rows = zip(images, periods, strict=True)
            words = " ".join("NULL" if period is None else str(image) for image, period in rows)
            lines.append(f"set atom {atom} image {words}")
        return lines

    def heat_store(self) -> list[str]:
        """Return the line that gives atoms a temperature."""
        return ["fix heat all property/atom temperature heatflow"] if self.heats else []

    def surroundings(self, start: int = 0) -> list[str]:
        """Return contacts, motion and samples, of a run that begins at a step."""
        append = f" append yes delay {start + 1}" if start else ""
        columns = f"{COLUMNS} c_warmth" if self.heats else COLUMNS
        return [
            *self._groups(),
            *self.atoms.pair_lines(),
            *self.atoms.wall_lines(),
            *self._neighbours(),
            f"timestep {self.scene.step!r}",
            *self._integration(),
            *(self._heat_flow() if self.heats else []),
            *self._forces(),
            f"dump motion all custom {self.scene.every} {SAMPLES} {columns}",
            f"dump_modify motion sort id format float %.17g{append}",
            "thermo 1000000000",
            "thermo_modify lost error norm no",
        ]

    def _groups(self) -> list[str]:
        free, frozen = self.atoms.free, [body.motion == "frozen" for body in self.atoms.bodies]
        still = [not moves for moves in free]
        groups = {"free": free, "frozen": frozen, "still": still}
        return [line for name, which in groups.items() for line in group_line(name, which)]

    def _neighbours(self) -> list[str]:
        v, atoms = self.variation, self.atoms
        skin = v.skin * min(body.radius for body in atoms.bodies)
        lines = [
            f"neighbor {skin!r} {'bin' if v.bins else 'nsq'}",
            f"neigh_modify delay 0 every 1 check {'no' if v.rebuild else 'yes'}",
        ]
        if v.bins:
            lines.append(f"neigh_modify binsize {self.bin_size!r}")
        if sum(not touching for touching in atoms.touching) > 1:
            lines.append("neigh_modify exclude group still still")
        pairs = [" ".join(map(str, atoms.type_pair(pair))) for pair in atoms.excluded]
        return [*lines, *(f"neigh_modify exclude type {types}" for types in pairs)]

    def _integration(self) -> list[str]:
        free, lines = self.atoms.free, []
        if any(free):
            group = "all" if all(free) else "free"
            lines.append(f"fix move {group} nve/sphere{' disc' if self.discs else ''}")
        if not all(free):
            lines.append(f"fix carry {'still' if any(free) else 'all'} nve/noforce")
        return lines

    def _heat_flow(self) -> Iterator[str]:
        yield "compute warmth all property/atom temperature"
        capacities = [body.heat_capacity for body in self.atoms.bodies]
        for number, capacity in enumerate(sorted(set(capacities)), 1):
            which = [other == capacity for other in capacities]
            group = "all" if all(which) else f"capacity{number}"
            yield from group_line(group, which)
            yield f"fix warm{number} {group} heat/flow constant {capacity!r}"

    def _forces(self) -> list[str]:
        """Return drag and weight; forces are stored between them, before any is set to zero."""
        scene, bodies, lines = self.scene, self.atoms.bodies, []
        group, weight = "all" if all(self.atoms.free) else "free", math.hypot(*scene.gravity)
        if scene.drag and any(self.atoms.free):
            lines.append(f"fix drag {group} viscous {scene.drag!r}")
        lines.append("fix contact all store/force  # of contacts and drag, without weight")
        if weight and any(self.atoms.free):
            vector = numbers_of(scene.gravity)
            lines.append(f"fix weight {group} gravity {weight!r} vector {vector}")
        for axes in sorted({b.axes for b in bodies if b.motion == "free"} - {ALL_AXES}):
            which = [body.motion == "free" and body.axes == axes for body in bodies]
            name = "along_" + "".join(a for a, moves in zip(AXES, axes, strict=True) if moves)
            forces = " ".join("NULL" if moves else "0.0" for moves in axes)
            guided = "all" if all(which) else name
            lines += [*group_line(name, which), f"fix {name} {guided} setforce {forces}"]
        if self.discs:
            lines.append("fix plane all enforce2d")
        if any(body.motion == "frozen" for body in bodies):
            lines.append("fix rest frozen freeze")
        return lines


def _speed(velocity: Vector, spin: Vector, radius: float) -> float:
    return math.hypot(*velocity) + radius * math.hypot(*spin)


def _moving(atom: int, velocity: Vector, spin: Vector) -> str:
    vx, vy, vz = velocity
    return f"set atom {atom} vx {vx!r} vy {vy!r} vz {vz!r} omega {numbers_of(spin)}"
