"""How far a run may be from its baseline: one table, with the reason, and named overrides.

The same script, binary and machine give the same bits: in-process, as an
executable, on 1 and 2 MPI ranks and over 20 repetitions the measured spread is
exactly 0. What is allowed is what another compiler, processor or release does
to the rounding. That is measured too: other units for the same motion (scale
invariance) round every operation differently, and move the critical angle by
2e-13 deg at most; the releases of 2022 to 2025 are another measure
(``dem-harness releases``). The widths below leave two to four orders of ten above that, and stay
two below what a stiffness off by 0.1 % does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from harness.comparison.tolerances import Tolerance

REGRESSION: dict[str, Tolerance] = {
    "critical_angle_deg": Tolerance(
        "deg",
        1e-9,
        0.0,
        "a root of the margin or a bisection, the same numbers every time: round-off of about "
        "1e5 steps, measured at 2e-13 deg by a change of units",
    ),
    "extrapolated_angle_deg": Tolerance(
        "deg",
        1e-8,
        0.0,
        "a weighted fit through the rungs passes their round-off on, enlarged less than ten times",
    ),
    "margin_over_mgd": Tolerance(
        "",
        1e-11,
        0.0,
        "energy of one passage over m g d: round-off of 1e4 steps on numbers of order 1; the "
        "most sensitive number there is",
    ),
    "step_s": Tolerance("s", 0.0, 1e-12, "time over steps, a quotient of two exact counts"),
    "peak_force_N": Tolerance(
        "N",
        0.0,
        1e-9,
        "overlap times stiffness: positions to 20 m round at 4e-15 m, 4e-9 N of 2e3 N, and add up",
    ),
    "impulse_Ns": Tolerance(
        "N s", 0.0, 1e-9, "momentum at a root of the compression rate: round-off of 3e3 steps"
    ),
    "contact_changes": Tolerance("", 0.0, 0.0, "a count: one change more or less is a change"),
    "last_change_t0": Tolerance(
        "t0", 1.01e-3, 0.0, "a thousand samples per t0: round-off may move a change to the next one"
    ),
    "impulse_ratio": Tolerance("", 0.0, 1e-9, "a quotient of two impulses, each to round-off"),
    "series": Tolerance(
        "",
        0.0,
        1e-9,
        "over the largest value of the column: round-off of 1e4 steps; written to 12 digits",
    ),
}
"""Keyed by quantity; ``series`` is the band about every series."""


@dataclass(frozen=True)
class Override:
    """A named exception to the table, for the cases and quantities that match two patterns."""

    name: str
    case: str
    quantity: str
    tolerance: Tolerance

    def applies(self, case: str, quantity: str) -> bool:
        """Return whether a quantity of a case is meant."""
        return fnmatchcase(case, self.case) and fnmatchcase(quantity, self.quantity)


def regression_tolerance(
    case: str, quantity: str, overrides: Sequence[Override] = ()
) -> tuple[Tolerance, str]:
    """Return the tolerance of a quantity of a case, and the name of the override behind it.

    The last override that applies wins. Raise KeyError for an unknown quantity.
    """
    for override in reversed(overrides):
        if override.applies(case, quantity):
            return override.tolerance, override.name
    return REGRESSION[quantity], ""
