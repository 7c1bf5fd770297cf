"""Text of numbers and names, as pages, figures and the terminal show them."""

from __future__ import annotations

import math
import re

ROUND_OFF = 14  # decimals beyond which an uncertainty is round-off and is not shown
DIGITS = 8  # of a value in a table
SHORT = 2  # digits of a difference, an uncertainty or a tolerance
_ESCAPES = re.compile(
    r"\x1b\[[0-?]*[ -/]*[@-~]"  # colours, moves of the cursor
    r"|\x1b[\]PX^_].*?(?:\x07|\x1b\\|$)"  # titles, links, other strings
    r"|\x1b[ -/]*[0-~]",
    re.DOTALL,
)
# all but tab and newline, marks that reverse the direction of writing, halves of surrogate pairs
_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def value_text(value: float, uncertainty: float = 0.0, unit: str = "") -> str:
    """Return a value with its uncertainty and unit, to the first digit of the uncertainty.

    >>> value_text(10.206981, 0.00042, "deg")
    '10.2070 ± 0.0004 deg'
    >>> value_text(0.56613974), value_text(math.nan, unit="m/s")
    ('0.56613974', '-')
    """
    unit = "" if unit == "1" or math.isnan(value) else unit
    places = decimals(uncertainty)
    certain = uncertainty <= 0.0 or not math.isfinite(value) or not math.isfinite(uncertainty)
    if certain or places > ROUND_OFF:
        return f"{number(value)} {unit}".rstrip()
    return f"{value:.{places}f} ± {uncertainty:.{places}f} {unit}".rstrip()


def number(value: float, digits: int = DIGITS) -> str:
    """Return a number for a table, a dash for a missing one."""
    return "-" if math.isnan(value) else f"{value:.{digits}g}"


def decimals(uncertainty: float) -> int:
    """Return the decimals down to the first digit of an uncertainty, to the second after a 1."""
    if not math.isfinite(uncertainty) or uncertainty <= 0.0:
        return ROUND_OFF + 1
    exponent = math.floor(math.log10(uncertainty))
    leading = round(uncertainty / 10.0**exponent)
    return max(0, 1 - exponent if leading == 1 else -exponent)


def power(value: float) -> str:
    """Return a number as a power of ten with a factor of at most two digits.

    >>> power(1e6), power(250000.0)
    ('1e6', '2.5e5')
    """
    factor, exponent = f"{value:.1e}".split("e")
    return f"{float(factor):g}e{int(exponent)}"


def printable(text: str) -> str:
    """Return text without escape sequences of terminals, other control characters as ``?``."""
    return _CONTROLS.sub("?", _ESCAPES.sub("", text.replace("\r\n", "\n")))


def one_line(text: str) -> str:
    """Return printable text on one line."""
    return " ".join(printable(text).split())
