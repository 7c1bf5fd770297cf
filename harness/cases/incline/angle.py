"""Critical angles of the incline, measured in an engine: as functions, and on a bench."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from harness import __version__
from harness.cases.bench import Bench
from harness.cases.incline.runs import Run, read
from harness.cases.incline.search import PHASES, CriticalAngle, Measure, prepared, search
from harness.cases.incline.system import Incline, Route, job_of, scene_of
from harness.engines.base import Output
from harness.engines.jobs import cores, parallel_map
from harness.engines.provenance import Provenance
from harness.engines.scene_tables import motion_tables
from harness.errors import EngineError, Unsupported
from harness.store.cache import EngineChoice, opened

Progress = Callable[[str, int, int], None]  # stage, done, expected
REFERENCE = Provenance("reference", __version__, how="compiled")


def critical_angle(
    case: Incline | None = None,
    *,
    method: Route = "passage",
    tolerance_deg: float | None = None,
    phases: int = PHASES,
    wells: int | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> CriticalAngle:
    """Return the critical angle [deg] of a case, the source's contact unless given.

    ``method`` is ``passage`` or ``steady``; ``tolerance_deg`` is the resolution of the search.
    ``phases`` are the starts within a step of a passage, ``wells`` those to pass in steady motion.
    ``engine`` is an open one, or the name of one that is opened and whose runs are kept, LAMMPS
    unless given; ``fresh`` runs again what was kept. Raise EngineError for a run that failed,
    RequestError for a contact that rebounds too much for a passage.
    """
    case = prepared(case or Incline(), method, wells)
    with opened(engine, fresh=fresh) as running:
        measure = _counted(engine_measure(Bench(running), method), method, progress)
        return search(measure, case, method, tolerance_deg, phases)


def critical_angles(
    cases: Sequence[Incline],
    engine: EngineChoice = None,
    *,
    method: Route = "passage",
    phases: int = PHASES,
    fresh: bool = False,
    progress: Progress | None = None,
) -> list[CriticalAngle | EngineError]:
    """Return the critical angle [deg] of each case, measured side by side; errors in place."""
    with opened(engine, fresh=fresh) as running:
        measure = engine_measure(Bench(running), method)
        count, total = itertools.count(1), len(cases)

        def angle_of(case: Incline) -> CriticalAngle | EngineError:
            try:
                return search(measure, prepared(case, method), method, phases=phases)
            except EngineError as error:
                return error
            finally:
                if progress is not None:
                    progress("critical angles", next(count), total)

        return parallel_map(angle_of, cases, cores())


def _counted(measure: Measure, route: Route, progress: Progress | None) -> Measure:
    """Return a measure that reports its runs, done and expected so far."""
    if progress is None:
        return measure
    done = 0

    def counting(cases: Sequence[Incline]) -> Sequence[Run]:
        nonlocal done
        runs = measure(cases)
        done += len(runs)
        progress(f"runs, {route}", done, max(12 if route == "passage" else 16, done))
        return runs

    return counting


# ---- on a bench, where each search is made once


def angle_on(
    bench: Bench, case: Incline, method: Route = "passage", tolerance_deg: float | None = None
) -> CriticalAngle:
    """Return the critical angle of a case in the engine of a bench."""
    return bench.once(_angle_on, bench, case, method, tolerance_deg)


def known_angle(bench: Bench, case: Incline) -> CriticalAngle | None:
    """Return :func:`angle_on` by passage where it was measured, None where it was not."""
    return bench.known(_angle_on, bench, case, "passage", None)


def known_reference(bench: Bench, case: Incline) -> CriticalAngle | None:
    """Return :func:`reference_angle` by passage where it was measured, None where it was not."""
    return bench.known(_reference_angle, bench, case, "passage")


def _angle_on(
    bench: Bench, case: Incline, method: Route, tolerance_deg: float | None
) -> CriticalAngle:
    return search(engine_measure(bench, method), prepared(case, method), method, tolerance_deg)


def reference_angle(bench: Bench, case: Incline, method: Route = "passage") -> CriticalAngle:
    """Return the critical angle in the reference, by the conventions of the bench's engine."""
    return bench.once(_reference_angle, bench, case, method)


def _reference_angle(bench: Bench, case: Incline, method: Route) -> CriticalAngle:
    return search(reference_measure(bench, method), prepared(case, method), method)


def engine_measure(bench: Bench, route: Route) -> Measure:
    """Return a function that runs cases in the engine of a bench.

    Raise Unsupported for a case that the engine refuses, the first EngineError of a run.
    """

    def measure(cases: Sequence[Incline]) -> list[Run]:
        jobs = [job_of(case, route) for case in cases]
        for job in jobs:
            if reason := bench.refusal(job):
                raise Unsupported(reason)
        runs = []
        for case, outcome in zip(cases, bench.outcomes(jobs), strict=True):
            if isinstance(outcome, EngineError):
                raise outcome
            with _log_of(outcome):
                runs.append(read(case, route, outcome))
        return runs

    return measure


@contextmanager
def _log_of(output: Output) -> Iterator[None]:
    """Attach the log of an output to an EngineError in reading it."""
    try:
        yield
    except EngineError as error:
        error.log = error.log or output.log
        raise


def reference_measure(bench: Bench, route: Route) -> Measure:
    """Return a function that runs cases in the reference, by the conventions of a bench's engine.

    Raise Unsupported for a case that the engine cannot state.
    """
    from harness.solvers import reference

    def run(case: Incline) -> Run:
        scene = scene_of(case, route)
        tables = motion_tables(reference.run(scene, bench.rules(scene)), scene, sampled=False)
        return read(case, route, Output((), REFERENCE, tables, title="the reference"))

    return lambda cases: parallel_map(run, cases, cores())
