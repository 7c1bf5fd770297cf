"""The towers of an engine beside the main one: finest steps against exact, order of the error."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from harness.cases.contract import Study
from harness.cases.parts import Part, asked, rows_of_parts
from harness.cases.runs import whole
from harness.cases.tower import tolerances
from harness.cases.tower.checks import refusal
from harness.cases.tower.engine_runs import run_towers
from harness.cases.tower.evidence import CodeEvidence, EngineTower
from harness.cases.tower.levels import FINEST, LADDER, LEVELS, ORDER_HEIGHT
from harness.cases.tower.records import NAME
from harness.cases.tower.run import MARGIN, covering, tower
from harness.cases.tower.step_convergence import step_convergence
from harness.comparison.findings import Findings
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, finding, judge, not_tested
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.impulse import impulse
from harness.observables.summary import peak_force
from harness.observables.tower import TowerRun
from harness.observables.windows import SEARCH, window_end
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


def beside_findings(engine: Engine, study: Study) -> Findings:
    """Run the towers of an engine and return their rows and evidence.

    A part that goes wrong becomes a failed row; the other parts go on.
    """
    evidence = CodeEvidence(engine.title)
    found = Findings(NAME, engine.name, evidence=evidence)
    reason = refusal(engine, CASE)
    if reason:
        found.checks.append(not_tested(f"{engine.name}: towers", Kind.CROSS_CODE, reason))
        return found
    named = f"tower, n = {ORDER_HEIGHT}: order of the force error in the step"
    order = rows_of_parts(engine.name, [asked(Part(named, lambda: [_order(engine, found)]))])
    first_order = order[0].expected == 1.0
    finest = partial(_finest, engine, study, evidence, first_order=first_order)
    found.checks += [*rows_of_parts(engine.name, [asked(Part("towers", finest))]), *order]
    found.published = {
        "towers": [one.record() for one in evidence.towers],
        "orders": [one.record() for one in evidence.convergence],
    }
    return found


def _finest(
    engine: Engine, study: Study, evidence: CodeEvidence, *, first_order: bool
) -> list[Check]:
    """Hold peak force and impulse at the finest step against the exact ones, in one batch."""
    cases = [CASE.replace(height=height) for height in LEVELS[study.level].beside]
    exact = [_exact(case, study) for case in cases]
    ends = [window_end(run, "turnaround") / run.tower.contact_time for run in exact]
    runs = run_towers(engine, cases, max(SEARCH, *ends) * MARGIN, steps_per_contact=FINEST)
    rows: list[Check] = []
    for run, own in zip(runs, exact, strict=True):
        part = partial(_against_exact, engine.name, run, own, evidence, first_order=first_order)
        name = f"tower, n = {own.tower.height}, {FINEST:g} steps per contact"
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
    run, height = whole(run), exact.tower.height
    name = f"{engine}: tower, n = {height}, {FINEST:g} steps per contact"
    forces, impulses = (peak_force(run), peak_force(exact)), (impulse(run), impulse(exact))
    evidence.towers.append(EngineTower(engine, height, FINEST, *forces, *impulses))
    force = replace(tolerances.FINEST, unit="N")
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
    known = replace(tolerances.FINEST, unit="N s")
    if not first_order:
        return known
    end = window_end(exact, "turnaround")
    force = float(np.interp(end, exact.time, exact.grain_force))
    late = 1.5 * exact.tower.contact_period / FINEST * force
    why = "first order: velocities half a step early, where the window ends and, twice, in its end"
    return replace(known, absolute=late, reason=f"{known.reason}; {why}")


def _order(engine: Engine, found: Findings) -> Check:
    """Measure how the force error falls with the step."""
    case = CASE.replace(height=ORDER_HEIGHT)
    exact = tower(case, solver="exact", samples=12_000)
    convergence = replace(
        step_convergence(lambda steps: _one(engine, case, steps), exact, LADDER), solver=engine.name
    )
    found.evidence.convergence.append(convergence)
    name = f"{engine.name}: tower, n = {case.height}: order of the force error in the step"
    order, (low, high) = convergence.l2_order.value, convergence.l2_order.interval
    half = (high - low) / 2
    orders = ORDERS.get(engine.traits.integrator, (math.nan,))
    expected = min(orders, key=lambda known: abs(known - order))
    if math.isnan(expected) or engine.traits.digits < ENOUGH_DIGITS or not half <= WIDEST:
        note = (
            f"known to ± {half:.2g}, by {engine.traits.digits} digits of its output, in a scheme "
            f"called {engine.traits.integrator or 'its own'}: too little to be judged"
        )
        return finding(name, order, expected, "", note, half)
    return judge(name, Kind.CROSS_CODE, order, expected, tolerances.ORDER, uncertainty=half)


def _one(engine: Engine, case: Tower, steps: float) -> TowerRun:
    return whole(run_towers(engine, [case], SEARCH, steps_per_contact=steps)[0])
