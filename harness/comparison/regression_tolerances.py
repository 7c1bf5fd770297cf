"""How far a record may be from its baseline: what its case allows, and named overrides.

The same script, binary and machine give the same bits: over ways to start an engine, over ranks
and repetitions the spread is exactly 0. What a case allows is what another compiler, processor
or release does to the rounding.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from harness.comparison.tolerances import Tolerance

UNSTATED = Tolerance(
    "", 0.0, 1e-9, "the case states none: round-off of 1e5 steps, and two orders of ten above"
)
"""Where a case says nothing of a quantity or series."""

ByCase = Mapping[str, Mapping[str, Tolerance]]
"""Tolerances by the name of the case, then of the quantity; ``series`` is the band of series."""


@dataclass(frozen=True)
class Override:
    """A named exception, for the records and quantities that match two patterns."""

    name: str
    record: str
    quantity: str
    tolerance: Tolerance

    def applies(self, record: str, quantity: str) -> bool:
        """Return whether a quantity of a record is meant."""
        return fnmatchcase(record, self.record) and fnmatchcase(quantity, self.quantity)


@dataclass(frozen=True)
class Allowed:
    """The tolerances of cases, and the exceptions to them."""

    by_case: ByCase
    overrides: Sequence[Override] = ()

    def of(self, case: str, record: str, quantity: str) -> tuple[Tolerance, str]:
        """Return the tolerance of a quantity, and the name of the override behind it.

        The last override that applies wins.
        """
        for override in reversed(self.overrides):
            if override.applies(record, quantity):
                return override.tolerance, override.name
        return self.by_case.get(case, {}).get(quantity, UNSTATED), ""
