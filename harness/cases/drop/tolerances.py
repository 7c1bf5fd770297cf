"""How far the numbers of drops may be from their baseline, and why."""

from __future__ import annotations

from harness.comparison.tolerances import Tolerance

_ROUND_OFF = "round-off of 1e5 steps on numbers of order 1, the same every time"

REGRESSION: dict[str, Tolerance] = {
    "restitution": Tolerance("", 1e-10, 0.0, _ROUND_OFF),
    "static_overlap_ratio": Tolerance(
        "", 1e-9, 0.0, f"{_ROUND_OFF}; the overlap cancels three digits of the position"
    ),
    "fall_ratio": Tolerance("", 1e-10, 0.0, _ROUND_OFF),
    "angular_momentum_ratio": Tolerance("", 1e-10, 0.0, _ROUND_OFF),
    "onset_steps": Tolerance(
        "steps", 1e-6, 0.0, "a place over the way of a step, 5e-4 d: round-off of the place"
    ),
}
"""Of the baseline's records, by quantity."""
