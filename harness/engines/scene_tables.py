"""Motions of scenes as tables of an output, and back.

The table ``series`` has the samples of all bodies, ``stages`` the start and the end of each stage
of the first body: :data:`harness.model.motion.STAGE_COLUMNS`, each (K,).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.engines.output import SERIES, Output, Table
from harness.errors import EngineNaNError, EngineOutputError
from harness.model.motion import STAGE_COLUMNS, Floats, Motion
from harness.model.scene import LOOK, Scene

COLUMNS = {
    "position": ("x_m", "y_m", "z_m"),
    "velocity": ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    "angular_velocity": ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
    "force": ("fx_N", "fy_N", "fz_N"),
    "torque": ("tx_N_m", "ty_N_m", "tz_N_m"),
}
TEMPERATURE = "temperature_K"
STAGES = "stages"


def motion_tables(motion: Motion, scene: Scene, *, sampled: bool = True) -> dict[str, Table]:
    """Return the tables of a motion; without samples where they are not wanted."""
    tables = {SERIES: motion_table(motion, scene)} if sampled else {}
    if motion.stages is not None:
        tables[STAGES] = dict(zip(STAGE_COLUMNS, motion.stages.T, strict=True))
    return tables


def motion_table(motion: Motion, scene: Scene) -> Table:
    """Return the samples of a motion as columns, (M,) and (M, N)."""
    steps = scene.every * np.arange(len(motion), dtype=np.float64)
    table = {"step": steps, "time_s": motion.time}
    for part, names in COLUMNS.items():
        table |= zip(names, np.moveaxis(getattr(motion, part), 2, 0), strict=True)
    return table if motion.temperature is None else {**table, TEMPERATURE: motion.temperature}


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
    return checked_motion(title, scene, table.get("step", ()), parts, stages)


def checked_motion(
    title: str, scene: Scene, steps: Any, parts: Mapping[str, Any], stages: Floats | None = None
) -> Motion:
    """Return samples as a motion, after a check of steps, shapes and finiteness.

    ``parts`` are those of a motion, each (samples, bodies, 3), and the temperature where heat
    flows. ``stages`` (K, 7) are those of a scene with stages, whose last one ends the samples.
    Forces on bodies that are not free may be NaN, and components that a code never writes. Raise
    EngineOutputError, and EngineNaNError for a number that is not finite.
    """
    last = scene.steps
    if scene.stages:
        last = int(_checked_stages(title, scene, stages)[-1, 0])
    expected = np.arange(0, last + 1, scene.every)
    if not np.array_equal(steps, expected):
        raise EngineOutputError(f"{title} left {len(steps)} samples, not {len(expected)}")
    free = [bool(scene.segments) or body.motion == "free" for body in scene.bodies]
    bad: list[int] = []  # places of samples
    for name, values in parts.items():
        shape = (len(expected), len(scene.bodies), 3)[: 2 if name == "temperature" else 3]
        if values.shape != shape:
            raise EngineOutputError(f"{title} left {name} of shape {values.shape}, not {shape}")
        checked = values
        if name in ("force", "torque"):
            checked = values[:, free][..., ~np.isnan(values).all(axis=(0, 1))]
        bad += np.argwhere(~np.isfinite(checked))[:1, 0].tolist()
    if bad:
        step = expected[min(bad)]
        raise EngineNaNError(f"{title} wrote a value that is not finite (NaN) at step {step}")
    ends = stages if scene.stages else None
    return Motion(np.float64(scene.step) * expected, **parts, stages=ends)


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
    mass, gravity = scene.bodies[0].mass, np.array(scene.gravity[:2])
    energy = mass * (0.5 * (rows[:, 4:6] ** 2).sum(axis=1) - rows[:, 2:4] @ gravity)
    ends, stage = [0], 0
    for place in range(1, len(rows)):
        beyond = rows[place, 2] > scene.stages[stage].place
        stops = rows[place, 4] < 0.0 and energy[place] < scene.stages[stage].floor
        if beyond:
            stage += 1
        if beyond or stops:
            ends.append(place)
        if stage == len(scene.stages) or (stops and not beyond):
            break
    else:
        ends += [len(rows) - 1] * (ends[-1] < len(rows) - 1)
    return np.asarray(rows[ends])


def decided(scene: Scene, stages: Floats) -> bool:
    """Return whether a path is over: beyond the last place, given up, or out of time."""
    *_, last = stages
    mass, gravity = scene.bodies[0].mass, np.array(scene.gravity[:2])
    passed = sum(row[2] > stage.place for row, stage in zip(stages[1:], scene.stages, strict=False))
    if passed == len(scene.stages) or last[0] >= scene.steps:
        return True
    energy = mass * (0.5 * (last[4:6] ** 2).sum() - last[2:4] @ gravity)
    return bool(last[4] < 0.0 and energy < scene.stages[passed].floor)
