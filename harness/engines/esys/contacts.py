"""Contacts with friction in ESyS-Particle: interactions and rules, read off the source of 2.3.

``RotFricInteraction.cpp``: a linear spring without a dashpot; the force of the tangential one is
summed up in space, and does not turn with the contact; it acts where the distance of the centres
is parted as the radii are. Its walls have no friction.
"""

from __future__ import annotations

from harness.engines.contact_model import PLANES, ContactModel, States, never_attracts, takes

RULES = {"torque_lever": "share", "velocity_lever": "share", "spring_frame": "room"}

_MOVES: States = {"motion_1": ("free",), "motion_2": ("free", "frozen")}
_SPHERES: States = {PLANES: (0,), **_MOVES}

CONTACTS = (
    ContactModel("RotElastic", takes("hooke", "none", "none") | _MOVES),
    ContactModel("RotFriction", takes("hooke", "none", "linear_history") | _SPHERES, RULES),
    ContactModel("HertzianElastic", takes("hertz", "none", "none") | _SPHERES),
    ContactModel(
        "HertzianViscoElastic",
        takes("hertz", "viscoelastic", "none") | _SPHERES,
        needs=never_attracts,
    ),
)
