"""The critical angle of the incline in an engine."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from functools import partial
from typing import Any, Literal, TypeVar

from harness.cases.contract import Progress, silent
from harness.cases.incline.cost import PASSAGES, STEADY_RUNS
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.extrapolation import ExtrapolatedAngle, extrapolate
from harness.cases.incline.levels import Ladder
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import PHASES, Measure, check_passage, critical_angle_by_passage
from harness.cases.incline.result import InclineRun
from harness.cases.incline.runs import measured
from harness.cases.incline.steady import COARSE, COARSE_WELLS, critical_angle_by_steady_motion
from harness.cases.incline.template import Route
from harness.cases.runs import complete
from harness.engines.contract import Engine
from harness.engines.parallel import cores, parallel_map
from harness.engines.registry import open_engine
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.parameters.contact import PLASTIC

Angle = TypeVar("Angle")

Method = Literal["passage", "steady"]

TOLERANCES_DEG = {"passage": 1e-3, "steady": 5e-3}

TIME_PER_WELL = 40.0
"""[sqrt(d/g)] Least time limit of steady motion for each well."""


def critical_angle(
    case: Incline | None = None,
    *,
    method: Method = "passage",
    tolerance_deg: float | None = None,
    phases: int = PHASES,
    wells: int | None = None,
    engine: Engine | None = None,
    progress: Progress = silent,
) -> CriticalAngle:
    """Return the critical angle [deg] of a case (the source's contact unless told otherwise).

    ``tolerance_deg`` [deg] is how closely it is searched for.
    ``method`` is ``passage`` (root of the energy margin over one well) or
    ``steady`` (smallest angle that keeps moving, the source's definition);
    ``phases`` is how many starts within a step the passage is averaged over; ``wells`` are to be
    passed in steady motion: those of the case unless given, 100 or more at coarse steps.
    Without an engine, LAMMPS in-process is opened and closed again. ``progress`` is called with
    the runs done and those expected. Raise EngineError when the engine fails, RequestError for a
    contact that rebounds too much for a passage.
    """
    case = case or Incline()
    if method == "passage":
        check_passage(case)
    tolerance = TOLERANCES_DEG[method] if tolerance_deg is None else tolerance_deg
    with nullcontext(engine) if engine is not None else open_engine() as opened:
        if method == "steady":
            measure = _counted(opened, method, STEADY_RUNS, progress)
            asked = passing(case, wells)
            return critical_angle_by_steady_motion(measure, asked, tolerance_deg=tolerance)
        measure = _counted(opened, method, PASSAGES, progress)
        return critical_angle_by_passage(measure, case, tolerance_deg=tolerance, phases=phases)


def critical_angle_or_error(case: Incline, **options: Any) -> CriticalAngle | EngineError:
    """Return :func:`critical_angle`, or the error in its place.

    That a passage cannot measure a case is an error too: one case of many is no reason to lose the
    others, and a grain that flies where it should slide is the engine's doing.
    """
    try:
        return critical_angle(case, **options)
    except EngineError as error:
        return error
    except RequestError as error:
        return EngineOutputError(str(error))


def _counted(engine: Engine, route: Route, expected: int, progress: Progress) -> Measure:
    """Return what runs inclines in an engine and tells of it; the last runs of a search are told.

    How many there will be is known only then.
    """
    done = 0

    def measure(cases: Sequence[Incline]) -> list[InclineRun]:
        nonlocal done
        progress(f"runs, {route}", done, max(expected, done + len(cases)))
        found = measured(engine, cases, route)
        done += len(found)
        progress(f"runs, {route}", done, max(expected, done))
        return found

    return measure


def passing(case: Incline, wells: int | None) -> Incline:
    """Return a case with the wells to pass in steady motion, and the time for them."""
    if wells is None:
        wells = max(case.wells, COARSE_WELLS if case.steps_per_contact < COARSE else 0)
    return case.replace(wells=wells, time_limit=max(case.time_limit, TIME_PER_WELL * wells))


def critical_angles(
    cases: Sequence[Incline],
    engine: Engine,
    *,
    method: Method = "passage",
    phases: int = PHASES,
    stage: str = "critical angles",
    progress: Progress = silent,
) -> list[CriticalAngle | EngineError]:
    """Return the critical angle [deg] of each case, side by side; errors in place."""
    measure = partial(critical_angle_or_error, method=method, phases=phases, engine=engine)
    return side_by_side(measure, cases, stage, progress)


def side_by_side(
    measure: Callable[[Incline], Angle], cases: Sequence[Incline], stage: str, progress: Progress
) -> list[Angle]:
    """Return what ``measure`` makes of each case, over the cores; tell of the progress."""
    done, lock = 0, threading.Lock()

    def one(case: Incline) -> Angle:
        nonlocal done
        result = measure(case)
        with lock:
            done += 1
            progress(stage, done, len(cases))
        return result

    progress(stage, 0, len(cases))
    return parallel_map(one, cases, cores())


def extrapolated_critical_angle(
    case: Incline | None = None,
    *,
    ladder: Ladder | None = None,
    engine: Engine | None = None,
    stage: str = "extrapolation",
    progress: Progress = silent,
) -> ExtrapolatedAngle:
    """Return the critical angle [deg] with the step to zero, then the stiffness to infinity.

    The plastic contact unless a case says otherwise; passage route. Raise the
    first EngineError: a ladder with a rung missing is not extrapolated. Raise RequestError for a
    contact that rebounds too much for a passage, before any run.
    """
    case = case or Incline(contact=PLASTIC)
    rungs = (ladder or Ladder()).cases(case)
    check_passage(*rungs)
    with nullcontext(engine) if engine is not None else open_engine() as opened:
        angles = critical_angles(rungs, opened, stage=stage, progress=progress)
    return extrapolate(complete(angles))
