"""Values of a sweep as text: lists such as ``1,2,5`` and ranges such as ``1e5:1e7:log5``."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from harness.errors import RequestError

MOST_VALUES = 100_000
"""Of one parameter, and runs of one sweep: each is a row that is held in memory."""

GRAMMAR = "values as 1,2,5, or ranges as 9:11:5 (evenly spaced) and 1e5:1e7:log5 (in the logarithm)"

DIGITS = 15
"""Of the numbers of a range: 0.3, not 0.30000000000000004."""


def values_of(name: str, text: str) -> list[str]:
    """Return the values of a text, as ``--set`` takes them, each once and in the order given.

    Items stand between commas. An item with colons is a range ``FIRST:LAST:COUNT`` of so many
    numbers, evenly spaced with both ends, or ``FIRST:LAST:logCOUNT``, evenly spaced in the
    logarithm. Raise RequestError for what is neither.
    """
    found: dict[str, None] = {}
    for item in text.split(","):
        found |= dict.fromkeys(_range(name, item) if ":" in item else [item.strip()])
        if "" in found:
            raise RequestError(f"--over {name}={text}: a value is empty; must be {GRAMMAR}")
    return list(found)


def as_text(values: Any) -> str:
    """Return values of a TOML file or of Python as the text of the command line."""
    if isinstance(values, str):
        return values
    many = values if isinstance(values, Iterable) else [values]
    return ",".join(str(value) for value in many)


def flat(tree: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested tables with dots in their names, as ``--set`` takes them."""
    found: dict[str, Any] = {}
    for name, value in tree.items():
        inner = isinstance(value, Mapping)
        found |= flat(value, f"{prefix}{name}.") if inner else {prefix + name: value}
    return found


def _range(name: str, item: str) -> list[str]:
    parts = [part.strip() for part in item.split(":")]
    said = f"--over {name}={item}"
    count = re.fullmatch(r"(log)?(\d{1,9})", parts[-1], re.ASCII)
    try:
        first, last = (float(part) for part in parts[:-1])
    except ValueError:
        raise RequestError(f"{said}: must be {GRAMMAR}") from None
    if count is None or not (math.isfinite(first) and math.isfinite(last)):
        raise RequestError(f"{said}: must be {GRAMMAR}")
    if not 2 <= int(count[2]) <= MOST_VALUES:
        raise RequestError(f"{said}: a range has from 2 to {MOST_VALUES} values")
    if count[1] and not (first > 0.0 and last > 0.0):
        raise RequestError(f"{said}: the ends of a range in the logarithm must be greater than 0")
    numbers = (np.geomspace if count[1] else np.linspace)(first, last, int(count[2]))
    return [f"{number:.{DIGITS}g}" for number in numbers]
