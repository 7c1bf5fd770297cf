"""The critical angles of one engine, against the closed form and the reference DEM.

Engines within a class agree, across classes they need not: how far two classes are apart is known
beforehand, from the reference DEM under both rules.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import ClassVar

from harness.cases.incline.angle import CriticalAngle, critical_angle_or_error
from harness.cases.incline.levels import (
    ENGINES_OF_ONE_CLASS,
    ENGINES_PLASTIC,
    LEVELS,
    REFERENCE_ANGLE,
    SOURCE_CLIPPED,
    STATED,
)
from harness.cases.incline.runs import measured
from harness.cases.incline.system import Incline
from harness.cases.verification import Study
from harness.comparison.verdicts import (
    Check,
    Kind,
    Tolerance,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.engines.contract import Engine
from harness.engines.reference import Reference
from harness.engines.traits import Traits
from harness.errors import EngineError
from harness.observables.row import Row
from harness.parameters.law import PLASTIC, SOURCE, Contact, EffectiveMass, Tail
from harness.shown import Record
from harness.theory.chain import SHOCK_WITHOUT_REBOUND
from harness.theory.incline import critical_angle as closed_form
from harness.theory.incline import passage_margin_slope

OWN = "reference"
"""The harness's own DEM, that the others are held against."""

PLASTIC_ROLE, SOURCE_ROLE = PLASTIC.name, SOURCE.name


def contacts_of(traits: Traits) -> list[Contact]:
    """Return the plastic and the source's contact for an engine, in its effective mass.

    Where the engine does not support the source's, its clipped form follows.
    """
    contacts = [PLASTIC, SOURCE, SOURCE_CLIPPED]
    if "full" not in traits.frictionless.states["effective_mass"]:
        contacts = [
            contact.replace(effective_mass="half", name=f"{contact.name}, m_eff m/2")
            for contact in contacts
        ]
    return contacts if traits.refuses_contact(contacts[1]) else contacts[:2]


def reference_for(traits: Traits) -> Reference | None:
    """Return the reference DEM in an engine's scheme; None where it has no such."""
    return Reference(traits.integrator) if traits.integrator else None


@dataclass(frozen=True, kw_only=True)
class EngineAngle(Row, Record):
    """A critical angle [deg] of an engine (``who``), beside theory and the reference DEM.

    The closed form is ``expected``, and the reference DEM has the engine's rules.

    ``role`` is the contact that ``contact`` stands for in the engine, ``plastic`` or ``source``.
    ``reference_deg`` is NaN where the reference DEM has no such rules;
    ``microseconds_per_step`` is the cost, NaN where none was measured. ``lineage`` is the
    engine that it grew out of.
    """

    role: str
    contact: Contact
    stiffness: float  # [N/m]
    steps_per_contact: float
    integrator: str
    reference_deg: float = math.nan
    microseconds_per_step: float = math.nan
    lineage: str = ""

    JSON: ClassVar = {
        "engine": "who",
        "contact": "contact.name",
        "tail": "contact.tail",
        "effective_mass": "contact.effective_mass",
        "stiffness_N_per_m": "stiffness",
        "steps_per_contact": "steps_per_contact",
        "critical_angle_deg": "value",
        "uncertainty_deg": "uncertainty",
        "off_theory_deg": "difference",
        "reference_deg": "reference_deg",
        "off_reference_deg": "off_reference_deg",
        "integrator": "integrator",
        "microseconds_per_step": "microseconds_per_step",
        "evidence": "evidence",
    }

    @property
    def rules(self) -> tuple[Tail, EffectiveMass]:
        """Return the class of the law: results are comparable only within one."""
        return self.contact.tail, self.contact.effective_mass

    @property
    def rules_text(self) -> str:
        """Return the class in words."""
        return f"{self.contact.tail} tail, m_eff {self.contact.mass_text}"

    @property
    def off_reference_deg(self) -> float:
        """Return the difference from the reference DEM under the same rules [deg]."""
        return self.value - self.reference_deg

    @property
    def evidence(self) -> str:
        """Return what kind of evidence the value is."""
        if self.who == OWN:
            return "the harness's own"
        return "regression partner" if self.lineage else "independent"


def across_engines(angles: Sequence[EngineAngle]) -> list[Check]:
    """Return the rows of engines against one another, at the stated stiffness and step.

    Those of the first engine's class are judged; other classes are findings beside it.
    """
    rows: list[Check] = []
    live = [a for a in angles if a.who != OWN]
    base = live[0].who if live else ""
    for role in (PLASTIC_ROLE, SOURCE_ROLE):
        at_stated_step = [
            a for a in live if a.role == role and (a.stiffness, a.steps_per_contact) == STATED
        ]
        for angle, other in combinations(at_stated_step, 2):
            if _one_class(angle, other) and angle.contact.tail == "attractive":
                rows.append(_agree(angle, other))
            elif angle.who == base and angle.rules != other.rules:
                rows.append(_apart(other, angle))
    return rows


def _one_class(angle: EngineAngle, other: EngineAngle) -> bool:
    return (angle.rules, angle.integrator) == (other.rules, other.integrator)


def _agree(angle: EngineAngle, other: EngineAngle) -> Check:
    partners = {angle.lineage.lower(), other.lineage.lower()} & {angle.who, other.who}
    return judge(
        f"engines: {other.who} against {angle.who}, {other.contact.name} contact, unclamped",
        Kind.CROSS_CODE,
        other.value,
        angle.value,
        ENGINES_OF_ONE_CLASS,
        uncertainty=angle.uncertainty + other.uncertainty,
        note="one grew out of the other: a regression partner" if partners else "",
    )


