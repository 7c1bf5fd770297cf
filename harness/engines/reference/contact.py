"""The normal contact: linear or Hertz's spring with its dashpot, the tail kept or clipped."""

from __future__ import annotations

import math

from harness.compiled import compiled


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
