"""Options of several values: numbers as ``1-19`` or ``1,2,5``."""

from __future__ import annotations

import re
from collections.abc import Iterable

from harness.errors import RequestError

_MOST = 10_000


def heights(text: str) -> list[int]:
    """Return the heights of ``1-19,30``, each once, in the order given.

    Raise RequestError for what is not one, and for heights outside 1 to 10000.
    """
    found: dict[int, None] = {}
    for part in text.split(","):
        ends = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", part.strip(), re.ASCII)
        if ends is None:
            raise RequestError(
                f"--heights {text!r}: {part.strip()!r} must be a whole number or a range, as 1-19"
            )
        first, last = int(ends[1]), int(ends[2] or ends[1])
        if not 1 <= first <= last <= _MOST:
            raise RequestError(f"--heights {text!r}: {part.strip()} must rise within 1 to {_MOST}")
        found |= dict.fromkeys(range(first, last + 1))
    return list(found)


def numbers(texts: Iterable[str], option: str) -> list[float]:
    """Return the numbers of ``["1e5,1e6", "1e7"]``, each once, in the order given.

    Raise RequestError for what is not one; its range is for the parameters to judge.
    """
    found: dict[float, None] = {}
    for text in texts:
        for part in text.split(","):
            try:
                found[float(part)] = None
            except ValueError:
                raise RequestError(f"{option} {text!r}: {part!r} is not a number") from None
    return list(found)