def _apart(angle: EngineAngle, base: EngineAngle) -> Check:
    return finding(
        f"engines: {angle.who}, {angle.contact.name} contact, less {base.who}, {base.contact.name}",
        angle.value - base.value,
        angle.reference_deg - base.reference_deg,
        "deg",
        f"two classes ({angle.rules_text} against {base.rules_text}); expected is what the "
        "reference DEM makes of the two rules",
        angle.uncertainty + base.uncertainty,
    )


STIFF = 1e6
"""[N/m] from which the plastic contact is held against the closed form: softer ones are biased."""

MARGIN_DIGITS = 1.25
"""Of the last digit, in m g d: half of one in the height and in the spring, less in the motion."""

LONGER = 10.0
"""How many times the steps of a critical angle a run takes that is to tell what a step costs."""


def angle_checks(engine: Engine, study: Study, angles: list[EngineAngle]) -> list[Check]:
    """Measure the critical angles of an engine and return their rows; add to ``angles``."""
    rows: list[Check] = []
    for contact in contacts_of(engine.traits):
        if refused := engine.traits.refuses_contact(contact):
            name = f"{engine.name}: critical angle, {contact.name} contact"
            rows.append(not_tested(name, Kind.ANALYTIC, refused, "deg"))
            continue
        for stiffness, steps in LEVELS[study.level].engines:
            case = Incline(contact=contact, stiffness=stiffness, steps_per_contact=steps)
            rows += _cell(engine, case, study, angles)
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


def _cell(engine: Engine, case: Incline, study: Study, angles: list[EngineAngle]) -> list[Check]:
    traits = engine.traits
    name = f"{engine.name}: critical angle, {where(case)}"
    cross_name = f"{engine.name}: critical angle against the reference DEM, {where(case)}"
    at = (case.stiffness, case.steps_per_contact)
    phases = LEVELS[study.level].phases_of_engines
    result = critical_angle_or_error(case, phases=phases, engine=engine)
    if isinstance(result, EngineError):
        untested = not_tested(cross_name, Kind.CROSS_CODE, "the engine's own run died", "deg")
        return [failed_run(name, Kind.ANALYTIC, result, "deg"), untested]
    angle = EngineAngle(
        "critical angle",
        result.value_deg,
        result.uncertainty_deg,
        "deg",
        closed_form(),
        engine.name,
        role=case.contact.name.partition(",")[0],
        contact=case.contact,
        stiffness=case.stiffness,
        steps_per_contact=case.steps_per_contact,
        integrator=traits.integrator,
        microseconds_per_step=microseconds_per_step(result, engine) if at == STATED else math.nan,
        lineage=traits.lineage,
    )
    reference = reference_angle(traits, case, phases, study)
    if isinstance(reference, CriticalAngle):
        angle = replace(angle, reference_deg=reference.value_deg)
    angles.append(angle)
    rows = [_against_theory(name, angle, result.phases_note, traits)]
    if engine.name != OWN:
        rows.append(_against_reference(cross_name, result, reference, traits, angle.expected))
    return rows


def _against_theory(name: str, angle: EngineAngle, phases: str, traits: Traits) -> Check:
    of_theory = angle.role == PLASTIC_ROLE
    if of_theory and angle.stiffness >= STIFF:
        return judge(
            name,
            Kind.ANALYTIC,
            angle.value,
            angle.expected,
            ENGINES_PLASTIC,
            uncertainty=angle.uncertainty,
            note="; ".join(filter(None, (phases, lineage_note(traits)))),
        )
    unclamped = "not the limit of the closed form, but a class of its own"
    soft = f"below {STIFF:g} N/m the bias of the stiffness is not small"
    why = f"{angle.rules_text}; {soft if of_theory else unclamped}"
    note = "; ".join(filter(None, (why, phases, lineage_note(traits))))
    return finding(name, angle.value, angle.expected, "deg", note, angle.uncertainty)


def _against_reference(
    name: str,
    angle: CriticalAngle,
    reference: CriticalAngle | EngineError | None,
    traits: Traits,
    closed_form: float,
) -> Check:
    if reference is None:
        reason = "the reference DEM does not have the engine's scheme"
        return not_tested(name, Kind.CROSS_CODE, reason, "deg")
    if isinstance(reference, EngineError):
        return failed_run(name, Kind.CROSS_CODE, reference, "deg")
    note = f"reference DEM: {traits.integrator}"
    return judge(
        name,
        Kind.CROSS_CODE,
        angle.value_deg,
        reference.value_deg,
        same_rules(traits, reference, closed_form),
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
    jitter = max(REFERENCE_ANGLE.absolute, 2.0 * off.uncertainty_deg / off.phases)
    slope = passage_margin_slope(closed_form, SHOCK_WITHOUT_REBOUND)
    digits = MARGIN_DIGITS * 10.0 ** (1 - traits.digits) / slope
    why = (
        f"{REFERENCE_ANGLE.reason}; {traits.digits} digits of its output are worth {digits:.1g} deg"
    )
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
    key = ("incline", traits.integrator, case, phases)
    return study.once(key, partial(critical_angle_or_error, case, phases=phases, engine=engine))
