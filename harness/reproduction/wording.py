"""How numbers of a run are told: rounded, bounded, put into formulas and sentences."""

from __future__ import annotations

import string
from collections.abc import Mapping
from typing import Any

import numpy as np

_NUMPY = ("abs", "cos", "exp", "isfinite", "nan", "pi", "radians", "sin", "sqrt", "sum")
_BUILT_IN = (all, bool, len, max, min, range, round, zip)
_FUNCTIONS = {name: getattr(np, name) for name in _NUMPY} | {f.__name__: f for f in _BUILT_IN}

DIGITS = 7
"""Significant digits of a recorded number: round-off of other machines stays below them."""

ROUND_OFF = 1e-12
"""Of numbers of about 1: a difference below it is told as a bound, not as a number."""


def rounded(value: float, tolerance: float = 0.0) -> float:
    """Return a number to :data:`DIGITS` digits, 0 for one below a hundredth of a tolerance.

    A residual of round-off thus becomes 0, and other machines record the same number.
    """
    if abs(value) < 0.01 * tolerance:
        return 0.0
    return float(f"{value:.{DIGITS}g}") + 0.0  # no minus before a zero


def evaluated(formula: str, numbers: Mapping[str, Any]) -> Any:
    """Return the value of a formula of ``source.toml``, a file of this package, by numpy."""
    return eval(formula, {"__builtins__": {}, **_FUNCTIONS, **numbers})


def told(sentence: str, numbers: Mapping[str, Any]) -> str:
    """Put numbers into a sentence of ``source.toml``: ``{x:.3f}``, of a list one by one.

    What stands in the braces is a formula; ``{x:bound}`` is what :func:`bounded` says.
    """
    return _Sentences().vformat(sentence, (), numbers)


class _Sentences(string.Formatter):
    def get_field(self, field_name: str, _: Any, kwargs: Any) -> Any:
        """Return the value of what stands in the braces."""
        return evaluated(field_name, kwargs), field_name

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a number, or several with commas between them."""
        if isinstance(value, (list, tuple, np.ndarray)):
            return ", ".join(self.format_field(one, format_spec) for one in value)
        return bounded(value) if format_spec == "bound" else format(value, format_spec)


def bounded(value: float, bound: float = ROUND_OFF) -> str:
    """Return the size of a difference in words: ``less than 1e-12`` where it is round-off."""
    return f"less than {bound:.0e}" if abs(value) < bound else f"{value:.0e}"
