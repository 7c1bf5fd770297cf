"""Runs of an engine at single angles, held against the theory, and against themselves."""

from __future__ import annotations

import numpy as np

from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.engine_angle import reference_for
from harness.cases.incline.evidence import Recursion, Verifying, passage_case, passage_name
from harness.cases.incline.levels import SOURCE_CASE
from harness.cases.incline.parameters import Incline
from harness.cases.incline.runs import measured, run_inclines
from harness.cases.incline.tolerances import ALL_WELLS, SCALES, TWO_WAYS
from harness.cases.runs import whole
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, failed_run, judge, not_tested
from harness.engines.reference.engine import Reference
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.parameters.contact import CONTACTS, PLASTIC
from harness.theory import energy_map
from harness.theory.shock import SHOCK_WITHOUT_REBOUND

RECURSION_CASE = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=200.0, angle=10.6)

ANGLE_DEG = 10.2
"""Just below the critical angle: the margin is small, and what moves it shows."""

EVERY = 10
"""Steps between the samples of the path."""

CASES = tuple(
    Incline(
        contact=contact,
        angle=ANGLE_DEG,
        stiffness=1e6,
        steps_per_contact=100.0 if contact is PLASTIC else 50.0,
    )
    for contact in CONTACTS.values()
)


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


def scales(verifying: Verifying) -> list[Check]:
    """Hold critical angles at the same k d/(m g) in other units against one another."""
    base, rows = SOURCE_CASE, []
    glass = base.replace(diameter=3e-3, density=2500.0, stiffness=1.0e6)
    others = {
        "3 mm glass": _same_rigidity(glass, base),
        "lunar gravity": _same_rigidity(base.replace(gravity=1.62), base),
    }
    for number, (name, case) in enumerate(others.items(), 1):
        row = f"incline: scale invariance, {name}"
        rows += verifying.untested(row, base) or [_scaled(verifying, row, case, base)]
        verifying.study.progress("scale invariance", number, len(others))
    return rows


def _scaled(verifying: Verifying, row: str, case: Incline, base: Incline) -> Check:
    reference = whole(verifying.angle(base))
    angle = critical_angle(case, engine=verifying.engine)
    value, stated = angle.value_deg, angle.uncertainty_deg
    return judge(row, Kind.CROSS_CODE, value, reference.value_deg, SCALES, uncertainty=stated)


def _same_rigidity(case: Incline, base: Incline) -> Incline:
    """Return a case with the stiffness that keeps k d / (m g) of the base."""
    return case.replace(stiffness=case.mass * case.gravity / (base.static_overlap * case.diameter))


def two_ways(verifying: Verifying) -> list[Check]:
    """Hold a run against the same installation run in its other way, where it has one."""
    name = "incline: in-process against executable, energy margin"
    case = SOURCE_CASE.replace(angle=10.0)
    refused = verifying.refusal(case)
    try:
        twin = None if refused else verifying.engine.twin()
        if twin is None:
            reason = refused or f"{verifying.who} has no other way to be run here"
            return [not_tested(name, Kind.CROSS_CODE, reason, "J")]
        with twin:
            other = measured(twin, [case], "passage")[0]
    except (EngineMissingError, RequestError) as error:
        return [not_tested(name, Kind.CROSS_CODE, str(error), "J")]
    own = measured(verifying.engine, [case], "passage")[0]
    return [judge(name, Kind.CROSS_CODE, own.margin_J, other.margin_J, TWO_WAYS)]


def passages(verifying: Verifying) -> list[Check]:
    """Run the passages for the baseline; return a row for each that died or was refused.

    They are the most sensitive runs that there are: a critical angle is a root and forgives, the
    energy margin of one run is the same to the last bit every time, and so is the path.
    """
    engine, cases = verifying.engine, verifying.stated(CASES)
    rows = [row for case in CASES for row in verifying.untested(passage_row(case), case, unit="")]
    for case, run in zip(cases, run_inclines(engine, cases, "passage", every=EVERY), strict=True):
        if isinstance(run, EngineError):
            verifying.found.errors[passage_name(case, engine.name)] = run
            rows.append(failed_run(passage_row(case), Kind.CROSS_CODE, run))
        else:
            verifying.found.records.append(passage_case(run))
            verifying.evidence.passages.append(run)
    return rows


def passage_row(case: Incline) -> str:
    """Return what rows call the passage of a contact."""
    return f"incline: {case.contact.name} contact, passage at {case.angle:g} deg"
