"""What the theory of one shock says of a contact that rebounds."""

from __future__ import annotations

from harness.parameters.contact import Contact
from harness.theory.critical_angle import critical_angle
from harness.theory.dashpot import restitution_clipped, restitution_unclipped
from harness.theory.shock import Reading, shock_from_restitution

READINGS: tuple[Reading, ...] = ("kept", "lost")

ONE_SHOCK = 0.2
"""Restitution up to which the rebounds within a well hardly move the critical angle."""


def rebound(contact: Contact) -> float:
    """Return the restitution of the grain on a fixed sphere, with its own effective mass."""
    law = restitution_clipped if contact.tail == "clipped" else restitution_unclipped
    return law(contact.zeta_against_full_mass)


def closed_forms(contact: Contact) -> dict[Reading, float]:
    """Return the critical angle [deg] at the contact's restitution in both readings."""
    e = rebound(contact)
    return {reading: critical_angle(shock_from_restitution(e, reading)) for reading in READINGS}


def theory_in_words(contact: Contact) -> str:
    """Return one sentence on what the theory gives for a contact."""
    kept, lost = closed_forms(contact).values()
    return (
        f"at e = {rebound(contact):.3g} the theory of one shock gives {kept:.4g} deg (energy kept) "
        f"or {lost:.4g} deg (velocity lost), and describes neither the many rebounds within a "
        "well: see `dem-harness theory --restitution` and the report's section on the contacts"
    )
