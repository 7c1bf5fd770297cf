"""The same scene by other options of LAMMPS, which must not change its motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from harness.engines.lammps.scene_atoms import Atoms
from harness.engines.lammps.scene_script import Variation
from harness.model.base import Vector
from harness.model.scene import Scene

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
    laws = Atoms(scene).laws
    rows = list(_neighbour_rows(scene))
    if not any(law.normal == "mdr" for law in laws):  # which takes newton off, and one law
        rows.append(Row("newton on", scene, Variation(newton=True)))
        rows += _coefficient_rows(scene)
    return [*rows, *_boundary_rows(scene), *_continued_rows(scene)]


def _neighbour_rows(scene: Scene) -> Iterator[Row]:
    yield Row("neighbours from bins", scene, Variation(bins=True))
    yield Row("neighbours at every step", scene, Variation(rebuild=True))
    yield Row("thin skin", scene, Variation(skin=_thin_skin(scene)))


def _thin_skin(scene: Scene) -> float:
    """Return a skin [radius of the smallest body], half of the shortest neck of jkr."""
    least = min(body.radius for body in scene.bodies)
    necks = [0.01]
    for law in Atoms(scene).laws:
        if law.normal == "jkr" and law.moduli and law.surface_energy:
            cube = 9.0 * math.pi * law.surface_energy * (0.5 * least) ** 2 / (4.0 * law.moduli[0])
            necks.append(0.5 * cube ** (2.0 / 3.0) / (1.5 * least) / least)
    return min(necks)


def _coefficient_rows(scene: Scene) -> Iterator[Row]:
    if len(scene.bodies) == 1 or scene.laws or scene.law.interface == "old":
        return
    if not scene.law.two_materials:
        yield Row("styles by type", scene, Variation(coefficients="by type"))
        yield Row("styles mixed", scene, Variation(coefficients="mixed"))


def _boundary_rows(scene: Scene) -> Iterator[Row]:
    """Yield sorts, ranks and periodic boundaries that the contact crosses halfway."""
    if any(length is not None for length in scene.period):
        return
    scene = _carried(scene)
    place, newton = _halfway(scene), not any(law.normal == "mdr" for law in Atoms(scene).laws)
    centre = _halfway(scene, lever=0.0)  # a sort exchanges the two while one is beyond it
    axis = _crossed_axis(scene)
    grid = (2 if axis == 0 else 1, 2 if axis == 1 else 1, 2 if axis == 2 else 1)
    yield Row("sorted at every step", scene,
              Variation(sort_every=1, bins=True, rebuild=True, middle=centre))  # fmt: skip
    sort = min(1000, max(1, scene.steps // 4))  # most runs are shorter than 1000, the default
    yield Row("defaults", scene,
              Variation(sort_every=sort, bins=True, newton=newton, middle=centre))  # fmt: skip
    yield Row("two ranks", scene, Variation(grid=grid, rebuild=True, middle=place))
    if newton:
        yield Row("two ranks, newton on", scene,
                  Variation(grid=grid, rebuild=True, newton=True, middle=place))  # fmt: skip
    yield from _periodic_rows(scene, place)


def _periodic_rows(scene: Scene, place: Vector) -> Iterator[Row]:
    """Yield the scene in a box that ends at a place, along the axes that no wall faces."""
    if any(wall.shape != "plane" for wall in scene.walls):
        return
    radius = max(body.radius for body in scene.bodies)
    length = ROOM * radius + 4.0 * math.hypot(*_path(scene, 1.0))
    faced = [any(wall.direction[axis] for wall in scene.walls) for axis in range(3)]
    ends = [x if wall else x + 0.5 * length for x, wall in zip(place, faced, strict=True)]
    periods = [None if wall else length for wall in faced]
    wrapped = scene.replace(period=tuple(periods))
    yield Row("periodic", wrapped, Variation(middle=(ends[0], ends[1], ends[2]), rebuild=True))


def _continued_rows(scene: Scene) -> Iterator[Row]:
    """Yield a run that ends between two samples and goes on, and restarts from a file."""
    half, laws = scene.steps // 2 + 1, Atoms(scene).laws
    # LAMMPS dies in the setup after a restart of mdr, and oscillations begin anew
    may_restart = not any(law.normal == "mdr" for law in laws) and not any(
        wall.frequency for wall in scene.walls
    )
    with_setup = scene
    if not scene.segments:
        with_setup = scene.replace(setups=(*scene.setups, half))
        yield Row("continued without setup", scene, Variation(pause=half))
        yield Row("continued with a setup", with_setup, Variation())
    if may_restart:
        yield Row("restarted", with_setup, Variation(restart=True))


# ---- where the contact crosses a boundary


def _carried(scene: Scene) -> Scene:
    """Return a prescribed motion without walls, carried along; any other scene as it is."""
    if not scene.segments or scene.walls:
        return scene
    speed = max(body.radius for body in scene.bodies) / scene.duration

    def carry(velocity: Vector) -> Vector:
        x, y, z = (v + speed * c for v, c in zip(velocity, CARRIED, strict=True))
        return (x, y, z)

    bodies = tuple(b.replace(velocity=carry(b.velocity)) for b in scene.bodies)
    segments = tuple(s.replace(velocities=tuple(map(carry, s.velocities))) for s in scene.segments)
    return scene.replace(bodies=bodies, segments=segments)


def _path(scene: Scene, share: float) -> Vector:
    """Return how far the first body goes in a share of the run [m], were it free."""
    steps, path = share * scene.steps, [0.0, 0.0, 0.0]
    pieces = [(s.steps, s.velocities[0]) for s in scene.segments]
    for count, velocity in pieces or [(scene.steps, scene.bodies[0].velocity)]:
        taken = min(float(count), steps)
        path = [x + scene.step * taken * v for x, v in zip(path, velocity, strict=True)]
        steps -= taken
    return (path[0], path[1], path[2])


def _normal(scene: Scene) -> Vector:
    """Return the normal of the first contact: of two bodies, or of a wall."""
    if len(scene.bodies) == 1:
        return scene.walls[0].direction if scene.walls else (0.0, 0.0, 1.0)
    first, second = scene.bodies[:2]
    distance = [p - q for p, q in zip(first.position, second.position, strict=True)]
    length = math.hypot(*distance)
    return (distance[0] / length, distance[1] / length, distance[2] / length)


def _halfway(scene: Scene, lever: float | None = None) -> Vector:
    """Return where the first contact is after half of the run, if it slides along its plane.

    ``lever`` [m] from the first body's centre to it is its radius where another body is.
    """
    first, normal, half = scene.bodies[0], _normal(scene), _path(scene, 0.5)
    along = 0.0 if scene.segments else sum(p * n for p, n in zip(half, normal, strict=True))
    if lever is None:
        lever = first.radius if len(scene.bodies) > 1 else 0.0
    rows = zip(first.position, half, normal, strict=True)
    x, y, z = (start + path - (along + lever) * n for start, path, n in rows)
    return (x, y, z)


def _crossed_axis(scene: Scene) -> int:
    """Return the axis along which the contact goes farthest, or that its normal is nearest to."""
    path, normal = _path(scene, 1.0), _normal(scene)
    along = sum(p * n for p, n in zip(path, normal, strict=True))
    lengths = [abs(p - along * n) for p, n in zip(path, normal, strict=True)]
    if max(lengths) < 1e-9 * scene.bodies[0].radius:
        lengths = [abs(n) for n in normal]
    return lengths.index(max(lengths))
