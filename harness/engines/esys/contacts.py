"""Contacts with friction in ESyS-Particle: interactions and rules, read off the source of 2.3.

``RotFricInteraction.cpp``: a linear spring without a dashpot; the force of the tangential one is
summed up in space, and does not turn with the contact; it acts where the distance of the centres
is parted as the radii are. Its walls have no friction.
"""

from __future__ import annotations

from harness.engines.contact_model import NO_RESISTANCE, ContactModel, never_attracts

RULES = {"torque_lever": "share", "velocity_lever": "share", "spring_frame": "room"}

_PLAIN: dict[str, tuple[str, ...]] = {
    **NO_RESISTANCE,
    "motion_1": ("free",),
    "motion_2": ("free", "frozen"),
}


CONTACTS = (
    ContactModel(
        "RotElastic",
        {"normal": ("hooke",), "damping": ("none",), "tangential": ("none",), **_PLAIN},
    ),
    ContactModel(
        "RotFriction",
        {
            "normal": ("hooke",),
            "damping": ("none",),
            "tangential": ("linear_history",),
            "planes": (0,),
            **_PLAIN,
        },
        RULES,
    ),
    ContactModel(
        "HertzianElastic",
        {
            "normal": ("hertz",),
            "damping": ("none",),
            "tangential": ("none",),
            "planes": (0,),
            **_PLAIN,
        },
    ),
    ContactModel(
        "HertzianViscoElastic",
        {
            "normal": ("hertz",),
            "damping": ("viscoelastic",),
            "tangential": ("none",),
            "planes": (0,),
            **_PLAIN,
        },
        needs=never_attracts,
    ),
)
