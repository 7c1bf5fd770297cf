"""Figure 4: the speed of the grain a little below and above the critical angle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from harness.cases.incline.parameters import Incline
from harness.cases.incline.recorded import PATHS, recorded_path
from harness.cases.incline.result import Motion
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.trajectory import Trajectory
from harness.reproduction.claims import Statement, untestable
from harness.reproduction.facts import claim_of_facts
from harness.reproduction.incline_runs import sampled
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle

ANGLES_DEG = (10.20, 10.22)
"""A hundredth of a degree either side of the source's 10.21 deg."""

_EVERY = 200  # steps between samples: 0.013 s, as the recorded runs


@dataclass(frozen=True)
class VelocitySeries:
    """The speed of one grain near the critical angle, and whether it kept moving.

    ``steps`` are in one contact time of the code.
    """

    code: str
    steps: float
    angle_deg: float
    moving: bool
    path: Trajectory

    @property
    def label(self) -> str:
        """Return code and steps: ``LAMMPS, 50 steps``."""
        return f"{self.code}, {self.steps:g} steps"


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
        return tuple(others), untestable(
            SOURCES["fig-4"], f"{error}", computed="the engine did not run"
        )
    return (*own, *others), judged(own, others)


def recorded_motions() -> dict[tuple[int, float], Trajectory]:
    """Return MFiX's paths by (its steps per contact time, angle [deg]), k = 1e6 N/m."""
    return {path: recorded_path(*path).trajectory for path in PATHS}


def as_series(motions: Mapping[tuple[int, float], Trajectory]) -> list[VelocitySeries]:
    """Return the recorded paths as velocity series, finest step and smallest angle first."""
    return [
        VelocitySeries("MFiX-DEM", steps, angle, not turns_back(path), path)
        for (steps, angle), path in sorted(motions.items(), key=lambda m: (-m[0][0], m[0][1]))
    ]


def turns_back(path: Trajectory) -> bool:
    """Return whether the grain ever moved uphill along the row.

    Without friction, a grain that turns back in a well has not the energy for the
    crest and stays. The small rebound in a well turns its velocity by less than
    the 60 deg left until it points uphill.
    """
    return bool((path.vx_m_per_s < 0).any())


def _own(engine: Engine, others: Sequence[VelocitySeries]) -> list[VelocitySeries]:
    """Run both angles for as many wells as the recorded grain that went farthest."""
    wells = max((math.ceil(s.path.x_m[-1] - s.path.x_m[0]) for s in others), default=20)
    cases = [Incline(angle=angle, wells=wells) for angle in ANGLES_DEG]
    return [
        VelocitySeries(
            run.provenance.engine.upper(),
            run.case.steps_per_contact,
            run.case.angle,
            run.motion is not Motion.TRAPPED,
            path,
        )
        for run, path in sampled(engine, cases, _EVERY)
    ]


def judged(own: Sequence[VelocitySeries], others: Sequence[VelocitySeries]) -> Statement:
    """Return the row: which runs stop below the closed form and move above it."""
    closed = critical_angle()
    every = (*own, *others)
    wrong = [series for series in every if not agrees(series, closed)]
    coarse = min((series.steps for series in others), default=math.nan)
    return claim_of_facts(
        SOURCES["fig-4"],
        [(agrees(series, closed), _in_words(series)) for series in every],
        f"The closed form is {closed:.4f} deg; k = 1e6 N/m, nominal e = 1e-20, steps in one "
        "contact time of the code.",
        corrected_holds=all(agrees(s, closed) for s in own)
        and all(s.steps == coarse for s in wrong),
        correction=f"not at MFiX's default of {coarse:g} steps, where the grain still moves below",
    )


def agrees(series: VelocitySeries, closed_deg: float) -> bool:
    """Return whether a grain moves on above the closed form, or stops below it."""
    return series.moving == (series.angle_deg > closed_deg)


def _in_words(series: VelocitySeries) -> str:
    fate = "moves on" if series.moving else "is trapped"
    gone = float(np.ptp(series.path.x_m))
    return (
        f"{series.label}, at {series.angle_deg:.2f} deg {fate} "
        f"({gone:.0f} d in {series.path.time_s[-1]:.0f} s)"
    )
