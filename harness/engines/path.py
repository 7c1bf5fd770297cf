"""Read what became of a grain off its path: for engines that only write where it was."""

from __future__ import annotations

import math

import numpy as np

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Crests, InclineRun, Motion, Trajectory
from harness.engines.contract import Route
from harness.engines.routes import end_of, margin, overlaps
from harness.engines.springs import SpringLaw
from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance


def run_of_path(
    case: Incline,
    route: Route,
    path: Trajectory,
    who: Provenance,
    *,
    seconds: float,
    keep: bool = False,
    law: SpringLaw = "linear",
) -> InclineRun:
    """Return the run that a path tells of, judged at its samples as LAMMPS's script judges.

    A sample past the end of a well counts as its crest; one that moves back with
    less energy than the crest ahead asks for is trapped for good. The path may end as soon
    as that is decided; it is kept up to there if ``keep``. ``seconds`` is the wall time,
    ``law`` that of the engine's spring.
    Raise EngineNaNError for values that are not finite, EngineOutputError for a
    path that is not in order, or that ends undecided before the time limit.
    """
    t, state = path.time_s, (path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)
    if not all(np.isfinite(column).all() for column in (t, *state)):
        raise EngineNaNError(f"{who.engine} wrote a path with values that are not numbers")
    if t.size == 0 or np.any(np.diff(t) <= 0.0):
        raise EngineOutputError(f"{who.engine} wrote a path of {t.size} samples out of order")
    wells = 1 if route == "passage" else case.wells
    passed: list[tuple[float, float]] = []
    motion, row, well = Motion.MOVES_ON, 0, 0
    while motion is Motion.MOVES_ON and well < wells:
        well += 1
        margins = margin(case, well, *state, law)
        beyond = path.x_m > end_of(case, route, well, law)
        back = (path.vx_m_per_s < 0.0) & (margins < 0.0)
        decided = np.flatnonzero((beyond | back)[row:])
        if decided.size == 0:
            motion, row = Motion.UNDECIDED, t.size - 1
        else:
            row += int(decided[0])
            short = route == "passage" and margins[row] < 0.0
            motion = Motion.MOVES_ON if beyond[row] and not short else Motion.TRAPPED
        if motion is Motion.MOVES_ON:
            passed.append((float(t[row]), float(margins[row])))
    limit = case.time_limit * math.sqrt(case.diameter / case.gravity)
    if motion is Motion.UNDECIDED and t[-1] < limit * (1.0 - 1e-9) - case.step:
        raise EngineOutputError(
            f"{who.engine} wrote a path that ends at {t[-1]:g} s, undecided, before the time "
            f"limit of {limit:g} s"
        )
    crests = np.array(passed).reshape(-1, 2)
    return InclineRun(
        case=case,
        motion=motion,
        margin_J=float(margins[row]),
        touching=bool(max(overlaps(case, float(path.x_m[row]), float(path.y_m[row]))) > 0.0),
        crests=Crests(time_s=crests[:, 0], margin_J=crests[:, 1]),
        time_s=float(t[row]),
        steps=round(float(t[row]) / case.step),
        seconds=seconds,
        provenance=who,
        trajectory=Trajectory(*(column[: row + 1] for column in (t, *state))) if keep else None,
    )
