"""The order of an engine's releases, by the version that it gives of itself."""

from __future__ import annotations

import re
from datetime import datetime

_DATE = re.compile(r"(\d{1,2}) ?([A-Z][a-z]{2}) ?(20\d\d)")


def release_of(version: str) -> tuple[int, ...]:
    """Return the numbers by which releases are in order: of a date year, month, day, then others.

    >>> release_of("22 Jul 2025 - Update 4")
    (2025, 7, 22, 4)
    >>> release_of("2025.7.22.4.0")
    (2025, 7, 22, 4, 0)
    """
    date = _DATE.search(version)
    rest = version[date.end() :] if date else version
    numbers = tuple(int(n) for n in re.findall(r"\d+", rest))
    if date is None:
        return numbers
    month = datetime.strptime(date[2], "%b").month
    return (int(date[3]), month, int(date[1]), *numbers)
