"""Run one tower with one of the solvers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from harness.errors import EngineError, RequestError
from harness.observables.tower import TowerRun
from harness.observables.windows import SEARCH, Window, touch_time, window_end
from harness.parameters.tower import Tower

DURATION = SEARCH  # [t0] the source's longest look
_MARGIN = 1.001  # the longer run has another step, and finds the end of its window a little off

if TYPE_CHECKING:
    from harness.engines.contract import Engine

Solver = Callable[[Tower, float, float | None, int | None, bool], TowerRun]


def tower(
    case: Tower,
    *,
    solver: str = "rk4",
    duration: float = DURATION,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
    engine: Engine | None = None,
) -> TowerRun:
    """Run ``case`` for ``duration`` [t0] with the ``solver`` of that name (:data:`SOLVERS`).

    The name of an engine runs in ``engine``, or in the one of that name, opened and closed
    again.

    ``steps_per_contact`` counts steps in pi sqrt(m/k), for solvers with a step.
    ``samples`` is how many to keep, about 1000 per t0 if not given; with
    ``profiles`` all particles are kept, not only the grain. Raise RequestError
    for what cannot be.
    """
    from harness.engines.registry import ENGINES

    if solver not in (*SOLVERS, *ENGINES):
        known = ", ".join((*SOLVERS, *ENGINES))
        raise RequestError(f"solver = {solver!r}: must be one of {known}")
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} t0: must be finite and greater than 0")
    if solver in SOLVERS:
        seconds = duration * case.contact_time
        return SOLVERS[solver](case, seconds, steps_per_contact, samples, profiles)
    if engine is not None:
        return _in_engine(engine, case, duration, steps_per_contact, samples, profiles)
    from harness.engines.registry import open_engine

    with open_engine(solver) as opened:
        return _in_engine(opened, case, duration, steps_per_contact, samples, profiles)


def covering(run: TowerRun, window: Window, engine: Engine | None = None) -> TowerRun:
    """Return ``run``, or one of the same case and solver that covers ``window``.

    Closest approach and impulse need 3 t0, and more where the window ends
    later. Raise RequestError if the tower does not show that window.
    """
    t0, whole = run.tower.contact_time, run
    if whole.time[-1] < (touch_time(run) + SEARCH * t0) * (1 - 1e-9):
        whole = _longer(run, touch_time(run) / t0 + SEARCH, engine)
    end = max(window_end(whole, window), window_end(whole, "turnaround"))
    return whole if end <= whole.time[-1] else _longer(run, end / t0 * _MARGIN, engine)


def _longer(run: TowerRun, duration: float, engine: Engine | None) -> TowerRun:
    """Run the same again for ``duration`` [t0]."""
    steps = None if run.step is None else run.tower.contact_period / run.step
    profiles = run.profiles is not None
    return tower(
        run.tower,
        solver=run.solver,
        duration=duration,
        steps_per_contact=steps,
        profiles=profiles,
        engine=engine,
    )


def _rk4(
    case: Tower, seconds: float, steps: float | None, samples: int | None, profiles: bool
) -> TowerRun:
    from harness.chain import rk4

    return rk4.run(case, seconds, steps_per_contact=steps, samples=samples, profiles=profiles)


def _exact(
    case: Tower, seconds: float, steps: float | None, samples: int | None, profiles: bool
) -> TowerRun:
    from harness.chain import exact

    if steps is not None:
        raise RequestError(f"steps_per_contact = {steps}: the exact solver has no step")
    return exact.run(case, seconds, samples=samples, profiles=profiles)


def _in_engine(
    engine: Engine,
    case: Tower,
    duration: float,
    steps: float | None,
    samples: int | None,
    profiles: bool,
) -> TowerRun:
    (run,) = engine.towers(
        [case], duration, steps_per_contact=steps, samples=samples, profiles=profiles
    )
    if isinstance(run, EngineError):
        raise run
    return run


SOLVERS: dict[str, Solver] = {"rk4": _rk4, "exact": _exact}
"""The harness's own solvers; engines go by the names of the registry."""
