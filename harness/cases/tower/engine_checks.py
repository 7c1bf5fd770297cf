"""The towers of one engine against the exact propagator, and the order of its error."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from harness.cases.tower.run import covering, tower
from harness.cases.tower.step_convergence import step_convergence
from harness.comparison.engine_evidence import EngineEvidence, EngineTower
from harness.comparison.tolerances import TOLERANCES, Tolerance
from harness.comparison.verdicts import (
    Check,
    Kind,
    failed_run,
    finding,
    judge,
    judge_within_uncertainty,
    not_tested,
)
from harness.engines.contract import Engine
from harness.errors import EngineError, EngineOutputError, RequestError
from harness.observables.impulse import impulse
from harness.observables.summary import peak_force
from harness.observables.tower import TowerRun
from harness.observables.windows import SEARCH, window_end
from harness.parameters.tower import Tower
from harness.workflows.verification.other_engines.extent import FINEST, ORDER_HEIGHT, Extent

CASE = Tower(law="overlap", stiffness=1e5, speed=2.0)

ORDERS = {
    "velocity-verlet": (2.0,),
    "mfix-euler": (1.0, 2.0),
    "mfix-adams-bashforth": (2.0,),
    "rk4": (2.0,),
}
"""Of the force error in the step; contacts that change within a step allow no more than 2.

Semi-implicit Euler is the leapfrog with velocities half a step early: first order, and
second where an engine is started and read at the half steps that they belong to.
"""

ENOUGH_DIGITS = 12
"""Digits of an output from which the error of fine steps is not hidden by them."""

WIDEST = 0.5
"""Half of the widest interval that tells first order from second."""

_MARGIN = 1.001  # the window's end is known to a step


def tower_checks(engine: Engine, extent: Extent, evidence: EngineEvidence) -> list[Check]:
    """Run the towers of an engine and return their rows; fill in the evidence."""
    if not engine.states_towers:
        reason = "it states the incline only"
        return [not_tested(f"{engine.name}: towers", Kind.CROSS_CODE, reason)]
    order = _order(engine, extent, evidence)
    first_order = order.expected == 1.0
    return [*_finest(engine, extent, evidence, first_order=first_order), order]


def _finest(
    engine: Engine, extent: Extent, evidence: EngineEvidence, *, first_order: bool
) -> list[Check]:
    """Hold peak force and impulse at the finest step against the exact ones, in one batch."""
    cases = [CASE.replace(height=height) for height in extent.heights]
    exact = [covering(tower(case, solver="exact"), "turnaround") for case in cases]
    ends = [window_end(run, "turnaround") / run.tower.contact_time for run in exact]
    duration = max(SEARCH, *ends) * _MARGIN
    runs: list[TowerRun | EngineError]
    try:
        runs = engine.towers(cases, duration, steps_per_contact=FINEST)
    except EngineError as error:
        runs = [error] * len(cases)
    except RequestError as error:
        return [not_tested(f"{engine.name}: towers", Kind.CROSS_CODE, str(error))]
    rows: list[Check] = []
    for run, own in zip(runs, exact, strict=True):
        rows += _against_exact(engine.name, run, own, evidence, first_order=first_order)
    return rows


def _against_exact(
    engine: str,
    run: TowerRun | EngineError,
    exact: TowerRun,
    evidence: EngineEvidence,
    *,
    first_order: bool,
) -> list[Check]:
    name = f"{engine}: tower, n = {exact.tower.height}, {FINEST:g} steps per contact"
    if isinstance(run, EngineError):
        return [failed_run(name, Kind.CROSS_CODE, run)]
    try:
        found = EngineTower(
            engine,
            exact.tower.height,
            FINEST,
            peak_force(run),
            peak_force(exact),
            impulse(run),
            impulse(exact),
        )
    except RequestError as error:
        # the cases are ours: a run that does not show its window is the engine's doing
        return [failed_run(name, Kind.CROSS_CODE, EngineOutputError(str(error)))]
    evidence.towers.append(found)
    force = replace(TOLERANCES["tower, engines"], unit="N")
    return [
        judge(
            f"{name}: peak force", Kind.CROSS_CODE, found.peak_force, found.exact_peak_force, force
        ),
        judge(
            f"{name}: impulse to the turnaround",
            Kind.CROSS_CODE,
            found.impulse,
            found.exact_impulse,
            _impulse_tolerance(exact, first_order=first_order),
        ),
    ]


def _impulse_tolerance(exact: TowerRun, *, first_order: bool) -> Tolerance:
    """Return how close the impulse must be, with what half a step is worth at first order.

    Such a scheme has its velocities half a step early: at the window's end, and where the
    compression turns, which counts twice in the window.
    """
    known = replace(TOLERANCES["tower, engines"], unit="N s")
    if not first_order:
        return known
    end = window_end(exact, "turnaround")
    force = float(np.interp(end, exact.time, exact.grain_force))
    late = 1.5 * exact.tower.contact_period / FINEST * force
    why = "first order: velocities half a step early, where the window ends and, twice, in its end"
    return replace(known, absolute=late, reason=f"{known.reason}; {why}")


def _order(engine: Engine, extent: Extent, evidence: EngineEvidence) -> Check:
    """Measure how the force error falls with the step."""
    case = CASE.replace(height=ORDER_HEIGHT)
    name = f"{engine.name}: tower, n = {case.height}: order of the force error in the step"
    exact = tower(case, solver="exact", samples=12_000)
    try:
        found = step_convergence(lambda steps: _one(engine, case, steps), exact, extent.ladder)
    except EngineError as error:
        return failed_run(name, Kind.CROSS_CODE, error)
    except RequestError as error:
        return not_tested(name, Kind.CROSS_CODE, str(error))
    evidence.convergence.append(replace(found, solver=engine.name))
    order, (low, high) = found.l2_order.value, found.l2_order.interval
    half = (high - low) / 2
    orders = ORDERS.get(engine.traits.integrator, (math.nan,))
    expected = min(orders, key=lambda known: abs(known - order))
    if math.isnan(expected) or engine.traits.digits < ENOUGH_DIGITS or not half <= WIDEST:
        note = (
            f"known to ± {half:.2g}, by {engine.traits.digits} digits of its output, in a scheme "
            f"called {engine.traits.integrator or 'its own'}: too little to be judged"
        )
        return finding(name, order, expected, "", note, half)
    return judge_within_uncertainty(
        name,
        Kind.CROSS_CODE,
        order,
        expected,
        half,
        "",
        "an order of its scheme must lie in the 95 % interval of the measured slope",
    )


def _one(engine: Engine, case: Tower, steps: float) -> TowerRun:
    (run,) = engine.towers([case], SEARCH, steps_per_contact=steps)
    if isinstance(run, EngineError):
        raise run
    return run
