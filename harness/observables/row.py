"""A row of a result: a value with its uncertainty and unit, what it is of, what is expected of it.

It is the one form in which a value goes from a case to the baseline, a diff, the
releases and a report. :class:`harness.comparison.verdicts.Check` is a row that was judged.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass
from typing import Annotated, TypeVar

from pydantic import BeforeValidator

Number = Annotated[
    float,
    BeforeValidator(lambda value: math.nan if value is None else value),
]
"""A number that may be missing: null in JSON, NaN here."""


@dataclass(frozen=True)
class Row:
    """A value: ``name`` is the quantity, ``unit`` that of every number, empty for a pure number.

    ``uncertainty`` is 0 for what is the same every time and NaN where it is not known, ``expected``
    NaN where nothing is. ``who`` has the value: an engine as its provenance names it, or a
    publication. ``note`` says how it was found.
    """

    name: str
    value: Number
    uncertainty: Number
    unit: str
    expected: Number = math.nan
    who: str = ""
    note: str = ""

    @property
    def difference(self) -> Number:
        """Return value - expected."""
        return self.value - self.expected


R = TypeVar("R", bound=Row)


def by_name(*rows: R) -> dict[str, R]:
    """Return rows by their names; of two of one name the last."""
    return {row.name: row for row in rows}


def numbered(
    rows: Iterable[R], key: Callable[[R], tuple[Hashable, ...]]
) -> Iterator[tuple[tuple[Hashable, ...], int, R]]:
    """Yield the key of each row, how many of the same key came before, and the row."""
    seen: Counter[tuple[Hashable, ...]] = Counter()
    for row in rows:
        yield key(row), seen[key(row)], row
        seen[key(row)] += 1
