"""The contacts that an engine can state, and the reference DEM under the same rules."""

from __future__ import annotations

from dataclasses import dataclass

from harness.cases.incline.engine_angle import Rules
from harness.cases.incline.levels import SOURCE_CLIPPED
from harness.engines.reference.engine import Reference
from harness.engines.traits import Traits
from harness.parameters.contact import PLASTIC, SOURCE, Contact

PLASTIC_ROLE, SOURCE_ROLE = PLASTIC.name, SOURCE.name


@dataclass(frozen=True)
class Stated:
    """A contact as an engine states it, in the role of the ``plastic`` or the ``source`` one."""

    role: str
    contact: Contact

    def rules(self, traits: Traits) -> Rules:
        """Return the class of its law in an engine."""
        return Rules(self.contact.tail, self.contact.effective_mass, traits.spring)


@dataclass(frozen=True)
class Refused:
    """A contact that an engine cannot state, and why."""

    contact: Contact
    reason: str


def contacts_of(traits: Traits) -> list[Stated | Refused]:
    """Return the plastic and the source's contact for an engine, in its effective mass.

    Where the source's cannot be stated, its clipped form follows.
    """
    plastic = _stated(traits, PLASTIC_ROLE, PLASTIC)
    source = _stated(traits, SOURCE_ROLE, SOURCE)
    if isinstance(source, Stated):
        return [plastic, source]
    return [plastic, source, _stated(traits, SOURCE_ROLE, SOURCE_CLIPPED)]


def _stated(traits: Traits, role: str, contact: Contact) -> Stated | Refused:
    if "full" not in traits.effective_masses:
        contact = contact.replace(effective_mass="half", name=f"{contact.name}, m_eff m/2")
    reason = traits.refuses_contact(contact)
    return Refused(contact, reason) if reason else Stated(role, contact)


def reference_for(traits: Traits) -> Reference | None:
    """Return the reference DEM in an engine's scheme and spring; None where it has no such."""
    if not traits.integrator:
        return None
    return Reference(traits.integrator, spring=traits.spring)
