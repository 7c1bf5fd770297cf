"""The normal contact: linear or Hertz's spring with its dashpot, the tail kept or clipped."""

from __future__ import annotations

import math

from harness.engines.reference.compiled import compiled
from harness.parameters.contact import Contact


def damping(contact: Contact, stiffness: float, mass: float) -> float:
    """Return the dashpot's coefficient eta = 2 zeta sqrt(k m_eff) [N s/m].

    ``m_eff`` is the grain's mass against a fixed sphere, or half of it, as the
    contact says.
    """
    effective = 0.5 * mass if contact.effective_mass == "half" else mass
    return 2.0 * contact.zeta * math.sqrt(stiffness * effective)


@compiled
def normal_force(
    overlap: float, separation_speed: float, stiffness: float, damping: float, clipped: bool
) -> float:
    """Return k delta - eta * separation speed [N] of two spheres that touch; clipped: never < 0."""
    force = stiffness * overlap - damping * separation_speed
    if clipped and force < 0.0:
        return 0.0
    return force


@compiled
def hertz_force(
    overlap: float, separation_speed: float, coefficient: float, damping: float, clipped: bool
) -> float:
    """Return K delta^(3/2) - K A sqrt(delta) separation speed [N]; ``damping`` is K A.

    Nothing where there is no overlap.
    """
    root = math.sqrt(max(overlap, 0.0))
    force = root * (coefficient * overlap - damping * separation_speed)
    if clipped and force < 0.0:
        return 0.0
    return force
