"""Section Background: the shock in the well, equations (7) to (9)."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, compare
from harness.reproduction.source import SOURCES
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
        found=kept,
        before=1.0,
        after=np.array(speeds),
        vector=vector,
        angle=critical_angle(vector),
    )
    yield compare("eq-8", found=speeds, before=1.0, e=_RESTITUTIONS)
    after_8 = SOURCES["eq-8"].printed(before=7.0, e=_RESTITUTIONS)
    yield compare(
        "text-substitution",
        printed=SOURCES["eq-9"].printed(e=_RESTITUTIONS),
        found=SOURCES["eq-7"].printed(before=7.0, after=after_8),
    )
    yield compare("eq-9", found=kept, e=_RESTITUTIONS)
    without_rebound = float(np.sum(collide(before, 0.0) ** 2))
    yield compare("text-shock", printed=printed.shock, found=without_rebound)
