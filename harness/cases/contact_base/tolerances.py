"""How far limits may be from what is expected, and runs from their baseline, and why."""

from __future__ import annotations

from harness.comparison.tolerances import Tolerance

SMOOTH = 1e-6
KINKED = 1e-4

_UPSTREAM = "the tests of the codes themselves allow 1e-3 to 1e-1"

WHY_SMOOTH = (
    "the law is smooth over the contact, and the series in the step is known: what its next term "
    f"leaves is below a millionth; {_UPSTREAM}"
)
WHY_KINKED = (
    "sliding begins or ends within a step, at another phase on every rung: a jitter of the order "
    f"of the step squared, on the coarsest of which the series rests; {_UPSTREAM}"
)

REGRESSION = {
    "series": Tolerance("", 0.0, 1e-9, "round-off of a few thousand steps, the same every time"),
    "*": Tolerance("", 1e-10, 1e-9, "round-off of a few thousand steps, the same every time"),
}
"""Of the baseline's records."""


def width_of(unit: str, *, kinked: bool) -> Tolerance:
    """Return the tolerance about an expected limit; ratios are of the size of 1."""
    part = KINKED if kinked else SMOOTH
    why = WHY_KINKED if kinked else WHY_SMOOTH
    return Tolerance(unit, part if unit == "1" else 0.0, 0.0 if unit == "1" else part, why)
