"""What a case sets in the input of an engine: one name and one unit for every engine's scripts."""

from __future__ import annotations

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.errors import RequestError
from harness.parameters.contact import Contact
from harness.parameters.tower import Property, Tower

Value = str | int | float
Values = dict[str, Value]

PROPERTIES: tuple[Property, ...] = ("stiffness", "mass", "diameter")
"""Of each particle of a tower."""


def contact_values(contact: Contact) -> Values:
    """Return the dashpot of a contact: zeta from the restitution (0: critical), or given."""
    by_ratio = contact.damping_ratio is not None
    return {
        "damping": "ratio" if by_ratio else "restitution",
        "restitution": float(contact.restitution or 0.0),
        "damping_ratio": contact.zeta if by_ratio else 1.0,
        "effective_mass": contact.effective_mass,
    }


def incline_values(case: Incline) -> Values:
    """Return what every engine is told of an incline, but for its row and its phase."""
    return {
        "angle": case.angle,
        "stiffness": case.stiffness,
        "steps_per_contact": case.steps_per_contact,
        "gravity": case.gravity,
        "diameter": case.diameter,
        "density": case.density,
        "wells": case.wells,
        "time_limit": case.time_limit,
        **contact_values(case.contact),
    }


def drop_values(case: Drop) -> Values:
    """Return what every engine is told of a drop."""
    return {
        "stiffness": case.stiffness,
        "steps_per_contact": case.steps_per_contact,
        "gravity": case.gravity,
        "diameter": case.diameter,
        "density": case.density,
        "gap": case.gap,
        "speed": case.speed,
        "sideways": case.sideways,
        "steps": case.steps,
        "series_every": case.every,
        **contact_values(case.contact),
    }


def tower_values(case: Tower, duration: float, steps_per_contact: float, who: str) -> Values:
    """Return what every engine is told of a tower of equal particles, over a duration in t0.

    Raise RequestError for unequal particles, which the script of the engine ``who`` does not have.
    """
    check_equal_particles(case, who)
    return {
        **{name: case.each(name)[0] for name in PROPERTIES},
        "height": case.height,
        "speed": case.speed,
        "gravity": case.gravity,
        "base": case.base,
        "start": case.start,
        "gap": case.gap,
        "duration": duration,
        "steps_per_contact": steps_per_contact,
    }


def check_equal_particles(case: Tower, who: str) -> None:
    """Raise RequestError for a tower of particles that are not all alike."""
    if any(len(set(case.each(name))) > 1 for name in PROPERTIES):
        raise RequestError(f"mass, stiffness and diameter must be one number each in {who}'s tower")


def check_overlap_law(case: Tower, who: str) -> None:
    """Raise RequestError for a tower under another law than the one that DEM codes have."""
    if case.law != "overlap":
        raise RequestError(
            f"law = {case.law!r}: {who} has the overlap law only; choose law 'overlap', or lammps "
            "for the other"
        )
