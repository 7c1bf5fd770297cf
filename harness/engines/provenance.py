"""The provenance of a result: the code, its release, and how it was run."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_DATE = re.compile(rf"(\d{{1,2}}) ?({'|'.join(_MONTHS)}) ?(20\d\d)")


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
    return (int(date[3]), 1 + _MONTHS.index(date[2]), int(date[1]), *numbers)


@dataclass(frozen=True)
class Provenance:
    """Identify the engine behind a result.

    ``how`` is ``in-process``, ``executable`` or the launcher that started it, with the arguments
    of the executable, or ``compiled``.
    """

    engine: str
    engine_version: str
    packages: tuple[str, ...] = field(default=(), repr=False)
    executable: str = ""
    how: str = ""
    script: str = ""
    script_sha256: str = ""
    integrator: str = ""

    @property
    def label(self) -> str:
        """Return the engine with its version, and how it was run."""
        return ", ".join(filter(None, (f"{self.engine} {self.engine_version}".strip(), self.how)))
