"""Motions of scenes as tables of an output, and back.

The table ``series`` has the samples of all bodies, ``stages`` the start and the end of each stage
of the first body: :data:`harness.model.motion.STAGE_COLUMNS`, each (K,).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from harness.engines.output import SERIES, Output, Table
from harness.errors import EngineNaNError, EngineOutputError
from harness.model.motion import STAGE_COLUMNS, Floats, Motion

if TYPE_CHECKING:
    from harness.model.scene import Scene

PARTS = {
    "position": ("x_m", "y_m", "z_m"),
    "velocity": ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s"),
    "angular_velocity": ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"),
    "force": ("fx_N", "fy_N", "fz_N"),
    "torque": ("tx_N_m", "ty_N_m", "tz_N_m"),
}
TEMPERATURE = "temperature_K"
STAGES = "stages"


def motion_tables(motion: Motion, scene: Scene, *, sampled: bool = True) -> dict[str, Table]:
    """Return the tables of a motion; samples are left out where they are not wanted."""
    tables = {SERIES: motion_table(motion, scene)} if sampled else {}
    if motion.stages is not None:
        tables[STAGES] = dict(zip(STAGE_COLUMNS, motion.stages.T, strict=True))
    return tables


def motion_table(motion: Motion, scene: Scene) -> Table:
    """Return the samples of a motion as columns, (M,) and (M, N)."""
    steps = scene.every * np.arange(len(motion), dtype=np.float64)
    table = {"step": steps, "time_s": motion.time}
    for part, names in PARTS.items():
        table |= zip(names, np.moveaxis(getattr(motion, part), 2, 0), strict=True)
    return table if motion.temperature is None else {**table, TEMPERATURE: motion.temperature}


def motion_in(output: Output, scene: Scene) -> Motion:
    """Return the motion in an output, of a scene with stages up to its end.

    Raise EngineOutputError for samples that are missing or of another shape, EngineNaNError for
    one that is not finite; forces on frozen bodies may be unknown, and those of a code that writes
    none are.
    """
    table = output.tables.get(SERIES, {})
    stages = _stages(output) if scene.stages else None
    last = scene.steps if stages is None else int(stages[-1, 0])
    steps = scene.every * np.arange(last // scene.every + 1)
    if not np.array_equal(table.get("step", ()), steps):
        found = len(table.get("step", ()))
        raise EngineOutputError(f"{output.who} left {found} samples, not {len(steps)}")
    warms = any(law.heat != "none" for law in scene.all_laws)
    names = [name for names in PARTS.values() for name in names] + [TEMPERATURE] * warms
    for name in names:
        _check_column(output, name, scene, len(steps))
    parts = {part: np.stack([table[n] for n in names], axis=2) for part, names in PARTS.items()}
    times = np.asarray(steps * scene.step, dtype=np.float64)
    return Motion(times, **parts, temperature=table[TEMPERATURE] if warms else None,
                  stages=stages)  # fmt: skip


def _stages(output: Output) -> Floats:
    table = output.table(STAGE_COLUMNS, name=STAGES)
    return np.stack([table[name] for name in STAGE_COLUMNS], axis=1)


def _check_column(output: Output, name: str, scene: Scene, samples: int) -> None:
    column = output.tables[SERIES].get(name)
    shape = (samples, len(scene.bodies))
    if column is None or column.shape != shape:
        found = "no samples" if column is None else f"samples of shape {column.shape}"
        raise EngineOutputError(f"{output.who} left {found} of {name}, not {shape}")
    of_force = name in (*PARTS["force"], *PARTS["torque"]) and not scene.segments
    known = [not of_force or body.motion == "free" for body in scene.bodies]
    if of_force and np.isnan(column).all():  # of a code that writes none
        return
    if not np.isfinite(column[:, known]).all():
        raise EngineNaNError(f"{output.who} left a value of {name} that is not finite (NaN)")
