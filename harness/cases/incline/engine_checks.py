"""The critical angles of one engine, against the closed form and the reference DEM."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from harness.cases.contract import Study
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle_or_error
from harness.cases.incline.engine_angle import (
    OWN,
    PLASTIC_ROLE,
    EngineAngle,
    Stated,
    contacts_of,
    reference_for,
)
from harness.cases.incline.levels import LEVELS, STATED
from harness.cases.incline.parameters import Incline
from harness.cases.incline.runs import measured
from harness.cases.incline.tolerances import ENGINES_PLASTIC, REFERENCE_ANGLE
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, failed_run, finding, judge, not_tested
from harness.engines.contract import Engine
from harness.engines.traits import Traits
from harness.errors import EngineError
from harness.theory.critical_angle import critical_angle as closed_form
from harness.theory.energy_map import passage_margin_slope
from harness.theory.shock import SHOCK_WITHOUT_REBOUND

STIFF = 1e6
"""[N/m] from which the plastic contact is held against the closed form: softer ones are biased."""

MARGIN_DIGITS = 1.25
"""Of the last digit, in m g d: half of one in the height and in the spring, less in the motion."""

LONGER = 10.0
"""How many times the steps of a critical angle a run takes that is to tell what a step costs."""


def angle_checks(engine: Engine, study: Study, angles: list[EngineAngle]) -> list[Check]:
    """Measure the critical angles of an engine and return their rows; add to ``angles``."""
    rows: list[Check] = []
    for stated in contacts_of(engine.traits):
        if stated.refused:
            name = f"{engine.name}: critical angle, {stated.contact.name} contact"
            rows.append(not_tested(name, Kind.ANALYTIC, stated.refused, "deg"))
            continue
        for stiffness, steps in LEVELS[study.level].engines:
            case = Incline(contact=stated.contact, stiffness=stiffness, steps_per_contact=steps)
            rows += _cell(engine, stated, case, study, angles)
    return rows


def where(case: Incline) -> str:
    """Return contact, stiffness and step for the name of a row."""
    return (
        f"{case.contact.name} contact, k = {case.stiffness:g} N/m, {case.steps_per_contact:g} steps"
    )


def lineage_note(traits: Traits) -> str:
    """Return what an engine's agreement is worth where it grew out of another."""
    if not traits.lineage:
        return ""
    return f"grew out of {traits.lineage}: a regression partner, not independent evidence"


def _cell(
    engine: Engine, stated: Stated, case: Incline, study: Study, angles: list[EngineAngle]
) -> list[Check]:
    traits = engine.traits
    name = f"{engine.name}: critical angle, {where(case)}"
    beside = f"{engine.name}: critical angle against the reference DEM, {where(case)}"
    at = (case.stiffness, case.steps_per_contact)
    phases = LEVELS[study.level].phases_of_engines
    found = critical_angle_or_error(case, phases=phases, engine=engine)
    if isinstance(found, EngineError):
        untested = not_tested(beside, Kind.CROSS_CODE, "the engine's own run died", "deg")
        return [failed_run(name, Kind.ANALYTIC, found, "deg"), untested]
    shown = EngineAngle(
        engine=engine.name,
        role=stated.role,
        contact=case.contact.name,
        rules=stated.rules(traits),
        stiffness=case.stiffness,
        steps_per_contact=case.steps_per_contact,
        value_deg=found.value_deg,
        uncertainty_deg=found.uncertainty_deg,
        closed_form_deg=closed_form(),
        integrator=traits.integrator,
        microseconds_per_step=microseconds_per_step(found, engine) if at == STATED else math.nan,
        lineage=traits.lineage,
    )
    own = reference_angle(traits, case, phases, study)
    if isinstance(own, CriticalAngle):
        shown = replace(shown, reference_deg=own.value_deg)
    angles.append(shown)
    rows = [_against_theory(name, stated, shown, found.phases_note, traits)]
    if engine.name != OWN:
        rows.append(_against_reference(beside, found, own, traits, shown.closed_form_deg))
    return rows


def _against_theory(
    name: str, stated: Stated, shown: EngineAngle, phases: str, traits: Traits
) -> Check:
    of_theory = stated.role == PLASTIC_ROLE and traits.spring == "linear"
    if of_theory and shown.stiffness >= STIFF:
        return judge(
            name,
            Kind.ANALYTIC,
            shown.value_deg,
            shown.closed_form_deg,
            ENGINES_PLASTIC,
            uncertainty=shown.uncertainty_deg,
            note="; ".join(filter(None, (phases, lineage_note(traits)))),
        )
    own = "not the limit of the closed form, but a class of its own"
    soft = f"below {STIFF:g} N/m the bias of the stiffness is not small"
    why = f"{shown.rules.text}; {soft if of_theory else own}"
    note = "; ".join(filter(None, (why, phases, lineage_note(traits))))
    return finding(name, shown.value_deg, shown.closed_form_deg, "deg", note, shown.uncertainty_deg)


def _against_reference(
    name: str,
    angle: CriticalAngle,
    own: CriticalAngle | EngineError | None,
    traits: Traits,
    closed_form: float,
) -> Check:
    if own is None:
        reason = "the reference DEM does not have the engine's scheme"
        return not_tested(name, Kind.CROSS_CODE, reason, "deg")
    if isinstance(own, EngineError):
        return failed_run(name, Kind.CROSS_CODE, own, "deg")
    note = f"reference DEM: {traits.integrator}, {traits.spring} spring"
    return judge(
        name,
        Kind.CROSS_CODE,
        angle.value_deg,
        own.value_deg,
        same_rules(traits, own, closed_form),
        uncertainty=angle.uncertainty_deg,
        note="; ".join(filter(None, (note, angle.phases_note, lineage_note(traits)))),
    )


def microseconds_per_step(angle: CriticalAngle, engine: Engine) -> float:
    """Return what a step costs [us], without what starting a run costs; NaN if it died.

    From two runs at the critical angle that differ in their steps alone, one after the other.
    """
    short = angle.case.replace(angle=angle.value_deg)
    long = short.replace(steps_per_contact=LONGER * short.steps_per_contact)
    try:
        few, many = (measured(engine, [case], "passage")[0] for case in (short, long))
    except EngineError:
        return math.nan
    steps, seconds = many.steps - few.steps, many.seconds - few.seconds
    if steps <= 0 or seconds <= 0.0:
        return math.nan
    return 1e6 * seconds / steps


def same_rules(traits: Traits, off: CriticalAngle, closed_form: float) -> Tolerance:
    """Return how close an engine and the reference DEM under its rules must be [deg].

    Round-off that moves a contact's end to another step moves one phase of the mean by its
    whole range; the digits of an output are an error of the margin.
    """
    known = REFERENCE_ANGLE
    jitter = max(known.absolute, 2.0 * off.uncertainty_deg / off.phases)
    slope = passage_margin_slope(closed_form, SHOCK_WITHOUT_REBOUND)
    digits = MARGIN_DIGITS * 10.0 ** (1 - traits.digits) / slope
    why = f"{known.reason}; {traits.digits} digits of its output are worth {digits:.1g} deg"
    return Tolerance("deg", jitter + digits, 0.0, why)


def reference_angle(
    traits: Traits, case: Incline, phases: int, study: Study
) -> CriticalAngle | EngineError | None:
    """Return the reference DEM's angle under an engine's rules; None where it has no such scheme.

    Each set of rules is run once in a study.
    """
    engine = reference_for(traits)
    if engine is None:
        return None
    key = ("incline", traits.integrator, traits.spring, case, phases)
    return study.once(key, partial(critical_angle_or_error, case, phases=phases, engine=engine))
