"""Scenes in codes: samples as motions, files of scenes, and what such codes refuse.

:func:`check_scene` refuses what LIGGGHTS, Yade and Kratos have in common.
"""

from __future__ import annotations

import inspect
import json
import math
from abc import abstractmethod
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.engines.base import Job
from harness.engines.output import COLUMNS, SERIES, STAGES, TEMPERATURE, Output, Table
from harness.engines.process import text_of
from harness.engines.scripts import Script, ScriptedEngine, Task
from harness.errors import EngineNaNError, EngineOutputError, Unsupported
from harness.model.base import ZERO
from harness.model.law import Law
from harness.model.scene import LOOK, STAGE_COLUMNS, UNBOUNDED, Body, Floats, Motion, Scene, Wall

PARTS = tuple(COLUMNS)  # of a motion
FORCES = ("force", "torque")  # the parts that may be unknown
CLOCK_ERROR = 1e-5  # of the last time: a clock of six digits

# ---- motions of outputs and tables


def motion_in(output: Output, scene: Scene) -> Motion:
    """Return the motion in an output, of a scene with stages up to its end, checked."""
    stages = None
    if scene.stages:
        table = output.table(STAGE_COLUMNS, name=STAGES)
        stages = np.stack([table[name] for name in STAGE_COLUMNS], axis=1)
    return motion_of_table(output.engine, scene, output.tables.get(SERIES, {}), stages)


def motion_of_table(title: str, scene: Scene, table: Table, stages: Floats | None = None) -> Motion:
    """Return the motion in the columns of an engine's table, checked."""
    parts = {}
    for part, names in COLUMNS.items():
        try:
            parts[part] = np.stack([table[name] for name in names], axis=-1)
        except (KeyError, ValueError) as error:
            raise EngineOutputError(f"{title} left no samples of {part} ({error})") from None
    if any(law.heat != "none" for law in scene.all_laws):
        parts["temperature"] = table.get(TEMPERATURE, np.empty(0))
    motion = checked_motion(title, scene, table.get("step", ()), parts, stages)
    if "time_s" in table:
        check_clock(title, table["time_s"], motion.time)
    return motion


def check_clock(title: str, time: Floats, expected: Floats) -> None:
    """Raise EngineOutputError where a time [s] of samples, (M,) as expected, is not its step's."""
    wrong = np.flatnonzero(~(np.abs(time - expected) <= CLOCK_ERROR * expected[-1]))
    if wrong.size:
        place = wrong[0]
        raise EngineOutputError(
            f"{title} left a sample at {time[place]:.9g} s, where its step is at "
            f"{expected[place]:.9g} s"
        )


def checked_motion(
    title: str, scene: Scene, steps: Any, parts: Mapping[str, Any], stages: Floats | None = None
) -> Motion:
    """Return samples as a motion, after a check of steps, shapes and finiteness.

    ``parts`` are those of a motion, each (samples, bodies, 3), and the temperature where heat
    flows. ``stages`` (K, 7) are those of a scene with stages, whose last one ends the samples.
    Forces on bodies that are not free may be NaN, and components that a code never writes. Raise
    EngineOutputError, and EngineNaNError for a number that is not finite.
    """
    ends = _checked_stages(title, scene, stages) if scene.stages else None
    last = scene.steps if ends is None else int(ends[-1, 0])
    expected = np.arange(0, last + 1, scene.every)
    if not np.array_equal(steps, expected):
        raise EngineOutputError(f"{title} left {len(steps)} samples, not {len(expected)}")
    moved, bad = moved_bodies(scene), list[int]()  # places of samples
    for name, values in parts.items():
        shape = (len(expected), len(scene.bodies), 3)[: 2 if name == "temperature" else 3]
        if values.shape != shape:
            raise EngineOutputError(f"{title} left {name} of shape {values.shape}, not {shape}")
        finite = np.isfinite(values)
        if not finite.all() and name in FORCES:
            finite = finite[:, moved] | np.isnan(values).all(axis=(0, 1))
        bad += [] if finite.all() else np.argwhere(~finite)[:1, 0].tolist()
    if bad:
        step = expected[min(bad)]
        raise EngineNaNError(f"{title} wrote a value that is not finite (NaN) at step {step}")
    return Motion(np.float64(scene.step) * expected, **parts, stages=ends)


