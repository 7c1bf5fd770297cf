"""The two routes of the incline, with the meaning that the LAMMPS script gives them."""

from __future__ import annotations

import time

import numpy as np

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Crests, InclineRun, Motion
from harness.cases.incline.routes import end_of, energy, margin, overlaps
from harness.cases.incline.springs import SpringLaw
from harness.engines.contract import Route
from harness.engines.reference.trajectory_integrator import TrajectoryIntegrator
from harness.observables.provenance import Provenance


def run(
    case: Incline,
    route: Route,
    mover: TrajectoryIntegrator,
    provenance: Provenance,
    *,
    sampled: bool,
    law: SpringLaw = "linear",
) -> InclineRun:
    """Move the grain by well after well (passage: one) and return what became of it.

    Dissipation only lowers the energy: a grain that turns back with less than the
    crest ahead asks for is trapped. Errors as for :meth:`TrajectoryIntegrator.watch`.
    """
    started = time.perf_counter()
    wells = 1 if route == "passage" else case.wells
    passed: list[tuple[float, float]] = []
    motion, well = Motion.MOVES_ON, 0
    while motion is Motion.MOVES_ON and well < wells:
        well += 1
        motion = _one_well(case, route, mover, well, law)
        if motion is Motion.MOVES_ON:
            passed.append((mover.time, margin(case, well, *mover.grain[:4], law)))
    crests = np.array(passed).reshape(-1, 2)
    return InclineRun(
        case=case,
        motion=motion,
        margin_J=float(margin(case, well, *mover.grain[:4], law)),
        touching=bool(max(overlaps(case, mover.grain.x, mover.grain.y)) > 0.0),
        crests=Crests(time_s=crests[:, 0], margin_J=crests[:, 1]),
        time_s=mover.time,
        steps=mover.steps,
        seconds=time.perf_counter() - started,
        provenance=provenance,
        trajectory=mover.trajectory() if sampled else None,
    )


@np.errstate(over="ignore", invalid="ignore")  # NaN is the mover's to name
def _one_well(
    case: Incline, route: Route, mover: TrajectoryIntegrator, well: int, law: SpringLaw
) -> Motion:
    """Return whether the grain passes the end of the well, is trapped before, or time is over."""
    place = end_of(case, route, well, law)
    here = mover.grain[:4]
    floor = float(energy(case, *here, law) - margin(case, well, *here, law))
    while True:
        mover.watch(place, floor)
        short = margin(case, well, *mover.grain[:4], law) < 0.0
        if mover.grain.x > place:
            return Motion.TRAPPED if route == "passage" and short else Motion.MOVES_ON
        if short and mover.grain.vx < 0.0:
            return Motion.TRAPPED
        if mover.over:
            return Motion.UNDECIDED
