"""The contacts that an engine can state, and the reference DEM under the same rules."""

from __future__ import annotations

from dataclasses import dataclass

from harness.cases.incline.levels import SOURCE_CLIPPED
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
