"""What a run of a tower is expected to take."""

from __future__ import annotations

from harness.cases.tower.timing import check_duration, timing_of
from harness.engines.cost import engine_seconds
from harness.engines.traits import Traits
from harness.observables.windows import SEARCH
from harness.parameters.tower import Tower

SAMPLES_PER_T0 = 1000


def tower_seconds(
    case: Tower,
    solver: str | None = None,
    rules: Traits | None = None,
    *,
    duration: float = SEARCH,
    steps_per_contact: float | None = None,
) -> float:
    """Return what a tower is expected to take [s] for ``duration`` [t0].

    In an engine of ``rules``, else in a solver of this package, RK4 unless another is named.
    Raise RequestError for a step or duration that cannot be.
    """
    check_duration(duration)
    if rules is not None:
        steps = timing_of(case, duration, steps_per_contact, 1).steps
        return engine_seconds(steps, case.particles, rules)
    from harness.chain import rk4  # kernels, which other cases do without
    from harness.chain.slices import exact_seconds, rk4_step_seconds
    from harness.chain.stability import chosen_step

    if solver == "exact":
        return exact_seconds(case.particles, duration, SAMPLES_PER_T0 * duration)
    seconds = duration * case.contact_time
    steps = rk4.step_count(seconds, chosen_step(case, None, steps_per_contact))
    return steps * rk4_step_seconds(case.law, case.particles)
