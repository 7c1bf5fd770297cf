"""Figure 4: the speed of the grain a little below and above the critical angle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from harness.cases.incline.parameters import Incline
from harness.cases.incline.recorded import PATHS, recorded_path
from harness.cases.incline.result import InclineRun, Motion
from harness.cases.incline.runs import run_inclines
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.trajectory import Trajectory
from harness.reproduction.claims import Fact, Statement, claim_of_facts, untestable
from harness.theory.critical_angle import critical_angle

ANGLES_DEG = (10.20, 10.22)
"""A hundredth of a degree either side of the source's 10.21 deg: trapped, and moving."""

_EVERY = 200  # steps between samples: 0.013 s, as the recorded runs


@dataclass(frozen=True)
class VelocitySeries:
    """The speed of one grain near the critical angle, and whether it kept moving."""

    code: str
    steps: float  # in one contact time of the code
    angle_deg: float
    moving: bool
    path: Trajectory

    @property
    def label(self) -> str:
        """Return code and steps: ``LAMMPS, 50 steps``."""
        return f"{self.code}, {self.steps:g} steps"

    @property
    def fact(self) -> Fact:
        """Return whether it moves on above the closed form, or stops below it, in words."""
        fate = "moves on" if self.moving else "is trapped"
        text = (
            f"{self.label}, at {self.angle_deg:.2f} deg {fate} "
            f"({np.ptp(self.path.x_m):.0f} d in {self.path.time_s[-1]:.0f} s)"
        )
        return self.moving == (self.angle_deg > critical_angle()), text


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
        return tuple(others), untestable("fig-4", f"{error}", computed="the engine did not run")
    return (*own, *others), judged(own, others)


def recorded_motions() -> dict[tuple[int, float], Trajectory]:
    """Return MFiX's paths by (its steps per contact time, angle [deg]), k = 1e6 N/m."""
    return {path: recorded_path(*path) for path in PATHS}


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
    coarse = min((series.steps for series in others), default=math.nan)
    return claim_of_facts(
        "fig-4",
        [series.fact for series in (*own, *others)],
        corrected_holds=all(series.fact[0] for series in own)
        and all(series.fact[0] or series.steps == coarse for series in others),
        coarse=coarse,
        closed=critical_angle(),
    )


def sampled(
    engine: Engine, cases: Sequence[Incline], every: int
) -> list[tuple[InclineRun, Trajectory]]:
    """Run cases in steady motion; return each with its path, sampled every so many steps.

    Raise the first EngineError.
    """
    found = []
    for run in run_inclines(engine, cases, "steady", every=every):
        if isinstance(run, EngineError):
            raise run
        found.append((run, run.path))
    return found