def moved_bodies(scene: Scene) -> list[bool]:
    """Return which bodies are free or moved by segments: the forces on others may be unknown."""
    return [bool(scene.segments) or body.motion == "free" for body in scene.bodies]


def unknown_parts(scene: Scene, motion: Motion) -> list[str]:
    """Return which of force and torque an engine does not write: all of it is NaN."""
    moved = moved_bodies(scene)
    return [name for name in FORCES if np.isnan(getattr(motion, name)[:, moved]).all()]


def _checked_stages(title: str, scene: Scene, stages: Floats | None) -> Floats:
    if stages is None or stages.ndim != 2 or stages.shape[1] != len(STAGE_COLUMNS):
        raise EngineOutputError(f"{title} left no {len(STAGE_COLUMNS)} columns of stages")
    if not np.isfinite(stages).all():
        raise EngineNaNError(f"{title} left a stage that is not finite (NaN)")
    steps = stages[:, 0]
    if len(steps) < 2 or steps[0] != 0 or steps[-1] > scene.steps or np.any(np.diff(steps) < 0):
        raise EngineOutputError(f"{title} left stages at steps {steps.tolist()}")
    return stages


# ---- stages of a path that was sampled


def stages_of(scene: Scene, step: NDArray[np.int64], x: Floats, v: Floats) -> Floats | None:
    """Return the stages of a path (M, 2) of the first body, by looks at its samples.

    For an engine that cannot look while it runs. None for a scene without stages. The last row is
    undecided where the path ends too early.
    """
    if not scene.stages:
        return None
    looked = ((step % LOOK == 0) | (step == scene.steps)) & (step <= scene.steps)
    rows = np.column_stack([step, step * scene.step, x, v, np.zeros(len(step))])[looked]
    energy, ends = _energy(scene, rows), [0]
    for stage in scene.stages:
        first = ends[-1] + 1
        beyond = rows[first:, 2] > stage.place
        stops = (rows[first:, 4] < 0.0) & (energy[first:] < stage.floor)
        ended = np.flatnonzero(beyond | stops)
        if len(ended):
            ends.append(first + ended[0])
        elif first < len(rows):
            ends.append(len(rows) - 1)
        if not (len(ended) and beyond[ended[0]]):
            break
    return np.asarray(rows[ends])


def decided(scene: Scene, stages: Floats) -> bool:
    """Return whether a path is over: beyond the last place, given up, or out of time."""
    last = stages[-1]
    passed = sum(row[2] > stage.place for row, stage in zip(stages[1:], scene.stages, strict=False))
    if passed == len(scene.stages) or last[0] >= scene.steps:
        return True
    return bool(last[4] < 0.0 and _energy(scene, last) < scene.stages[passed].floor)


def _energy(scene: Scene, rows: Floats) -> Floats:
    """Return the energy of the first body in gravity [J] at rows of stages (..., 7)."""
    gravity = np.array(scene.gravity[:2])
    specific = 0.5 * (rows[..., 4:6] ** 2).sum(axis=-1) - rows[..., 2:4] @ gravity
    return np.asarray(scene.bodies[0].mass * specific)


# ---- files of scenes


class SceneFileEngine(ScriptedEngine):
    """A code whose own Python runs scripts, and ``run_scenes.py`` on a file of scenes.

    ``run_scenes.py`` lies in the folder of the engine's module.
    """

    @abstractmethod
    def scene_words(self, scene: Scene) -> Mapping[str, Any]:
        """Return what the code calls a scene's law, as ``code`` of the scene's JSON."""

    def scene_task(self, job: Job) -> Task:
        """Return a job with ``run_scenes.py`` and the JSON of its scene."""
        scene = self.scene_of(job)
        values = {**scene.model_dump(mode="json"), "code": dict(self.scene_words(scene))}
        program = Path(inspect.getfile(type(self))).with_name("run_scenes.py")
        return Task(job, Script(program.name, program.read_text(encoding="utf-8")), values)

    def scene_script(self, job: Job) -> str:
        """Return ``run_scenes.py`` with a scene in place of the file; it writes ``0.json``."""
        task = self.scene_task(job)
        scenes = f"SCENES = r'''{json.dumps([task.values])}'''"
        return task.script.text.replace('SCENES = ""', scenes, 1)

    def read_scene(self, folder: Path, index: int, task: Task, _: float) -> Motion | None:
        """Return the motion in ``<index>.json``, None without the file."""
        return read_motion(self.title, folder, index, self.scene_of(task.job))


