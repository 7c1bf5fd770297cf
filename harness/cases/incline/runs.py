"""Run inclines in an engine, and read what comes back."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.grain import COLUMNS, complete, path_in, run_jobs
from harness.cases.incline.system import (
    Crests,
    Incline,
    InclineRun,
    Judgement,
    Motion,
    Route,
    Start,
    job_of,
    judge,
    scene_of,
    values_of,
)
from harness.engines.contract import Engine, Output
from harness.engines.output import SERIES, SHOWN, Table
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.observables.reference import Trajectory
from harness.parameters.plane_scene import STAGES
from harness.parameters.scene import ContactScene

if TYPE_CHECKING:
    from harness.engines.reference import Reference

TOUCHING = {"0": False, "1": True}

CLOCK = 1e-5
"""Relative error of a time that is written with six digits."""


def run_inclines(
    engine: Engine, cases: Sequence[Incline], route: Route, *, every: int | None = None
) -> list[InclineRun | EngineError]:
    """Run the cases, in parallel where that helps, and return their results in order.

    With ``every``, the grain's path is sampled every so many steps. Raise RequestError for a
    case that the engine cannot state.
    """
    if every is not None and every < 1:
        raise RequestError(f"every = {every}: must be at least 1 step")
    return run_jobs(
        engine,
        cases,
        lambda case: job_of(case, route, every),
        lambda case, output: read(case, route, output, every),
    )


def measured(
    engine: Engine, cases: Sequence[Incline], route: Route, *, every: int | None = None
) -> list[InclineRun]:
    """Run the cases and raise the first EngineError, for callers that need them all."""
    return complete(run_inclines(engine, cases, route, every=every))


def read(case: Incline, route: Route, output: Output, every: int | None = None) -> InclineRun:
    """Return the run in an output: by its verdict, or judged by its path.

    Raise EngineOutputError for what is missing, out of order or cut short, EngineNaNError for
    values that are not finite.
    """
    return read_by(lambda looks: judge(case, route, path_in(looks)), case, route, output, every)


def read_by(
    judge_looks: Callable[[Table], Judgement],
    case: Incline,
    route: Route,
    output: Output,
    every: int | None = None,
) -> InclineRun:
    """Return the run in an output, as :func:`read`; ``judge_looks`` judges its samples.

    Errors are those of :func:`read`.
    """
    _check_settings(case, route, output)
    # a script that judges by its own looks names its route, and prints whether the grain touches
    judged = output.has("route") or output.has("touching") or not output.tables
    path = path_in(output.table(COLUMNS)) if every is not None else None
    if judged:
        return _reported_run(case, route, output, path, every)
    looks = output.table(COLUMNS, name=STAGES if STAGES in output.tables else SERIES)
    judgement = judge_looks(looks)
    limit = case.time_limit * math.sqrt(case.diameter / case.gravity)
    # of what is undecided, the last row was judged
    if judgement.motion is Motion.UNDECIDED and judgement.time_s < limit * (1.0 - 1e-9) - case.step:
        raise EngineOutputError(
            f"{output.who} wrote a path that ends at {judgement.time_s:g} s, undecided, before "
            f"the time limit of {limit:g} s"
        )
    if path is not None and STAGES not in output.tables:
        path = Trajectory(*(column[: judgement.row + 1] for column in vars(path).values()))
    steps = round(judgement.time_s / case.step)
    if path is not None and every is not None:
        _complete(path, steps // every + 1, output.who)
    return InclineRun(
        case=case,
        motion=judgement.motion,
        margin_J=judgement.margin_J,
        touching=judgement.touching,
        crests=judgement.crests,
        time_s=judgement.time_s,
        steps=round(
            looks["step"][judgement.row] if "step" in looks else judgement.time_s / case.step
        ),
        seconds=output.seconds,
        provenance=output.provenance,
        trajectory=path,
        ranks=output.ranks,
    )


def _check_settings(case: Incline, route: Route, output: Output) -> None:
    """Raise EngineOutputError where the settings in an output are not the case's."""
    if output.has("route") and output.text("route") != route:
        raise EngineOutputError(
            f"{output.who} ran the route {output.text('route')[:SHOWN]!r}, not {route!r}"
        )
    output.check_numbers({**case.settings(), "angle_deg": case.angle})
    if output.has("crest"):
        count = sum(name == "crest" for name, _ in output.results)
        output.check_numbers({"crests_passed": float(count)}, "is how many it tells of")


