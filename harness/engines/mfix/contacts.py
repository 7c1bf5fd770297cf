"""Contacts with friction in MFiX: what it states, and by which rules.

As the source of 21.3.2 has it: ``calc_force_dem.f``, ``calc_collision_wall_mod.f``, ``cfrelvel.f``
and ``check_solids_dem.f``.
"""

from __future__ import annotations

from harness.engines.contact_model import DASHPOTS, ContactModel, States, Values, takes
from harness.engines.mfix.contact_input import ContactInput
from harness.errors import RequestError


def _needs(values: Values) -> str:
    """Return why an input cannot state a contact, or nothing where it can."""
    try:
        ContactInput(values)
    except RequestError as error:
        return str(error)
    return ""


_RULES = {
    "damping_in_cap": "until_sliding",
    "torque_lever": "circle",
    "velocity_lever": "circle",
    "wall_lever": "height",
    "spring_frame": "room",
    "frozen_mass": "own",
}
_STATES: States = {"clipped": ("no",), "motion_1": ("free",), "motion_2": ("free", "frozen")}

CONTACTS = (
    ContactModel("LSD", takes("hooke", DASHPOTS, "none linear_history") | _STATES, _RULES, _needs),
    ContactModel(
        "HERTZIAN",
        takes("hertz", "none coeff_restitution", "none mindlin") | _STATES,
        {**_RULES, "hertz_restitution": "linear"},
        _needs,
    ),
)
"""Its contact models; frictional torques act where the spheres' surfaces cut, springs keep their
direction in space, and a sliding spring is set to the limit without the dashpot."""
