"""Paths and crests of an engine, held against those of the reference DEM sample by sample."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from harness.cases.grain import COLUMNS
from harness.cases.incline import tolerances
from harness.cases.incline.evidence import Recursion
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun, Motion
from harness.cases.incline.routes import energy, margin
from harness.cases.incline.runs import measured, run_inclines
from harness.cases.incline.single_runs import EVERY
from harness.cases.incline.template import Route
from harness.cases.runs import whole
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, judge
from harness.engines.reference.engine import Reference
from harness.engines.scene import LOOK
from harness.errors import EngineOutputError
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import Spring

PATH_TIME = 20.0
"""[sqrt(d/g)] over which paths are compared: rounding grows on every slow crest, by e a unit."""

MOTION_EVERY = 100
"""Steps between the samples of the motions that are compared."""

FIRST_CRESTS = 5
"""Crests over which round-off has not grown yet."""


def motion_rows(name: str, reference: Reference, run: InclineRun) -> list[Check]:
    """Hold a steady run over its first wells against the reference's: path and crests."""
    short = run.case.replace(time_limit=PATH_TIME)
    rows, own = _path(name, run, short, reference, "steady")
    first = min(FIRST_CRESTS, own.crests.time_s.size)
    return [*rows, *_at_crests(name, run, own, [(first, tolerances.REFERENCE_FIRST_CRESTS)])]


def passage_rows(name: str, reference: Reference, run: InclineRun) -> list[Check]:
    """Hold the path of a passage against the reference's."""
    return _path(name, run, run.case, reference, "passage")[0]


def _path(
    name: str, run: InclineRun, case: Incline, reference: Reference, route: Route
) -> tuple[list[Check], InclineRun]:
    """Hold a path against the reference's at every sample of the plan, and the energy told of it.

    Return the rows and the reference's run.
    """
    path, every = run.trajectory, EVERY if route == "passage" else MOTION_EVERY
    if path is None:
        raise EngineOutputError("it kept no path")
    own = whole(run_inclines(reference, [case], route, every=every)[0])
    # a code that is judged by its samples may end between two looks
    rows = own.path.time_s.size - LOOK // every
    if own.motion is not Motion.UNDECIDED and own.motion is not run.motion:
        raise EngineOutputError(f"it is {run.motion} where the reference DEM is {own.motion}")
    late = path.time_s[:rows].size < rows or not np.allclose(
        path.time_s[:rows], own.path.time_s[:rows], rtol=0.0, atol=0.5 * case.step
    )
    if late:
        raise EngineOutputError(
            f"its path of {path.time_s.size} samples does not have the {rows} times of the plan"
        )
    x, y, vx, vy = (
        getattr(path, column)[:rows] - getattr(own.path, column)[:rows]
        for column in ("x_m", "y_m", "vx_m_per_s", "vy_m_per_s")
    )
    apart = float(np.hypot(x, y).max()) / case.diameter
    faster = float(np.hypot(vx, vy).max()) / math.sqrt(case.gravity * case.diameter)
    near, slow = tolerances.REFERENCE_PATH, tolerances.REFERENCE_SPEED
    if route == "passage":
        near = slow = tolerances.REFERENCE_PASSAGE
    judged = [
        judge(f"{name}, largest distance", Kind.CROSS_CODE, apart, 0.0, near),
        judge(f"{name}, largest velocity apart", Kind.CROSS_CODE, faster, 0.0, slow),
        _told_energy(name, run, path, reference.traits.spring),
        _energy_rise(name, run, path, own.path, reference.traits.spring),
    ]
    return judged, own


def _energy_rise(
    name: str, run: InclineRun, path: Trajectory, own: Trajectory, spring: Spring
) -> Check:
    """Hold the largest rise of energy along the whole path against that of the reference's.

    Contacts only take energy: a wrong sample of position or velocity shows in it, also where
    round-off has grown too much for the paths to be compared.
    """
    known, found = (_rise(run.case, one, spring) for one in (own, path))
    name = f"{name}, largest rise of energy"
    return judge(name, Kind.CROSS_CODE, found, known, tolerances.ENERGY_RISE)


def _rise(case: Incline, path: Trajectory, spring: Spring) -> float:
    """Return the largest rise of energy over its lowest value before, along a path [m g d]."""
    total = energy(case, path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s, spring)
    return float((total - np.minimum.accumulate(total)).max()) / case.weight_energy


def _told_energy(name: str, run: InclineRun, path: Trajectory, spring: Spring) -> Check:
    """Hold the energy that a run tells of against that of the last sample of its path."""
    case = run.case
    well = max(1, run.crests.time_s.size + (run.motion is not Motion.MOVES_ON))
    x, y, vx, vy = (float(getattr(path, column)[-1]) for column in COLUMNS[1:])
    return judge(
        f"{name}, energy told and of its path",
        Kind.CROSS_CODE,
        run.margin,
        margin(case, well, x, y, vx, vy, spring) / case.weight_energy,
        tolerances.TOLD_ENERGY,
    )


def crests_rows(name: str, reference: Reference, recursion: Recursion) -> list[Check]:
    """Hold energy and time at every crest against the reference's."""
    run = recursion.run
    (own,) = measured(reference, [run.case], "steady")
    count = own.crests.time_s.size
    if run.crests.time_s.size != count:
        raise EngineOutputError(
            f"it passed {run.crests.time_s.size} crests, the reference DEM {count}"
        )
    held = [(FIRST_CRESTS, tolerances.REFERENCE_FIRST_CRESTS), (count, tolerances.REFERENCE_CRESTS)]
    return _at_crests(name, run, own, held)


def _at_crests(
    name: str, run: InclineRun, own: InclineRun, held: Sequence[tuple[int, Tolerance]]
) -> list[Check]:
    """Return the rows of the energy at so many crests as are held, and of the time at the most."""
    count = held[-1][0]
    if run.crests.time_s.size < count:
        raise EngineOutputError(f"it passed {run.crests.time_s.size} crests of {count}")
    ours, theirs = run.crests, own.crests
    margins = np.abs(ours.margin_J[:count] - theirs.margin_J[:count]) / run.case.weight_energy
    time = np.abs(ours.time_s[:count] - theirs.time_s[:count]) / run.case.step
    step = Tolerance("steps", 0.5, 0.0, "the same steps in two codes, counted")
    rows = [(f"energy, the worst of {some}", margins[:some], width) for some, width in held]
    return [
        judge(f"{name}, {what}", Kind.CROSS_CODE, float(apart.max(initial=0.0)), 0.0, width)
        for what, apart, width in [*rows, (f"time, the worst of {count}", time, step)]
    ]
