"""Section Background: the shock in the well, equations (7) to (9)."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, compare
from harness.theory.critical_angle import critical_angle

_RESTITUTIONS = np.linspace(0.0, 1.0, 21)


def collide(velocity: NDArray[np.float64], restitution: float) -> NDArray[np.float64]:
    """Return the velocity after the grain meets the next sphere, in vectors.

    The new contact's normal stands 60 deg off the old one's; the normal part of
    the velocity is turned back and multiplied by ``restitution``.
    """
    normal = np.array([-1.0, 0.0])
    approach = float(velocity @ normal)
    return np.asarray(velocity - (1 + restitution) * approach * normal)


def statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    before = np.array([math.sqrt(3) / 2, -0.5])  # unit speed, 60 deg off the new tangent
    after = [collide(before, e) for e in _RESTITUTIONS]
    speeds = [float(np.hypot(*v)) for v in after]
    kept = [float(v @ v) / float(before @ before) for v in after]
    vector = float(np.sum((before - after[0]) ** 2))
    yield compare(
        "eq-7",
        printed=[as_printed.shock_of_velocities(1.0, speed) for speed in speeds],
        found=kept,
        corrected=[speed**2 for speed in speeds],
        vector=vector,
        angle=critical_angle(vector),
    )
    printed_speeds = [as_printed.velocity_after(1.0, e) for e in _RESTITUTIONS]
    yield compare("eq-8", printed=printed_speeds, found=speeds)
    lost = [as_printed.shock_of_restitution(e) for e in _RESTITUTIONS]
    yield compare(
        "text-substitution",
        printed=lost,
        found=[
            as_printed.shock_of_velocities(7.0, as_printed.velocity_after(7.0, e))
            for e in _RESTITUTIONS
        ],
    )
    yield compare(
        "eq-9", printed=lost, found=kept, corrected=[0.25 + 0.75 * e**2 for e in _RESTITUTIONS]
    )
    without_rebound = float(np.sum(collide(before, 0.0) ** 2))
    yield compare("text-shock", printed=printed.shock, found=without_rebound)
