"""The contacts that an engine can state, and its critical angles beside the reference DEM's.

Engines within a class agree, across classes they need not: how far two classes are apart is known
beforehand, from the reference DEM under both rules.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

from harness.cases.incline.levels import SOURCE_CLIPPED, STATED
from harness.cases.incline.tolerances import ENGINES_OF_ONE_CLASS
from harness.comparison.verdicts import Check, Kind, finding, judge
from harness.engines.reference.engine import Reference
from harness.engines.traits import Traits
from harness.parameters.contact import PLASTIC, SOURCE, Contact

OWN = "reference"
"""The harness's own DEM, that the others are held against."""

PLASTIC_ROLE, SOURCE_ROLE = PLASTIC.name, SOURCE.name


@dataclass(frozen=True)
class Rules:
    """The class of a contact law. Results are comparable only within a class."""

    tail: str
    effective_mass: str
    spring: str

    @property
    def text(self) -> str:
        """Return the class in words."""
        return f"{self.tail} tail, m_eff {self._mass}, {self.spring} spring"

    @property
    def short(self) -> str:
        """Return the class for a table."""
        return f"{self.tail}, {self._mass}, {self.spring}"

    @property
    def _mass(self) -> str:
        return "m" if self.effective_mass == "full" else "m/2"


@dataclass(frozen=True)
class Stated:
    """A contact as an engine states it, in the role of the ``plastic`` or the ``source`` one.

    ``refused`` says why the engine cannot state it, where that is so.
    """

    role: str
    contact: Contact
    refused: str = ""

    def rules(self, traits: Traits) -> Rules:
        """Return the class of its law in an engine."""
        return Rules(self.contact.tail, self.contact.effective_mass, traits.spring)


def contacts_of(traits: Traits) -> list[Stated]:
    """Return the plastic and the source's contact for an engine, in its effective mass.

    Where the source's cannot be stated, its clipped form follows.
    """
    plastic, source = _stated(traits, PLASTIC_ROLE, PLASTIC), _stated(traits, SOURCE_ROLE, SOURCE)
    clipped = [_stated(traits, SOURCE_ROLE, SOURCE_CLIPPED)] if source.refused else []
    return [plastic, source, *clipped]


def _stated(traits: Traits, role: str, contact: Contact) -> Stated:
    if "full" not in traits.effective_masses:
        contact = contact.replace(effective_mass="half", name=f"{contact.name}, m_eff m/2")
    return Stated(role, contact, traits.refuses_contact(contact))


def reference_for(traits: Traits) -> Reference | None:
    """Return the reference DEM in an engine's scheme and spring; None where it has no such."""
    if not traits.integrator:
        return None
    return Reference(traits.integrator, spring=traits.spring)


@dataclass(frozen=True)
class EngineAngle:
    """A critical angle [deg] of an engine, beside theory and the reference DEM under its rules.

    ``role`` is the contact that ``contact`` stands for in the engine, ``plastic`` or ``source``.
    ``reference_deg`` is NaN where the reference DEM has no such rules;
    ``microseconds_per_step`` is the cost, NaN where none was measured. ``lineage`` is the
    engine that it grew out of. A ``recorded`` angle was measured elsewhere.
    """

    engine: str
    role: str
    contact: str
    rules: Rules
    stiffness: float  # [N/m]
    steps_per_contact: float
    value_deg: float
    uncertainty_deg: float
    closed_form_deg: float
    integrator: str
    reference_deg: float = math.nan
    microseconds_per_step: float = math.nan
    lineage: str = ""
    recorded: bool = False

    @property
    def off_theory_deg(self) -> float:
        """Return the difference from the closed form [deg]."""
        return self.value_deg - self.closed_form_deg

    @property
    def off_reference_deg(self) -> float:
        """Return the difference from the reference DEM under the same rules [deg]."""
        return self.value_deg - self.reference_deg

    @property
    def evidence(self) -> str:
        """Return what kind of evidence the value is."""
        if self.recorded:
            return "recorded"
        if self.engine == OWN:
            return "the harness's own"
        return "regression partner" if self.lineage else "independent"

    def record(self) -> dict[str, Any]:
        """Return the angle as a flat JSON-ready mapping."""
        return {
            "engine": self.engine,
            "contact": self.contact,
            **asdict(self.rules),
            "stiffness_N_per_m": self.stiffness,
            "steps_per_contact": self.steps_per_contact,
            "critical_angle_deg": self.value_deg,
            "uncertainty_deg": self.uncertainty_deg,
            "off_theory_deg": self.off_theory_deg,
            "reference_deg": self.reference_deg,
            "off_reference_deg": self.off_reference_deg,
            "integrator": self.integrator,
            "microseconds_per_step": self.microseconds_per_step,
            "evidence": self.evidence,
        }


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
