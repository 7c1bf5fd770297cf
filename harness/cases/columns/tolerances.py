"""How close results of columns must be, and why."""

from __future__ import annotations

from harness.comparison.tolerances import Tolerance

ONE = Tolerance(
    "m", 1e-11, 0.0, "columns of one particle are the incline's row: round-off of 1e4 steps"
)
TWO_CODES = Tolerance(
    "m g d",
    1e-8,
    0.0,
    "the same steps in two codes: round-off, which the rattling of elastic columns magnifies",
)
RIGID = Tolerance(
    "deg", 3e-4, 0.0, "step to zero, then stiffness to infinity: as of the incline's own ladder"
)
FIRST_ORDER = Tolerance(
    "1", 0.5, 0.0, "order 1: dashpots see the velocity of the half step; jitter blurs the fit"
)
