"""How far limits may be from what is expected, and runs from their baseline, and why.

A width is a part of the quantity's size in the run: that of its value in SI units; of a ratio 1, or
its limit, or the largest that it has (:meth:`ContactCase.sizes`). Small values of large quantities
are known no better than these; small quantities are.
"""

from __future__ import annotations

from harness.cases.contact_base.scales import SMOOTH
from harness.comparison.tolerances import Tolerance

KINKED = 1e-4
ALONG_PATH = 1e-5
"""Of what begins or ends within a step along a given motion."""

_UPSTREAM = "the tests of the codes themselves allow 1e-3 to 1e-1"

WHY_SMOOTH = (
    "the law is smooth over the contact, and the series in the step is known: what its next term "
    f"leaves is below a millionth; {_UPSTREAM}"
)
WHY_KINKED = (
    "sliding, a clipped force or a dashpot begins or ends within a step, at another phase for "
    "every step: a jitter that falls with it, until the limit is known to this; "
    f"{_UPSTREAM}"
)

WHY_ALONG_PATH = (
    "along a given motion: what is cut back is so at the end of a step, the direction of sliding "
    "turns by steps: an error of the order of a step's part of a piece, squared, 1.6e-6 at level "
    f"quick, and a few times it; {_UPSTREAM}"
)

SINGLE = 7
"""Digits of single precision."""

WHY_SINGLE = (
    "written in single precision: a position to 6e-8 of the box, which is a hundred to a thousand "
    f"overlaps, and the series in the step multiplies it by a few; {_UPSTREAM}"
)

AGAIN = Tolerance(
    "", 1e-9, 1e-9, "round-off of a few thousand steps on ratios of the size of 1, and ten times it"
)
"""Of the baseline's records."""


def width_of(
    unit: str,
    *,
    kinked: bool,
    digits: int = 15,
    size: float = 1.0,
    along_path: bool = False,
) -> Tolerance:
    """Return the tolerance about an expected limit; what that is uncertain by is no part of it.

    ``digits`` are those of the code's output. ``size`` is that of a ratio in the run.
    ``along_path``: of forces along a given motion, without a jump.
    """
    part, why = (KINKED, WHY_KINKED) if kinked else (SMOOTH, WHY_SMOOTH)
    if kinked and along_path:
        part, why = ALONG_PATH, WHY_ALONG_PATH
    if digits <= SINGLE:
        # of coordinates, whatever the size of a ratio
        part, why, size = KINKED, WHY_SINGLE, max(1.0, size)
    if unit != "1":
        return Tolerance(unit, 0.0, part, why)
    if size != 1.0:
        why = f"{part:.3g} of the quantity's size in the run, {size:.3g}: {why}"
    return Tolerance("", part * size, 0.0, why)
