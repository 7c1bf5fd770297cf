"""The towers of an engine beside the main one, against the exact propagator.

The finest steps against the exact force, and the order of the error in the step.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from harness.cases.grain import run_or_raise
from harness.cases.tower import verification
from harness.cases.tower.comparison import step_convergence
from harness.cases.tower.run import MARGIN, NAME, covering, run_towers, tower
from harness.cases.tower.verification import (
    FINEST_STEPS,
    LADDER,
    LEVELS,
    ORDER_HEIGHT,
    CodeEvidence,
    EngineTower,
    refusal,
)
from harness.cases.verification import Part, Study, asked, rows_of_parts
from harness.comparison.verdicts import Check, Kind, Tolerance, finding, judge, not_tested
from harness.comparison.verification import Findings
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.tower import SEARCH, TowerRun, impulse, peak_force, window_end
from harness.parameters.tower import Tower

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


def other_findings(engine: Engine, study: Study) -> Findings:
    """Run the towers of an engine and return their rows and evidence.

    A part that goes wrong becomes a failed row; the other parts go on.
    """
    evidence = CodeEvidence(engine.title)
    findings = Findings(NAME, engine.name, evidence=evidence)
    reason = refusal(engine, CASE)
    if reason:
        findings.checks.append(not_tested(f"{engine.name}: towers", Kind.CROSS_CODE, reason))
        return findings
    named = f"tower, n = {ORDER_HEIGHT}: order of the force error in the step"
    order = rows_of_parts(engine.name, [asked(Part(named, lambda: [_order(engine, findings)]))])
    first_order = order[0].expected == 1.0
    finest = partial(_finest, engine, study, evidence, first_order=first_order)
    findings.checks += [*rows_of_parts(engine.name, [asked(Part("towers", finest))]), *order]
    findings.published = {
        "towers": [row.to_json() for row in evidence.towers],
        "orders": [row.to_json() for row in evidence.convergence],
    }
    return findings


def _finest(
    engine: Engine, study: Study, evidence: CodeEvidence, *, first_order: bool
) -> list[Check]:
    """Hold peak force and impulse at the finest step against the exact ones, in one batch."""
    cases = [CASE.replace(height=height) for height in LEVELS[study.level].other_heights]
    exact = [_exact(case, study) for case in cases]
    ends = [window_end(run, "turnaround") / run.tower.contact_time for run in exact]
    runs = run_towers(engine, cases, max(SEARCH, *ends) * MARGIN, steps_per_contact=FINEST_STEPS)
    rows: list[Check] = []
    for run, expected in zip(runs, exact, strict=True):
        part = partial(
            _against_exact, engine.name, run, expected, evidence, first_order=first_order
        )
        name = f"tower, n = {expected.tower.height}, {FINEST_STEPS:g} steps per contact"
        rows += rows_of_parts(engine.name, [asked(Part(name, part))])
    return rows


def _exact(case: Tower, study: Study) -> TowerRun:
    """Return the exact run that covers the turnaround window, made once for all engines."""
    return study.once(case, lambda: covering(tower(case, solver="exact"), "turnaround"))


def _against_exact(
    engine: str,
    run: TowerRun | EngineError,
    exact: TowerRun,
    evidence: CodeEvidence,
    *,
    first_order: bool,
) -> list[Check]:
    run, height = run_or_raise(run), exact.tower.height
    name = f"{engine}: tower, n = {height}, {FINEST_STEPS:g} steps per contact"
    forces, impulses = (peak_force(run), peak_force(exact)), (impulse(run), impulse(exact))
    evidence.towers.append(EngineTower(engine, height, FINEST_STEPS, *forces, *impulses))
    force = replace(verification.FINEST, unit="N")
    late = _impulse_tolerance(exact, first_order=first_order)
    return [
        judge(f"{name}: peak force", Kind.CROSS_CODE, *forces, force),
        judge(f"{name}: impulse to the turnaround", Kind.CROSS_CODE, *impulses, late),
    ]


def _impulse_tolerance(exact: TowerRun, *, first_order: bool) -> Tolerance:
    """Return how close the impulse must be, with what half a step is worth at first order.

    Such a scheme has its velocities half a step early: at the window's end, and where the
    compression turns, which counts twice in the window.
    """
    finest = replace(verification.FINEST, unit="N s")
    if not first_order:
        return finest
    end = window_end(exact, "turnaround")
    force = float(np.interp(end, exact.time, exact.grain_force))
    late = 1.5 * exact.tower.contact_period / FINEST_STEPS * force
    why = "first order: velocities half a step early, where the window ends and, twice, in its end"
    return replace(finest, absolute=late, reason=f"{finest.reason}; {why}")


def _order(engine: Engine, findings: Findings) -> Check:
    """Measure how the force error falls with the step."""
    case = CASE.replace(height=ORDER_HEIGHT)
    exact = tower(case, solver="exact", samples=12_000)
    convergence = replace(
        step_convergence(lambda steps: _single_run(engine, case, steps), exact, LADDER),
        solver=engine.name,
    )
    findings.evidence.convergence.append(convergence)
    name = f"{engine.name}: tower, n = {case.height}: order of the force error in the step"
    order, (low, high) = convergence.l2_order.value, convergence.l2_order.interval
    half = (high - low) / 2
    orders = ORDERS.get(engine.traits.integrator, (math.nan,))
    expected = min(orders, key=lambda theoretical: abs(theoretical - order))
    if math.isnan(expected) or engine.traits.digits < ENOUGH_DIGITS or not half <= WIDEST:
        note = (
            f"known to ± {half:.2g}, by {engine.traits.digits} digits of its output, in a scheme "
            f"called {engine.traits.integrator or 'its own'}: too little to be judged"
        )
        return finding(name, order, expected, "", note, half)
    return judge(name, Kind.CROSS_CODE, order, expected, verification.ORDER, uncertainty=half)


def _single_run(engine: Engine, case: Tower, steps: float) -> TowerRun:
    return run_or_raise(run_towers(engine, [case], SEARCH, steps_per_contact=steps)[0])
