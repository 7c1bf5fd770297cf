"""Run one tower with one of the solvers."""

from __future__ import annotations

import math
from collections.abc import Callable

from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

DURATION = 3.0  # [t0] the source's longest look

Solver = Callable[[Tower, float, float | None, int | None, bool], TowerRun]


def tower(
    case: Tower,
    *,
    solver: str = "rk4",
    duration: float = DURATION,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
) -> TowerRun:
    """Run ``case`` for ``duration`` [t0] with the ``solver`` of that name (:data:`SOLVERS`).

    ``steps_per_contact`` counts steps in pi sqrt(m/k), for solvers with a step.
    ``samples`` is how many to keep, about 1000 per t0 if not given; with
    ``profiles`` all particles are kept, not only the grain. Raise RequestError
    for what cannot be.
    """
    if solver not in SOLVERS:
        raise RequestError(f"solver = {solver!r}: must be one of {', '.join(SOLVERS)}")
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} t0: must be finite and greater than 0")
    if samples is not None and samples < 1:
        raise RequestError(f"samples = {samples}: must be at least 1")
    seconds = duration * case.contact_time
    return SOLVERS[solver](case, seconds, steps_per_contact, samples, profiles)


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


SOLVERS: dict[str, Solver] = {"rk4": _rk4, "exact": _exact}
