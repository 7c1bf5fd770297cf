"""Run towers by solvers of this package or in an engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from functools import partial
from typing import TYPE_CHECKING, TypedDict, Unpack

from harness.cases.contract import Progress, silent
from harness.cases.runs import whole
from harness.cases.tower.engine_runs import run_towers
from harness.cases.tower.timing import check_duration
from harness.engines.registry import ENGINES, open_engine
from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.observables.windows import SEARCH, Window, touch_time, window_end
from harness.parameters.tower import Tower

DURATION = SEARCH  # [t0] the source's longest look
DEFAULT_SOLVER = "rk4"
MARGIN = 1.001  # the longer run has another step, and finds the end of its window a little off

if TYPE_CHECKING:
    from harness.engines.contract import Engine


class Options(TypedDict, total=False):
    """How a tower is run: keywords of :func:`tower`."""

    solver: str | None
    duration: float
    steps_per_contact: float | None
    samples: int | None
    profiles: bool
    engine: Engine | None
    progress: Progress


Told = Callable[[int, int], None]
"""Called with what is done and all of it."""

Solver = Callable[[Tower, float, float | None, int | None, bool, Told], TowerRun]


def tower(case: Tower, **options: Unpack[Options]) -> TowerRun:
    """Run ``case`` for ``duration`` [t0] with a solver of :data:`SOLVERS`, or in an engine.

    ``engine`` runs it where it is given; the name of an engine for ``solver`` opens that one and
    closes it again; else RK4 does. ``steps_per_contact`` counts steps in pi sqrt(m/k), for solvers
    with a step. ``samples`` is how many to keep, about 1000 per t0 if not given; with
    ``profiles`` all particles are kept, not only the grain. ``progress`` is called as solvers of
    this package go on. Raise RequestError for what cannot be, a solver that is not the given
    engine among it, and EngineError for a run that failed.
    """
    (run,) = towers([case], **options)
    return run


def towers(
    cases: Sequence[Tower],
    *,
    solver: str | None = None,
    duration: float = DURATION,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
    engine: Engine | None = None,
    progress: Progress = silent,
) -> Iterator[TowerRun]:
    """Yield the runs of ``cases``, as :func:`tower` makes one: in an engine they are one batch."""
    name = chosen_solver(solver, engine)
    check_duration(duration)
    if name in SOLVERS:
        for case in cases:
            seconds = duration * case.contact_time
            told = partial(progress, f"tower of height {case.height}, {case.law} law")
            yield SOLVERS[name](case, seconds, steps_per_contact, samples, profiles, told)
        return
    with nullcontext(engine) if engine is not None else open_engine(name) as opened:
        runs = run_towers(
            opened,
            cases,
            duration,
            steps_per_contact=steps_per_contact,
            samples=samples,
            profiles=profiles,
        )
    yield from map(whole, runs)


def chosen_solver(solver: str | None, engine: Engine | None) -> str:
    """Return the name of the solver or engine that runs a tower.

    Raise RequestError for one that is not known, and for a solver beside an engine of another
    name: neither may replace the other in silence.
    """
    if engine is not None:
        if solver not in (None, engine.name):
            raise RequestError(
                f"solver = {solver!r}: contradicts the engine that is given, {engine.name!r}"
            )
        return engine.name
    if solver is None or solver in SOLVERS:
        return solver or DEFAULT_SOLVER
    if solver not in ENGINES:
        known = ", ".join((*SOLVERS, *ENGINES))
        raise RequestError(f"solver = {solver!r}: must be one of {known}")
    return solver


def covering(
    run: TowerRun, window: Window, engine: Engine | None = None, progress: Progress = silent
) -> TowerRun:
    """Return ``run``, or one of the same case and solver that covers ``window``.

    Closest approach and impulse need 3 t0, and more where the window ends
    later. ``engine`` is the one that made the run, if one did. Raise RequestError if the tower
    does not show that window.
    """
    t0, long = run.tower.contact_time, run
    if long.time[-1] < (touch_time(run) + SEARCH * t0) * (1 - 1e-9):
        long = _longer(run, touch_time(run) / t0 + SEARCH, engine, progress)
    end = max(window_end(long, one) for one in {window, "turnaround"})
    return long if end <= long.time[-1] else _longer(run, end / t0 * MARGIN, engine, progress)


def _longer(run: TowerRun, duration: float, engine: Engine | None, progress: Progress) -> TowerRun:
    """Run the same again for ``duration`` [t0]."""
    return tower(
        run.tower,
        solver=None if engine is not None else run.solver,
        duration=duration,
        steps_per_contact=None if run.step is None else run.tower.contact_period / run.step,
        profiles=run.profiles is not None,
        engine=engine,
        progress=progress,
    )


def _rk4(
    case: Tower, seconds: float, steps: float | None, samples: int | None, profiles: bool,
    told: Told,
) -> TowerRun:  # fmt: skip
    from harness.chain import rk4

    return rk4.run(
        case, seconds, steps_per_contact=steps, samples=samples, profiles=profiles, told=told
    )


def _exact(
    case: Tower, seconds: float, steps: float | None, samples: int | None, profiles: bool,
    told: Told,
) -> TowerRun:  # fmt: skip
    from harness.chain import exact

    if steps is not None:
        raise RequestError(f"steps_per_contact = {steps}: the exact solver has no step")
    return exact.run(case, seconds, samples=samples, profiles=profiles, told=told)


SOLVERS: dict[str, Solver] = {"rk4": _rk4, "exact": _exact}
"""The harness's own solvers; engines go by the names of the registry."""
