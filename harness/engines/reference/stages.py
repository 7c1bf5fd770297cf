"""Move the grain by stage after stage, and make the tables of what it did."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harness.engines.output import SERIES, Table
from harness.engines.reference.row import Row
from harness.engines.reference.trajectory_integrator import TrajectoryIntegrator
from harness.engines.scene import STAGES, Scene, Stage

COLUMNS = ("step", "time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")


def tables_of(
    scene: Scene, mover: TrajectoryIntegrator, row: Row, origin: tuple[float, float]
) -> dict[str, Table]:
    """Run a scene and return its tables; ``origin`` [m] is that of the mover in the scene.

    Errors as for :meth:`TrajectoryIntegrator.watch`.
    """
    x0, y0 = origin
    raised = row.mass * (row.along * x0 + row.normal * y0)
    stages = [Stage(stage.place - x0, stage.floor + raised) for stage in scene.stages]
    ends, touches = _through(stages, mover, row)
    found: dict[str, Table] = {}
    if scene.stages:
        touching = {} if mover.touching is None else {"touching": np.array(touches, dtype=float)}
        found[STAGES] = {**_table(ends, origin), **touching}
    if scene.every is None:
        found[SERIES] = _table(ends, origin)
    else:
        samples = np.column_stack(list(vars(mover.trajectory()).values()))
        steps = scene.every * np.arange(len(samples))
        found[SERIES] = _table(np.column_stack([steps, samples]), origin)
    return found


def _through(
    stages: Sequence[Stage], mover: TrajectoryIntegrator, row: Row
) -> tuple[NDArray[np.float64], list[bool | None]]:
    """Return the rows of the start and of the end of each stage, or of the run without stages.

    And whether the grain touches in each.
    """
    rows, touches = [_row(mover)], [mover.touching]
    if not stages:
        mover.finish()
        rows.append(_row(mover))
    for stage in stages:
        passed = _passes(stage, mover, row)
        rows.append(_row(mover))
        touches.append(mover.touching)
        if not passed:
            break
    return np.array(rows, dtype=np.float64), touches


def _passes(stage: Stage, mover: TrajectoryIntegrator, row: Row) -> bool:
    """Move until the grain passes the stage's place, and return whether it does.

    Dissipation only lowers the energy: a grain that turns back with less than the floor never
    passes. One that turns back with more goes on.
    """
    while True:
        mover.watch(stage.place, stage.floor)
        if mover.grain.x > stage.place:
            return True
        if mover.over or (mover.grain.vx < 0.0 and mover.energy(row) < stage.floor):
            return False


def _row(mover: TrajectoryIntegrator) -> tuple[float, ...]:
    return (mover.steps, mover.time, *mover.grain[:4])


def _table(rows: NDArray[np.float64], origin: tuple[float, float]) -> Table:
    table = dict(zip(COLUMNS, rows.T.copy(), strict=True))
    table["x_m"] += origin[0]
    table["y_m"] += origin[1]
    return table
