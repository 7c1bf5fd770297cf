"""What a run leaves: named numbers, tables of samples, log and provenance.

Scripts print the numbers as lines ``RESULT name = value``. A name comes once, or is that of rows,
with several numbers to a line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

# arrays are imported where they are made: a kept verification is answered without them
Table: TypeAlias = "Mapping[str, NDArray[np.float64]]"
"""Columns by names that end in the unit (``x_m``), each (M,), or (M, N) for N particles."""

SERIES = "series"
"""Name of the table of samples."""

CLOCKS = ("time_s", "step")
"""Columns that rise from row to row."""

PRINTED = 1e-12
"""Relative difference that a number printed with 15 digits, and the formula for it, may have."""

SHOWN = 80
"""Characters of a value that a message repeats at most."""

_RESULT = re.compile(r"^RESULT (\w+) = (.*)$", re.MULTILINE)


def results_in(text: str) -> tuple[tuple[str, str], ...]:
    """Return the pairs of name and value of all lines ``RESULT name = value``, in order."""
    return tuple(_RESULT.findall(text))


@dataclass(frozen=True)
class Output:
    """The output of one job.

    ``results`` are pairs of name and text, in order; ``tables`` map a name to columns;
    ``seconds`` is the wall time [s] of the run, ``ranks`` are those of MPI; ``title`` is the
    engine's name in messages, that of the provenance unless given. Methods raise EngineOutputError
    for what is
    missing or cannot be read and EngineNaNError for values that are not finite, both naming
    the engine.
    """

    results: tuple[tuple[str, str], ...]
    provenance: Provenance
    tables: Mapping[str, Table] = field(default_factory=dict, repr=False)
    log: str = field(default="", repr=False)
    seconds: float = 0.0
    title: str = ""
    ranks: int = 1

    @property
    def who(self) -> str:
        """Return the engine's name as messages write it."""
        return self.title or self.provenance.engine

    def has(self, name: str) -> bool:
        """Return whether there is a result of this name."""
        return any(key == name for key, _ in self.results)

    def text(self, name: str) -> str:
        """Return the result of this name as text; it may come again, but not with another one."""
        found = dict.fromkeys(value for key, value in self.results if key == name)
        if not found:
            raise EngineOutputError(f"{self.who} left an incomplete result ({name!r})")
        first, *others = found
        if others:
            raise EngineOutputError(
                f"{self.who} left two results {name!r}: {first[:SHOWN]} and {others[0][:SHOWN]}"
            )
        return first

    def number(self, name: str) -> float:
        """Return the result of this name as a finite number."""
        return self._number(name, self.text(name))

    def check_numbers(self, known: Mapping[str, float], source: str = "was requested") -> None:
        """Raise EngineOutputError where a result is another number than is known of the run.

        ``known`` are numbers by the names of results, of what ``source`` says; a result that is
        not there is not checked. It may be off by what printing it with 15 digits leaves.
        """
        for name, value in known.items():
            if self.has(name) and abs(self.number(name) - value) > PRINTED * abs(value):
                raise EngineOutputError(
                    f"{self.who} says that it ran with {name} = {self.text(name)[:SHOWN]}, "
                    f"where {value:.15g} {source}"
                )

    def rows(self, name: str, columns: int) -> NDArray[np.float64]:
        """Return all results of this name, shape (rows, columns)."""
        import numpy as np

        texts = [value.split() for key, value in self.results if key == name]
        if any(len(words) != columns for words in texts):
            raise EngineOutputError(f"{self.who} left an incomplete result ({name!r})")
        rows = [[self._number(name, word) for word in words] for words in texts]
        return np.array(rows, dtype=np.float64).reshape(-1, columns)

    def table(self, columns: Sequence[str], rows: int | None = None, name: str = SERIES) -> Table:
        """Return a table that holds at least these columns, finite, ``rows`` of them if given.

        Raise EngineOutputError also where the first column is a clock and does not rise.
        """
        import numpy as np

        table = self.tables.get(name)
        missing = [column for column in columns if table is None or column not in table]
        if table is None or missing:
            has = ", ".join(table) if table else "no columns"
            raise EngineOutputError(
                f"{self.who} left no table with {', '.join(missing)}: run must return them in "
                f"tables[{name!r}], which has {has}"
            )
        count = table[columns[0]].shape[0]
        if rows is not None and count != rows:
            raise EngineOutputError(f"{self.who} left {count} rows of a series of {rows}")
        if count == 0 or any(table[column].shape[0] != count for column in columns):
            raise EngineOutputError(f"{self.who} left an incomplete series")
        if not all(np.isfinite(table[column]).all() for column in columns):
            raise EngineNaNError(f"{self.who} wrote a series with values that are not numbers")
        if columns[0] in CLOCKS and np.any(np.diff(table[columns[0]], axis=0) <= 0.0):
            raise EngineOutputError(f"{self.who} wrote a series that is out of order")
        return table

    def _number(self, name: str, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise EngineOutputError(
                f"{self.who} left an incomplete result ({name} = {text[:SHOWN]!r})"
            ) from None
        if not math.isfinite(value):
            raise EngineNaNError(f"{self.who} returned {name} = {text[:SHOWN]}")
        return value
