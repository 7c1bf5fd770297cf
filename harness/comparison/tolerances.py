"""How far a value may be from what is expected, with the reason."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerance:
    """An absolute and a relative tolerance; a difference within their sum passes."""

    unit: str
    absolute: float
    relative: float
    reason: str

    def width(self, expected: float) -> float:
        """Return the tolerance about an expected value."""
        return self.absolute + self.relative * abs(expected)
