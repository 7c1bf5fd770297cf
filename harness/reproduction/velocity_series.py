"""Figure 4: the speed of the grain a little below and above the critical angle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Motion
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.trajectory import Trajectory
from harness.reproduction.claims import Statement, claim, untestable
from harness.reproduction.figure_data import VelocitySeries
from harness.reproduction.recorded_motion import as_series
from harness.reproduction.sentences import agreement
from harness.reproduction.source_figures import FIGURES
from harness.theory.critical_angle import critical_angle

ANGLES_DEG = (10.20, 10.22)
"""A hundredth of a degree either side of the source's 10.21 deg."""

_FIGURE = FIGURES["fig-4"]
_EVERY = 200  # steps between samples: 0.013 s, as the recorded runs


def velocity_series(
    engine: Engine | None, recorded: Mapping[tuple[int, float], Trajectory]
) -> tuple[tuple[VelocitySeries, ...], Statement]:
    """Run the source's contact in ``engine`` beside the recorded MFiX runs.

    Without an engine, or with one that fails, the recorded runs stand alone and
    the statement says why it cannot be tested.
    """
    others = as_series(recorded)
    try:
        if engine is None:
            raise EngineError("no engine was given")
        own = _own(engine, others)
    except EngineError as error:
        return tuple(others), untestable(_FIGURE.source, f"{error}", computed="LAMMPS did not run")
    return (*own, *others), judged(own, others)


def _own(engine: Engine, others: Sequence[VelocitySeries]) -> list[VelocitySeries]:
    """Run both angles for as many wells as the recorded grain that went farthest."""
    wells = max((math.ceil(s.path.x_m[-1] - s.path.x_m[0]) for s in others), default=20)
    cases = [Incline(angle=angle, wells=wells) for angle in ANGLES_DEG]
    series = []
    for run in engine.inclines(cases, "steady", every=_EVERY):
        if isinstance(run, EngineError):
            raise run
        code = f"LAMMPS, {run.case.steps_per_contact:g} steps"
        assert run.trajectory is not None
        moving = run.motion is not Motion.TRAPPED
        series.append(VelocitySeries(code, run.case.angle, moving, run.trajectory))
    return series


def judged(own: Sequence[VelocitySeries], others: Sequence[VelocitySeries]) -> Statement:
    """Return the row: which runs stop below the closed form and move above it."""
    closed = critical_angle()
    every = (*own, *others)
    facts = [(agrees(series, closed), _told(series)) for series in every]
    wrong = [series for series in every if not agrees(series, closed)]
    coarse = min((_steps(series) for series in others), default=math.nan)
    computed = agreement(
        facts,
        f"The closed form is {closed:.4f} deg; k = 1e6 N/m, nominal e = 1e-20, steps in one "
        "contact time of the code.",
    )
    return claim(
        _FIGURE.source,
        holds=not wrong,
        corrected_holds=all(agrees(s, closed) for s in own)
        and all(_steps(s) == coarse for s in wrong),
        correction=f"not at MFiX's default of {coarse:g} steps, where the grain still moves below",
        computed=computed,
        evidence=_FIGURE.evidence,
        why="a run agrees if it stops below the closed form, or moves on above it",
    )


def agrees(series: VelocitySeries, closed_deg: float) -> bool:
    """Return whether a grain moves on above the closed form, or stops below it."""
    return series.moving == (series.angle_deg > closed_deg)


def _steps(series: VelocitySeries) -> float:
    return float(series.code.rsplit(", ", 1)[1].removesuffix(" steps"))


def _told(series: VelocitySeries) -> str:
    fate = "moves on" if series.moving else "is trapped"
    gone = float(np.ptp(series.path.x_m))
    return (
        f"{series.code}, at {series.angle_deg:.2f} deg {fate} "
        f"({gone:.0f} d in {series.path.time_s[-1]:.0f} s)"
    )
