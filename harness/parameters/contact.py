"""The normal contact of a DEM code: linear spring, dashpot, and what becomes of the tail.

The force along the normal is ``k * overlap - eta * separation speed`` with
``eta = 2 * zeta * sqrt(k * m_eff)``. Near the end of a contact it becomes
attractive: the *tail*. A code either keeps the tail or clips it to zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from harness.parameters.allowed import Allowed, allowed_in
from harness.parameters.base import Parameters

Tail = Literal["attractive", "clipped"]
EffectiveMass = Literal["full", "half"]


class Contact(Parameters):
    """Dissipation of the linear spring-dashpot contact.

    ``damping_ratio`` wins over ``restitution`` when both are given, as on the
    command line. Restitution 0 is critical damping.
    """

    name: str = Field("custom", description="[-] what reports call this contact")
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] | None = Field(
        None, description="[-] nominal coefficient of restitution"
    )
    damping_ratio: Annotated[float, Field(ge=0.0, le=100.0)] | None = Field(
        None, description="[-] zeta, 1 is critical damping"
    )
    tail: Tail = Field("attractive", description="[-] rule for the attractive tail")
    effective_mass: EffectiveMass = Field(
        "full", description="[-] against a fixed sphere: m (full) or m/2 (half)"
    )

    @model_validator(mode="after")
    def _has_damping(self) -> Contact:
        if self.restitution is None and self.damping_ratio is None:
            raise ValueError("a contact needs a restitution (0 to 1) or a damping ratio (0 to 100)")
        return self

    def replace(self, **changes: Any) -> Self:
        """Return a copy with ``changes``; a restitution alone takes the damping ratio's place."""
        if changes.get("restitution") is not None:
            changes.setdefault("damping_ratio", None)
        return super().replace(**changes)

    @property
    def stated_restitution(self) -> float | None:
        """Return the restitution that states the damping, None where a damping ratio does."""
        return self.restitution if self.damping_ratio is None else None

    @property
    def zeta(self) -> float:
        """Return the damping ratio: |ln e| / sqrt(pi^2 + ln^2 e), 1 for e = 0 (critical)."""
        if self.damping_ratio is not None:
            return self.damping_ratio
        assert self.restitution is not None
        if self.restitution == 0.0:
            return 1.0
        logarithm = abs(math.log(self.restitution))
        return logarithm / math.hypot(math.pi, logarithm)

    @property
    def zeta_against_full_mass(self) -> float:
        """Return eta / (2 sqrt(k m)): the damping ratio of the grain on a fixed sphere.

        A code that takes m/2 for the effective mass damps less than it says.
        """
        return self.zeta * (math.sqrt(0.5) if self.effective_mass == "half" else 1.0)


SOURCE = Contact(name="source", restitution=1e-20, damping_ratio=None, tail="attractive")
"""The contact of Harper, Dufek and Breard: e = 1e-20, attractive tail kept."""

CLIPPED = Contact(name="clipped", restitution=0.0, damping_ratio=None, tail="clipped")
"""Critical damping, tail clipped: really rebounds, with e = exp(-2) = 0.135."""

PLASTIC = Contact(name="plastic", restitution=None, damping_ratio=5.0, tail="clipped")
"""Overdamped and clipped: no tail, no rebound; the contact to extrapolate."""

CONTACTS = {contact.name: contact for contact in (SOURCE, CLIPPED, PLASTIC)}


def _by_name(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if value not in CONTACTS:
        raise ValueError(f"must be one of {', '.join(CONTACTS)}")
    return CONTACTS[value]


NamedContact = Annotated[Contact, BeforeValidator(_by_name)]
"""A contact, or the name of one in ``CONTACTS``."""

Spring = Literal["linear", "Hertz"]
"""The elastic law of a contact's normal force."""


def contact_values(contact: Contact) -> dict[str, str | int | float]:
    """Return what a script is told of a contact: zeta from the restitution (0: critical), or given.

    The same names and units in every engine's scripts.
    """
    by_ratio = contact.damping_ratio is not None
    return {
        "damping": "ratio" if by_ratio else "restitution",
        "restitution": float(contact.restitution or 0.0),
        "damping_ratio": contact.zeta if by_ratio else 1.0,
        "effective_mass": contact.effective_mass,
        "tail": contact.tail,
    }


def contact_allowed() -> dict[str, Allowed]:
    """Return what scripts allow for the values of a contact."""
    return {"damping": Allowed(words=("restitution", "ratio")), **allowed_in(Contact)}


def contact_of(values: Mapping[str, Any], name: str = "custom") -> Contact:
    """Return the contact that a script's values state, the inverse of :func:`contact_values`."""
    by_ratio = values["damping"] == "ratio"
    return Contact(
        name=name,
        restitution=None if by_ratio else values["restitution"],
        damping_ratio=values["damping_ratio"] if by_ratio else None,
        tail=values["tail"],
        effective_mass=values["effective_mass"],
    )
