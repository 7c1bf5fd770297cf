"""The templates of the reproduction, and how numbers are written in them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from harness.report.templating import environment

if TYPE_CHECKING:
    from jinja2 import Environment


def templates() -> Environment:
    """Return the environment of page and findings; what is Markdown is not escaped."""
    made = environment("harness.reproduction")
    made.autoescape = lambda name: not (name or "").endswith(".md.j2")
    made.filters |= {"angle": angle, "signed": signed, "measured": measured, "power": power}
    return made


def power(stiffness: float) -> str:
    """Return a stiffness as ``1e6``."""
    return f"{stiffness:.0e}".replace("e+0", "e")


def angle(value: float, digits: int) -> str:
    """Return an angle; a dash for one that is missing."""
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def signed(value: float, digits: int) -> str:
    """Return a difference with its sign."""
    return f"{value:+.{digits}f}"


def measured(value: float, uncertainty: float = math.nan) -> str:
    """Return a value with its uncertainty, to the digits that the uncertainty leaves."""
    if math.isnan(value):
        return "-"
    return f"{value:.3f}" if math.isnan(uncertainty) else f"{value:.3f} ± {uncertainty:.1g}"
