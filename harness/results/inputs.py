"""Digests of inputs, which show that an engine was given another script, value or scene.

A digest is a hash and a sum, as "00f0a6d29b3c41e5 12.3456789012". The hash is of all but the sizes
of numbers, which are in the sum: those that follow from an integration differ by 1e-14 on another
CPU and by 1e-11 with another scipy. Rounded, one would lie next to a limit of rounding.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

SAME = 1e-8  # largest difference of two sums of one input; one number off by 1e-7 is beyond it
GOLDEN = 0.6180339887498949  # its multiples modulo 1 are the weights of numbers


def digest(content: Any) -> str:
    """Return the digest of nested lists and tables of texts and numbers.

    A file counts by its name, which must be that of its content: each user has other folders.
    """
    numbers: list[float] = []
    text = json.dumps(_without_sizes(content, numbers))
    weights = ((1.0 + place * GOLDEN % 1.0) for place in range(len(numbers)))
    total = math.fsum(w * math.log(abs(x)) for w, x in zip(weights, numbers, strict=True))
    return f"{hashlib.sha256(text.encode()).hexdigest()[:16]} {total:.10f}"


def differ(before: Iterable[str], after: Iterable[str]) -> NDArray[np.bool_]:
    """Return which digests are of different inputs, shape (rows,); an empty one is of none.

    One without a sum was rounded by an earlier version: it is not compared with one that has it.
    """
    return np.array([_is_other(*pair) for pair in zip(before, after, strict=True)], bool)


def _is_other(before: str, after: str) -> bool:
    if not before or not after or before == after:
        return False
    (hash_before, sum_before), (hash_after, sum_after) = _parts(before), _parts(after)
    if math.isnan(sum_before) != math.isnan(sum_after):
        return False
    return hash_before != hash_after or not abs(sum_before - sum_after) <= SAME


def _parts(text: str) -> tuple[str, float]:
    name, _, number = text.partition(" ")
    try:
        return name, float(number)
    except ValueError:
        return name, math.nan


def _without_sizes(content: Any, numbers: list[float]) -> Any:
    """Return the content with the sign in place of each number, and append those to a list."""
    if isinstance(content, float) and math.isfinite(content):
        numbers += [content] if content else []
        return math.copysign(1.0, content) if content else 0.0
    if isinstance(content, str) and content.startswith("/"):
        return content.rpartition("/")[2]
    if isinstance(content, dict):
        return {name: _without_sizes(value, numbers) for name, value in content.items()}
    if isinstance(content, list | tuple):
        return [_without_sizes(item, numbers) for item in content]
    return content