def read_motion(title: str, folder: Path, place: int, scene: Scene) -> Motion | None:
    """Return the motion in ``<place>.json``, None without the file.

    It has the sampled ``step``, the parts of a motion, each (samples, bodies, 3), and ``stages``
    of a scene with stages. Raise EngineOutputError for another shape, EngineNaNError for a number
    that is not finite.
    """
    text = text_of(folder / f"{place}.json")
    if not text:
        return None
    try:
        table = json.loads(text)
        steps, parts = table["step"], {name: np.array(table[name], float) for name in PARTS}
        stages = np.array(table["stages"], float) if scene.stages else None
    except (ValueError, TypeError, KeyError) as error:
        raise EngineOutputError(f"{title} wrote samples that cannot be read ({error})") from None
    motion = checked_motion(title, scene, steps, parts, stages)
    check_omitted_pairs(title, scene, motion)
    return motion


def check_omitted_pairs(title: str, scene: Scene, motion: Motion) -> None:
    """Raise EngineOutputError where two bodies met that must not touch by the scene's pairs."""
    for i, j in _omitted_pairs(scene):
        distance = np.linalg.norm(motion.position[:, i] - motion.position[:, j], axis=1)
        if (distance < scene.bodies[i].radius + scene.bodies[j].radius).any():
            raise EngineOutputError(f"{title} lets bodies {i} and {j} touch, the scene does not")


# ---- scenes that none of these codes can state


def check_scene(scene: Scene) -> None:
    """Raise Unsupported for a scene with more than spheres, planes across an axis and one law."""
    law, length, bodies, walls = scene.law, scene.period[0], scene.bodies, scene.walls
    places = [body.position[0] for body in bodies]
    refuse_any(
        (scene.laws, "gets one law for all contacts"),
        (_is_selective(scene), "lets all bodies touch one another"),
        (scene.drag, "has no drag"),
        (scene.period[1:] != UNBOUNDED[1:], "has periodic boundaries along x alone here"),
        (length is not None and walls, "has no walls beside periodic boundaries here"),
        (length is not None and max(places) - min(places) >= length, "starts within one period"),
        (scene.stages and scene.setups, "sets no forces up again between stages"),
        (law.interface == "old", "has one contact interface"),
        (law.two_moduli, "gets one material for both bodies"),
        (law.heat != "none", "conducts no heat here"),
        (not all(_stays_on_axes(scene, body) for body in bodies), "moves bodies along all axes"),
        (not all(_is_solid(body) for body in bodies), "has solid spheres, I = 2/5 m r^2"),
        (not all(_is_still_plane(wall) for wall in walls), "has planes at rest across an axis"),
        (any(wall.bodies is not None for wall in walls), "has walls that act on all bodies"),
    )


def refuse_any(*refusals: tuple[object, str]) -> None:
    """Raise Unsupported with the reason of the first true condition, of pairs of both."""
    for refused, reason in refusals:
        if refused:
            raise Unsupported(reason)


def check_words(law: Law, model: str, **allowed: str) -> None:
    """Raise Unsupported for a submodel that is none of the words of its part of a law."""
    for part, words in allowed.items():
        if getattr(law, part) not in words.split():
            must = " or ".join(words.split())
            raise Unsupported(f"its {model} takes {part} = {must}, not {getattr(law, part)}")


def check_stated(scene: Scene) -> None:
    """Raise Unsupported for a restitution or friction that the code itself would have to mix."""
    if scene.law.two_materials:
        raise Unsupported("gets restitution and friction of each pair, and mixes none")


