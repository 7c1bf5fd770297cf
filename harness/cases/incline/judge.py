"""Judge a grain by its path: for engines whose scripts write only where it was."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Crests, Motion
from harness.cases.incline.routes import end_of, margin, overlaps
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import Spring


class Judgement(NamedTuple):
    """The outcome of a path, decided at its sample ``row``; margin [J], time [s]."""

    motion: Motion
    margin_J: float
    touching: bool
    crests: Crests
    time_s: float
    row: int


class Looks(NamedTuple):
    """How the samples of a path are judged: (rows,) of the margin [J] over the crest after a well.

    ``end`` is the x [m] that ends a well; ``touching`` tells of a row whether the grain touches.
    """

    margin: Callable[[int], NDArray[np.float64]]
    end: Callable[[int], float]
    touching: Callable[[int], bool]
    allowed: float = 0.0
    """[J] margin up to which a grain that moves back is trapped."""


def judge(case: Incline, route: str, path: Trajectory, spring: Spring = "linear") -> Judgement:
    """Return the outcome of a path, judged at its samples as LAMMPS's script judges.

    ``spring`` is that of the engine.
    """
    state = (path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)

    def touching(row: int) -> bool:
        return bool(max(overlaps(case, float(path.x_m[row]), float(path.y_m[row]))) > 0.0)

    looks = Looks(
        lambda well: margin(case, well, *state, spring),
        lambda well: end_of(case, route, well, spring),
        touching,
    )
    return judge_by(looks, case, route, path)


def judge_by(looks: Looks, case: Incline, route: str, path: Trajectory) -> Judgement:
    """Return the outcome of a path by looks at its samples.

    A sample past the end of a well counts as its crest; one that moves back with
    less energy than the crest ahead asks for is trapped for good. The path may end as soon
    as that is decided.
    """
    t = path.time_s
    wells = 1 if route == "passage" else case.wells
    passed: list[tuple[float, float]] = []
    motion, row, well = Motion.MOVES_ON, 0, 0
    while motion is Motion.MOVES_ON and well < wells:
        well += 1
        margins = looks.margin(well)
        beyond = path.x_m > looks.end(well)
        back = (path.vx_m_per_s < 0.0) & (margins < looks.allowed)
        decided = np.flatnonzero((beyond | back)[row:])
        if decided.size == 0:
            motion, row = Motion.UNDECIDED, t.size - 1
        else:
            row += int(decided[0])
            short = route == "passage" and margins[row] < 0.0
            motion = Motion.MOVES_ON if beyond[row] and not short else Motion.TRAPPED
        if motion is Motion.MOVES_ON:
            passed.append((float(t[row]), float(margins[row])))
    crests = np.array(passed).reshape(-1, 2)
    return Judgement(
        motion,
        float(margins[row]),
        looks.touching(row),
        Crests(time_s=crests[:, 0], margin_J=crests[:, 1]),
        float(t[row]),
        row,
    )
