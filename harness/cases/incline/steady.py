"""Critical angle by *steady* motion, the source's definition: the smallest angle that keeps moving.

The grain starts with more energy than it needs and the excess shrinks by the
shock, about 1/4, from well to well: passing W wells resolves the energy to
4^-W of the excess. The outcome need not be monotone in the angle, so the
angles are scanned before they are bisected, and every interval between two
neighbours of different fate is refined.

Where in a step a contact begins decides on its shock. At coarse steps fates so mix over an interval
of angles, and where in it a run falls is a matter of its start: at 4.8 steps per contact (MFiX's
contact and scheme) and k = 1e5 N/m over 0.03 deg with 10 wells and over 0.007 deg with 100 (of 32
starts that differ by 3 % in speed, one moves on at 10.166 deg and the last at 10.173 deg), at
1e6 N/m over 0.01 and 0.002 deg. More wells trap more angles: there the value with 10 wells
lies 0.02 deg below that with 100. So at coarse steps more wells are passed, the angles around each
change of fate are probed, and the uncertainty reaches over all that these found mixed; at
1e5 N/m another start, or another step by 1e-4, may still move the value by 0.003 deg.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import Measure
from harness.cases.incline.result import InclineRun, Motion
from harness.errors import EngineOutputError

WINDOW = (9.8, 10.8)
SCAN = 6
FINE_SCAN = 8
MOST_UNDECIDED = 2
"""Between a trapped and a moving angle: with more undecided ones, stop asking."""

COARSE, COARSE_WELLS = 20.0, 100
"""Steps per contact below which fates are not taken to be monotone before they were probed, and
the wells to pass there."""

REACH, SPACING = 0.01, 5e-4
"""[deg] How far from a change of fate is probed, and the largest gap between the probes."""

MOST_RUNS = 600
"""With so many runs no more probes are made: fates that mix without an end."""


def critical_angle_by_steady_motion(
    measure: Measure,
    case: Incline,
    *,
    tolerance_deg: float = 5e-3,
    window: tuple[float, float] = WINDOW,
) -> CriticalAngle:
    """Return the smallest angle of ``case`` that keeps moving (its own angle is ignored).

    ``measure`` runs inclines in the steady route. The window is scanned, and
    widened within 0 to 30 deg until its lower end is trapped and its upper end
    moves; each interval in which the fate changes is scanned again, then
    bisected. Where steps are coarse or the outcome was not monotone, the angles around
    each change are probed until no probe finds another. The value is the middle of the lowest
    interval whose lower end is trapped and upper end moves; the uncertainty is half of it, and
    reaches up to the highest trapped angle where the outcome is not monotone. Undecided runs
    belong to neither side: they widen the interval.

    Raise EngineOutputError when the fate is the same at 0 and 30 deg, when no
    moving angle lies above a trapped one, or when nothing is decided.
    """
    runs = _scan(measure, case, window)
    parts = FINE_SCAN
    while angles := _inside_changes(runs, 2 * tolerance_deg, parts) or _probes(runs, case):
        fresh = measure([case.replace(angle=angle) for angle in angles])
        runs = sorted([*runs, *fresh], key=lambda run: run.case.angle)
        parts = 2
    return _result(runs, case)


def _scan(measure: Measure, case: Incline, window: tuple[float, float]) -> list[InclineRun]:
    """Run the window's angles, widening it until it holds the change of fate."""
    low, high = window
    runs = list(measure([case.replace(angle=float(a)) for a in np.linspace(low, high, SCAN)]))
    while runs[0].motion is not Motion.TRAPPED and low > 0.0:
        low = max(0.0, low - (high - low))
        runs.insert(0, measure([case.replace(angle=low)])[0])
    while runs[-1].motion is not Motion.MOVES_ON and high < 30.0:
        high = min(30.0, high + (high - low))
        runs.append(measure([case.replace(angle=high)])[0])
    if not any(run.motion is Motion.TRAPPED for run in runs):
        raise EngineOutputError("no angle from 0 to 30 deg was trapped")
    if not any(run.motion is Motion.MOVES_ON for run in runs):
        raise EngineOutputError("no angle from 0 to 30 deg kept moving")
    return runs


def _changes(runs: Sequence[InclineRun]) -> list[tuple[InclineRun, InclineRun]]:
    """Return the pairs of decided neighbours of different fate, undecided ones between them."""
    decided = [run for run in runs if run.motion is not Motion.UNDECIDED]
    pairs = itertools.pairwise(decided)
    return [(low, high) for low, high in pairs if low.motion is not high.motion]


def _inside_changes(runs: Sequence[InclineRun], width: float, parts: int) -> list[float]:
    """Return the angles that cut every change of fate wider than ``width`` into parts."""
    angles: list[float] = []
    for low, high in _changes(runs):
        ends = [r.case.angle for r in runs if low.case.angle <= r.case.angle <= high.case.angle]
        if ends[-1] - ends[0] <= width or len(ends) > MOST_UNDECIDED + 2:
            continue
        widest = int(np.argmax(np.diff(ends)))
        angles += np.linspace(ends[widest], ends[widest + 1], parts + 1)[1:-1].tolist()
    return angles


def _probes(runs: Sequence[InclineRun], case: Incline) -> list[float]:
    """Return angles that leave no wide gap around a change of fate, where it may not be the one."""
    changes = _changes(runs)
    if (len(changes) < 2 and case.steps_per_contact >= COARSE) or len(runs) >= MOST_RUNS:
        return []
    angles: list[float] = []
    for low, high in itertools.pairwise(run.case.angle for run in runs):
        near = [
            (max(low, a.case.angle - REACH), min(high, b.case.angle + REACH)) for a, b in changes
        ]
        start = min((start for start, end in near if end > start), default=high)
        end = max((end for start, end in near if end > start), default=low)
        if end - start > SPACING * (1.0 + 1e-9):
            angles += np.linspace(start, end, math.ceil((end - start) / SPACING) + 1).tolist()
    return sorted(set(angles) - {run.case.angle for run in runs})


def _result(runs: Sequence[InclineRun], case: Incline) -> CriticalAngle:
    rising = [(a, b) for a, b in _changes(runs) if b.motion is Motion.MOVES_ON]
    if not rising:
        raise EngineOutputError("no angle from 0 to 30 deg kept moving above a trapped one")
    low, high = rising[0]
    value = (low.case.angle + high.case.angle) / 2
    highest_trapped = max(r.case.angle for r in runs if r.motion is Motion.TRAPPED)
    first_moving = min(r.case.angle for r in runs if r.motion is Motion.MOVES_ON)
    monotone = highest_trapped < first_moving
    undecided = [r.case.angle for r in runs if r.motion is Motion.UNDECIDED]
    note = "" if monotone else f"not monotone: trapped again up to {highest_trapped:.5g} deg"
    if undecided:
        note += f"{'; ' if note else ''}{len(undecided)} angles undecided within the time limit"
    uncertainty = max(high.case.angle, rising[-1][1].case.angle) - value
    return CriticalAngle.of(
        runs,
        case,
        value,
        uncertainty_deg=uncertainty,
        mean_error_deg=uncertainty,
        method="steady",
        monotone=monotone,
        note=note,
    )