def _omitted_pairs(scene: Scene) -> list[tuple[int, int]]:
    """Return the pairs of which one is free that ``pairs`` leaves out."""
    if scene.pairs is None:
        return []
    named = {frozenset(pair) for pair in scene.pairs}
    free = [body.motion == "free" for body in scene.bodies]
    every = combinations(range(len(free)), 2)
    return [(i, j) for i, j in every if (free[i] or free[j]) and {i, j} not in named]


def _is_selective(scene: Scene) -> bool:
    """Return whether a pair that may not touch is nearer than twice its reach at the start.

    One at a larger distance, as the next but one in a line, is watched by
    :func:`check_omitted_pairs`.
    """
    pairs = ((scene.bodies[i], scene.bodies[j]) for i, j in _omitted_pairs(scene))
    return any(
        math.dist(first.position, second.position) < 1.9 * (first.radius + second.radius)
        for first, second in pairs
    )


def _stays_on_axes(scene: Scene, body: Body) -> bool:
    """Return whether nothing pushes a body along an axis that it does not move along."""
    barred = [axis for axis in range(3) if not body.axes[axis]]
    level = [b.position[axis] == body.position[axis] for b in scene.bodies for axis in barred]
    pushed = [scene.gravity[axis] or body.velocity[axis] for axis in barred]
    return not barred or (all(level) and not any(pushed) and scene.law.tangential == "none")


def _is_solid(body: Body) -> bool:
    solid = 0.4 * body.mass * body.radius**2
    return math.isclose(body.moment_of_inertia, solid, rel_tol=1e-14)


def _is_still_plane(wall: Wall) -> bool:
    still = wall.velocity == wall.amplitude == wall.surface_velocity == ZERO
    return bool(wall.shape == "plane" and wall.axis is not None and still)


# ---- contacts of a scene


def partners(scene: Scene) -> list[tuple[Body, Body | None]]:
    """Return the pairs of bodies, one of each kind, that may touch; None is a wall."""
    bodies, pairs = scene.bodies, dict[Any, tuple[Body, Body | None]]()
    prescribed = bool(scene.segments)
    for i, first in enumerate(bodies):
        for second in (*bodies[i + 1 :], *([None] if scene.walls else [])):
            if prescribed or "free" in (first.motion, second and second.motion):
                pairs.setdefault((kind(first), second and kind(second)), (first, second))
    return list(pairs.values())


def kind(body: Body) -> tuple[float, float, str]:
    """Return the radius [m], mass [kg] and motion of a body, by which contacts differ."""
    return body.radius, body.mass, body.motion


def nearest_body(scene: Scene, wall: Wall) -> Body:
    """Return the body that is nearest to a plane across an axis at the start."""
    axis = wall.axis or 0
    return min(scene.bodies, key=lambda b: abs(b.position[axis] - wall.point[axis]) - b.radius)


def contact_mass(scene: Scene, first: Body, second: Body | None) -> float:
    """Return m* [kg] of two bodies, or of one at a wall (None).

    Frozen masses are infinite, unless segments move all bodies.
    """
    masses = [b.mass for b in (first, second) if b and (scene.segments or b.motion != "frozen")]
    return 1.0 / sum(1.0 / mass for mass in masses) if masses else first.mass


def damping_of(law: Law, mass: float) -> float:
    """Return the dashpot eta [kg/s] of a linear law and an effective mass [kg]."""
    return law.dashpot(mass, 1.0, 0.0)


def room(scene: Scene) -> float:
    """Return half the width of a box that no body leaves [m]."""
    g, radii = math.hypot(*scene.gravity), sum(body.radius for body in scene.bodies)
    speeds = [math.hypot(*body.velocity) for body in scene.bodies]
    speeds += [math.hypot(*v) for segment in scene.segments for v in segment.velocities]
    place = max(math.hypot(*body.position) for body in scene.bodies)
    far = place + scene.duration * max(speeds)
    return 4.0 * (far + radii + 0.5 * g * scene.duration**2)
