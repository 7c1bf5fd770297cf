"""Engines held against one another: within a class they agree, across classes they need not.

How far two classes are apart is known beforehand, from the reference DEM under both rules.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from harness.cases.incline.engine_angle import OWN, EngineAngle
from harness.cases.incline.levels import STATED
from harness.cases.incline.rules import PLASTIC_ROLE, SOURCE_ROLE
from harness.cases.incline.tolerances import ENGINES_OF_ONE_CLASS
from harness.comparison.verdicts import Check, Kind, finding, judge


def across_engines(angles: Sequence[EngineAngle]) -> list[Check]:
    """Return the rows of engines against one another, at the stated stiffness and step.

    Those of the first engine's class are judged; other classes are findings beside it.
    """
    rows: list[Check] = []
    live = [a for a in angles if not a.recorded and a.engine != OWN]
    base = live[0].engine if live else ""
    for role in (PLASTIC_ROLE, SOURCE_ROLE):
        stated = [
            a for a in live if a.role == role and (a.stiffness, a.steps_per_contact) == STATED
        ]
        for one, other in combinations(stated, 2):
            if _one_class(one, other) and one.rules.tail == "attractive":
                rows.append(_agree(one, other))
            elif one.engine == base and one.rules != other.rules:
                rows.append(_apart(other, one))
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
        ENGINES_OF_ONE_CLASS,
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
