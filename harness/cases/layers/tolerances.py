"""How close the single grain on a row must come to what is known of it, and why."""

from __future__ import annotations

import math

from harness.cases.layers.parameters import RAISED, SINGLE
from harness.comparison.tolerances import Tolerance

_OVERLAP_DEG = math.degrees(1.0 / SINGLE.stiffness_over_weight)

STOP = Tolerance(
    "deg",
    SINGLE.rate + _OVERLAP_DEG,
    0.0,
    "the angle falls by the rate over the well that is not passed any more; the weight presses "
    "m g/k into the row, an angle of m g/(k d)",
)
"""Of the angle at which the single grain stops."""

_RISE = math.radians(RAISED.rise)

START = Tolerance(
    "deg",
    RAISED.rise * math.sqrt(2.0 * RAISED.arrest_speed / _RISE) + _OVERLAP_DEG,
    0.0,
    "a grain that slides from rest has the speed that is looked for sqrt(2 speed/rise) later at "
    "most; the weight presses m g/k into the row",
)
"""Of the angle at which it starts again."""
