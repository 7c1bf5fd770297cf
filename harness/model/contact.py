"""The dissipation of the cases without friction, in the words of their parameters.

The force along the normal is ``k overlap - eta separation_speed`` with ``eta = 2 zeta sqrt(k m*)``.
Near the end of a contact it attracts: the *tail*, which a code keeps or clips to zero.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from harness.model.base import Parameters
from harness.model.law import Law, damping_ratio

Tail = Literal["attractive", "clipped"]
EffectiveMass = Literal["full", "half"]


class Contact(Parameters):
    """Dissipation of a linear spring-dashpot contact.

    A damping ratio wins over a restitution. Restitution 0 is critical damping.
    """

    # fmt: off
    name: str = Field("custom", description="[-] what reports call this contact")
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] | None = Field(
        None, description="[-] nominal coefficient of restitution")
    damping_ratio: Annotated[float, Field(ge=0.0, le=100.0)] | None = Field(
        None, description="[-] zeta, 1 is critical damping")
    tail: Tail = Field("attractive", description="[-] rule for the attractive tail")
    effective_mass: EffectiveMass = Field(
        "full", description="[-] against a fixed sphere: m (full) or m/2 (half)")
    # fmt: on

    @model_validator(mode="after")
    def _has_damping(self) -> Self:
        if self.restitution is None and self.damping_ratio is None:
            raise ValueError("a contact needs a restitution (0 to 1) or a damping ratio (0 to 100)")
        return self

    def replace(self, **changes: Any) -> Self:
        """Return a copy with ``changes``; a restitution alone replaces the damping ratio."""
        if changes.get("restitution") is not None:
            changes.setdefault("damping_ratio", None)
        return super().replace(**changes)

    @property
    def clipped(self) -> bool:
        """Return whether a parting contact never attracts."""
        return self.tail == "clipped"

    @property
    def mass_share(self) -> float:
        """Return m* over m [-] against a fixed sphere: 1 or 1/2."""
        return 1.0 if self.effective_mass == "full" else 0.5

    @property
    def zeta(self) -> float:
        """Return the damping ratio: |ln e| / sqrt(pi^2 + ln^2 e), 1 for e = 0."""
        if self.damping_ratio is not None:
            return self.damping_ratio
        assert self.restitution is not None
        return abs(damping_ratio(self.restitution))

    @property
    def zeta_against_full_mass(self) -> float:
        """Return eta / (2 sqrt(k m)): the damping ratio of a grain on a fixed sphere."""
        return float(self.zeta * self.mass_share**0.5)

    def dashpot(self, stiffness: float, mass: float) -> float:
        """Return eta = 2 zeta sqrt(k m*) [N s/m] of a stiffness [N/m] and a mass [kg]."""
        return float(2.0 * self.zeta * (stiffness * mass * self.mass_share) ** 0.5)

    def law(self, stiffness: float) -> Law:
        """Return the law of a stiffness [N/m], without friction.

        A fixed partner is frozen with effective mass ``full``, held with ``half``.
        """
        return Law.linear(stiffness, self.zeta, self.clipped)


SOURCE = Contact(name="source", restitution=1e-20)  # Harper, Dufek and Breard; the tail is kept
CLIPPED = Contact(name="clipped", restitution=0.0, tail="clipped")  # rebounds with exp(-2) = 0.135
PLASTIC = Contact(name="plastic", damping_ratio=5.0, tail="clipped")  # no tail, hardly a rebound
CONTACTS = {contact.name: contact for contact in (SOURCE, CLIPPED, PLASTIC)}


def _contact_by_name(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if value not in CONTACTS:
        raise ValueError(f"must be one of {', '.join(CONTACTS)}")
    return CONTACTS[value]


NamedContact = Annotated[Contact, BeforeValidator(_contact_by_name)]
"""A contact, or the name of one in ``CONTACTS``."""


def contact_values(contact: Contact) -> dict[str, str | int | float]:
    """Return a contact as values of scripts, whose names are the same for every engine."""
    by_ratio = contact.damping_ratio is not None
    return {
        "damping": "ratio" if by_ratio else "restitution",
        "restitution": float(contact.restitution or 0.0),
        "damping_ratio": contact.zeta if by_ratio else 1.0,
        "effective_mass": contact.effective_mass,
        "tail": contact.tail,
    }