def _reported_run(
    case: Incline, route: Route, output: Output, path: Trajectory | None, every: int | None
) -> InclineRun:
    """Return the run whose script judged the grain itself."""
    crests = output.rows("crest", 4)
    steps = round(output.number("steps"))
    try:
        motion, touching = Motion(output.text("verdict")), TOUCHING[output.text("touching")]
    except (ValueError, KeyError) as error:
        raise EngineOutputError(f"{output.who} left an incomplete result ({error})") from None
    run = InclineRun(
        case=case,
        motion=motion,
        margin_J=output.number("margin_J"),
        touching=touching,
        crests=Crests(time_s=crests[:, 1], margin_J=crests[:, 2]),
        time_s=output.number("time_s"),
        steps=steps,
        seconds=output.seconds,
        provenance=output.provenance,
        trajectory=path,
        ranks=output.ranks,
    )
    if path is not None and every is not None:
        _complete(path, steps // every + 1, output.who)
    _consistent(run, 1 if route == "passage" else case.wells, crests[:, 0], output.who)
    return run


def _consistent(run: InclineRun, wells: int, numbers: np.ndarray, engine_name: str) -> None:
    """Raise EngineOutputError for a clock or crests that contradict the rest of the result."""
    clock = run.steps * run.case.step
    if abs(run.time_s - clock) > 0.5 * run.case.step + CLOCK * clock:
        raise EngineOutputError(
            f"{engine_name} took {run.steps} steps of {run.case.step:g} s "
            f"and tells of {run.time_s:g} s"
        )
    count, times = numbers.size, run.crests.time_s
    wanted = count == wells if run.motion is Motion.MOVES_ON else count < wells
    late = count and times[-1] > run.time_s + 0.5 * run.case.step
    if not wanted or list(numbers) != list(range(1, count + 1)) or np.any(np.diff(times) <= 0.0):
        raise EngineOutputError(
            f"{engine_name} tells of a grain that is {run.motion} after {count} crests of {wells}"
        )
    if late:
        raise EngineOutputError(f"{engine_name} passed a crest after the end of its run")
    if run.motion is Motion.MOVES_ON and not (
        run.time_s - times[-1] <= 0.5 * run.case.step
        and math.isclose(run.margin_J, run.crests.margin_J[-1], rel_tol=1e-9)
    ):
        raise EngineOutputError(
            f"{engine_name} tells of another time or energy than at its last crest"
        )


def _complete(path: Trajectory, rows: int, engine_name: str) -> None:
    """Raise EngineOutputError for a path that lacks samples."""
    if path.time_s.size != rows:
        raise EngineOutputError(f"{engine_name} left {path.time_s.size} rows of a series of {rows}")
    if path.time_s.size > 2 and np.ptp(np.diff(path.time_s[:rows])) > 1e-6 * path.time_s[-1]:
        raise EngineOutputError(f"{engine_name} left a series with samples missing in between")


def scene_from(case: Incline, start: Start) -> ContactScene:
    """Return the scene of the steady route with the grain at another start."""
    scene = scene_of(values_of(case, "steady"))
    x, y, vx, vy = start.state()
    grain, *row = scene.bodies
    moved = replace(grain, position=(x, y, 0.0), velocity=(vx, vy, 0.0))
    return replace(scene, bodies=(moved, *row))


def steady_runs(engine: Reference, cases: Sequence[Incline], start: Start) -> list[InclineRun]:
    """Run cases by the steady route from a start and return their results in order.

    Raise the first EngineError, RequestError for a step that the integrator cannot take.
    """
    outputs = complete(engine.run_scenes([scene_from(case, start) for case in cases]))
    return [read(case, "steady", output) for case, output in zip(cases, outputs, strict=True)]


def follow(
    engine: Reference, case: Incline, start: Start, duration: float, *, every: int = 1
) -> Trajectory:
    """Return the path over ``duration`` [s] from a start, sampled every so many steps.

    The last step reaches the duration or passes it. Raise RequestError for a
    duration that is not positive or asks for more than 1e15 steps, EngineError when
    the run fails.
    """
    from harness.engines.reference import MOST_STEPS

    if not (math.isfinite(duration) and 0.0 < duration <= MOST_STEPS * case.step):
        raise RequestError(
            f"duration = {duration!r} s: must be greater than 0 and at most "
            f"{MOST_STEPS * case.step:.4g} s ({MOST_STEPS:g} steps)"
        )
    if every < 1:
        raise RequestError(f"every = {every}: must be at least 1 step")
    steps = math.ceil(duration / case.step * (1.0 - 1e-12))
    scene = scene_from(case, start)
    return engine.follow(replace(scene, steps=steps, every=every))
