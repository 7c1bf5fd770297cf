"""How far limits may be from what is expected, and runs from their baseline, and why."""

from __future__ import annotations

import math

from harness.comparison.tolerances import Tolerance
from harness.parameters.contact_law import ContactLaw

SMOOTH = 1e-6
KINKED = 1e-4

_UPSTREAM = "the tests of the codes themselves allow 1e-3 to 1e-1"

WHY_SMOOTH = (
    "the law is smooth over the contact, and the series in the step is known: what its next term "
    f"leaves is below a millionth; {_UPSTREAM}"
)
WHY_KINKED = (
    "sliding, or a clipped force, begins or ends within a step, at another phase on every rung: a "
    "jitter of the order of the step squared, on the coarsest of which the series rests; "
    f"{_UPSTREAM}"
)

WHY_JUMPS = (
    "sliding, or the end of the contact, takes a dashpot off within a step, at another phase on "
    f"every rung: what friction, or the contact, passes on in the finest step at most; {_UPSTREAM}"
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


SPINS = {"spin_ratio", "halfway_spin_ratio"}
"""Quantities of a spin times the radius: 5/2, m r^2 / I, of what a force leaves of a velocity."""

NORMAL = "normal_restitution"


def jump_of(law: ContactLaw, steps: float, quantity: str, *, slides: bool, ends: bool) -> float:
    """Return what a force that jumps within a step leaves of a ratio, for the steps of a contact.

    A dashpot within Coulomb's limit, taken off as an impact ``slides``, passes on mu F_n too much
    or too little for a step at most: of an impulse (1 + e) m v_n, a half sine, pi/2 over the
    steps; 5/2 of that in a spin, for impacts at 45 degrees; nothing along the normal. Where the
    contact ``ends`` with a dashpot it is one step's share. In a contact that lasts throughout, a
    step is less than a 10,000th of the run: the width of a kink has room for its share.
    """
    lever = 2.5 if quantity in SPINS else 1.0
    slip = lever * 0.5 * math.pi * (law.friction or 0.0) * (1.0 + (law.restitution or 1.0))
    along = slip if slides and quantity != NORMAL else 0.0
    return max(1.0 if ends else 0.0, along) / steps


def width_of(unit: str, *, kinked: bool, jump: float = 0.0, digits: int = 15) -> Tolerance:
    """Return the tolerance about an expected limit; ratios are of the size of 1.

    ``jump`` is that of :func:`jump_of`. ``digits`` are those of the code's output.
    """
    part, why = (KINKED, WHY_KINKED) if kinked else (SMOOTH, WHY_SMOOTH)
    if digits <= SINGLE:
        part, why = KINKED, WHY_SINGLE
    if jump > part:
        part, why = jump, WHY_JUMPS
    return Tolerance("", part, 0.0, why) if unit == "1" else Tolerance(unit, 0.0, part, why)
