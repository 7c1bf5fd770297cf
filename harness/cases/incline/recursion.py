"""The energy after each shock, against the map of the theory."""

from __future__ import annotations

import numpy as np

from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.evidence import Recursion, Verifying
from harness.cases.incline.parameters import Incline
from harness.cases.incline.rules import reference_for
from harness.cases.incline.runs import measured
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, judge
from harness.engines.reference.engine import Reference
from harness.engines.traits import Traits
from harness.parameters.contact import PLASTIC
from harness.theory import energy_map
from harness.theory.shock import SHOCK_WITHOUT_REBOUND

RECURSION_CASE = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=200.0, angle=10.6)

ALL_WELLS = Tolerance("", 0.0, 0.0, "a count: above the critical angle no well traps the grain")


def recursion(verifying: Verifying) -> list[Check]:
    """Hold the energy after each shock against E[j+1] = (E[j] + dE) / 4 from the first one.

    All wells must be passed.
    """
    case, evidence = RECURSION_CASE, verifying.evidence
    shocks = "incline: energy after each shock"
    untested = verifying.untested(shocks, case, "steady", "m g d", Kind.ANALYTIC)
    if untested:
        return untested
    run = measured(verifying.engine, [case], "steady")[0]
    found = run.crests.margin_J / case.weight_energy + energy_map.well_depth(case.angle)
    name = f"incline: wells passed at {case.angle:g} deg"
    rows = [judge(name, Kind.ANALYTIC, float(len(found)), float(case.wells), ALL_WELLS)]
    if len(found) < 2:
        return rows
    later = energy_map.energies(float(found[0]), len(found) - 1, case.angle, SHOCK_WITHOUT_REBOUND)
    predicted = np.concatenate([found[:1], later])
    evidence.recursion = Recursion(run, found, predicted)
    worst = int(np.argmax(np.abs(found - predicted)))
    rows.append(
        judge(
            f"incline: energy after shock {worst + 1}, the worst of {len(found)}",
            Kind.ANALYTIC,
            float(found[worst]),
            float(predicted[worst]),
            _tolerance(verifying.engine.traits, evidence.closed_form_deg),
        )
    )
    return rows


def _tolerance(traits: Traits, closed_form: float) -> Tolerance:
    """Return what stiffness and step are worth in energy: by the reference DEM at the same ones.

    Not by the engine that is judged, whose fault would widen it.
    """
    reference = reference_for(traits) or Reference(spring=traits.spring)
    angle = critical_angle(RECURSION_CASE, engine=reference)
    off = abs(angle.value_deg - closed_form) + angle.uncertainty_deg
    slope = energy_map.passage_margin_slope(closed_form, SHOCK_WITHOUT_REBOUND)
    # a geometric sum of such errors, each passed on with 1/4, is 4/3 of one; the shock
    # at this angle is up to half as strong again as at the critical one
    return Tolerance(
        "m g d",
        2.0 * off * slope,
        0.0,
        "bias and jitter of the passage route at this stiffness and step in the reference DEM, "
        "as an energy, times 2",
    )
