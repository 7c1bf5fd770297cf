"""Engines held against one another: within a class they agree, across classes they need not.

How far two classes are apart is known beforehand, from the reference DEM under both rules.
"""

from __future__ import annotations

from itertools import combinations

from harness.cases.incline.engine_checks import stated_angles
from harness.cases.incline.rules import PLASTIC_ROLE, SOURCE_ROLE
from harness.comparison.engine_evidence import OWN, EngineAngle, EngineEvidence
from harness.comparison.tolerances import TOLERANCES
from harness.comparison.verdicts import Check, Kind, finding, judge

BASE = "lammps"


def across_engines(evidence: EngineEvidence) -> list[Check]:
    """Return the rows of engines against one another, at the stated stiffness and step."""
    rows: list[Check] = []
    for role in (PLASTIC_ROLE, SOURCE_ROLE):
        angles = [a for a in stated_angles(evidence) if a.contact.startswith(role)]
        for one, other in combinations(angles, 2):
            if OWN in (one.engine, other.engine):
                continue
            if _one_class(one, other) and one.rules.tail == "attractive":
                rows.append(_agree(one, other))
            elif BASE in (one.engine, other.engine) and one.rules != other.rules:
                base, beside = (one, other) if one.engine == BASE else (other, one)
                rows.append(_apart(beside, base))
    return rows


def _one_class(one: EngineAngle, other: EngineAngle) -> bool:
    return (one.rules, one.integrator) == (other.rules, other.integrator)


def _agree(one: EngineAngle, other: EngineAngle) -> Check:
    partners = {one.lineage.lower(), other.lineage.lower()} & {one.engine, other.engine}
    return judge(
        f"engines: {other.engine} against {one.engine}, {other.contact} contact, unclamped",
        Kind.CROSS_CODE,
        other.value_deg,
        one.value_deg,
        TOLERANCES["critical angle, engines of one class"],
        uncertainty=one.uncertainty_deg + other.uncertainty_deg,
        note="one grew out of the other: a regression partner" if partners else "",
    )


def _apart(beside: EngineAngle, base: EngineAngle) -> Check:
    return finding(
        f"engines: {beside.engine}, {beside.contact} contact, less {base.engine}, {base.contact}",
        beside.value_deg - base.value_deg,
        beside.reference_deg - base.reference_deg,
        "deg",
        f"two classes ({beside.rules.text} against {base.rules.text}); expected is what the "
        "reference DEM makes of the two rules",
        beside.uncertainty_deg + base.uncertainty_deg,
    )
