"""The widths that several rows share, each with its reason."""

from __future__ import annotations

from harness.reproduction.claims import Width


def round_off(unit: str = "1", absolute: float = 1e-12) -> Width:
    """Return the width for two routes to one formula, on numbers of about one."""
    return Width(absolute, unit, "two routes in double precision, numbers of about 1: round-off")


def last_digit(step: float, unit: str) -> Width:
    """Return half of the last digit that the source prints."""
    return Width(0.5 * step, unit, "half of the last digit printed")
