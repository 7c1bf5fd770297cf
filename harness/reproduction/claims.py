"""The ledger: what a publication states, what we compute, and whether it holds.

Every standing follows from numbers of the run. Three of them meet in a row:
*printed*, what the statement gives when taken as it stands; *found*, the same
quantity by an independent route; *corrected*, the statement with one named
correction.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]


class Standing(StrEnum):
    """What became of a statement."""

    REPRODUCED = "reproduced"
    CORRECTED = "reproduced with a correction"
    NOT_REPRODUCED = "not reproduced"
    UNTESTABLE = "cannot be tested here"


@dataclass(frozen=True)
class Source:
    """A place in the publication, and what stands there.

    ``key`` is unique in a ledger (``eq-6``, ``table-1-well``, ``text-t-c``,
    ``fig-4``, ``erratum-3``); ``where`` names section and number; ``says`` is one
    sentence or formula.
    """

    key: str
    where: str
    says: str


@dataclass(frozen=True)
class Statement:
    """One row of the ledger.

    ``computed`` says in words what this run found, with its numbers;
    ``correction`` names what has to be changed for the statement to hold;
    ``evidence`` are links, relative to the report's folder or the repository
    (``figures/x.svg``, ``tests/theory/test_shock.py``). Numbers are NaN where
    the statement has none; ``tolerance`` is absolute, in ``unit``, and ``why``
    says where it comes from, or why a statement cannot be tested.
    """

    source: Source
    standing: Standing
    computed: str
    correction: str = ""
    evidence: tuple[str, ...] = ()
    printed: float = math.nan
    found: float = math.nan
    corrected: float = math.nan
    tolerance: float = math.nan
    unit: str = ""
    why: str = ""

    def record(self) -> dict[str, Any]:
        """Return the row as a flat JSON-ready mapping."""
        row = asdict(self)
        row |= row.pop("source") | {"standing": str(self.standing)}
        row["evidence"] = " ".join(self.evidence)
        first = ("key", "where", "says", "standing")
        return {key: row[key] for key in (*first, *(k for k in row if k not in first))}


@dataclass(frozen=True)
class Width:
    """How far printed and found may lie apart [unit], and why."""

    absolute: float
    unit: str
    why: str


def compare(
    source: Source,
    *,
    printed: float,
    found: float,
    width: Width,
    computed: str,
    corrected: float = math.nan,
    correction: str = "",
    evidence: tuple[str, ...] = (),
) -> Statement:
    """Return the row of a statement that gives a number; NaN is never reproduced.

    Reproduced if ``printed`` is ``found`` within ``width``; with a correction if
    only ``corrected`` is; else not reproduced. A correction that was not needed
    is left out of the row.
    """
    if abs(printed - found) <= width.absolute:
        standing = Standing.REPRODUCED
    elif abs(corrected - found) <= width.absolute:
        standing = Standing.CORRECTED
    else:
        standing = Standing.NOT_REPRODUCED
    return Statement(
        source,
        standing,
        computed,
        correction if standing is not Standing.REPRODUCED else "",
        evidence,
        printed,
        found,
        corrected,
        width.absolute,
        width.unit,
        width.why,
    )


def compare_everywhere(
    source: Source,
    *,
    printed: ArrayLike,
    found: ArrayLike,
    width: Width,
    computed: str,
    corrected: ArrayLike | None = None,
    correction: str = "",
    evidence: tuple[str, ...] = (),
) -> Statement:
    """Return the row of a formula that was tried at many samples and must hold at each.

    ``printed``, ``found`` and ``corrected`` have one length; the row shows the sample at
    which ``printed`` lies furthest off, and ``computed`` is given the largest differences.
    A correction that fails anywhere is none.
    """
    printed, found = np.ravel(printed).astype(float), np.ravel(found).astype(float)
    other = np.full_like(found, math.nan) if corrected is None else np.ravel(corrected)
    off = np.nan_to_num(np.abs(printed - found), nan=math.inf)
    repaired = bool(np.all(np.abs(other - found) <= width.absolute))
    at = int(np.argmax(off))
    return compare(
        source,
        printed=float(printed[at]),
        found=float(found[at]),
        width=width,
        computed=f"{computed}; {_largest(off, other - found, width.unit)}",
        corrected=float(other[at]) if repaired else math.nan,
        correction=correction,
        evidence=evidence,
    )


def _largest(printed: Floats, corrected: Floats, unit: str) -> str:
    """Say how far off a formula is at most, as printed and, if there is one, corrected."""
    said = f"off by at most {printed.max():.1e}" + ("" if unit == "1" else f" {unit}")
    if not np.isfinite(corrected).all():
        return said
    return f"{said} as printed, {np.abs(corrected).max():.1e} corrected"


def claim(
    source: Source,
    *,
    holds: bool,
    computed: str,
    corrected_holds: bool = False,
    correction: str = "",
    evidence: tuple[str, ...] = (),
    why: str = "",
) -> Statement:
    """Return the row of a statement in words, judged by a condition on this run's numbers."""
    if holds:
        standing = Standing.REPRODUCED
    else:
        standing = Standing.CORRECTED if corrected_holds else Standing.NOT_REPRODUCED
    return Statement(source, standing, computed, "" if holds else correction, evidence, why=why)


def untestable(source: Source, why: str, *, computed: str = "not computed") -> Statement:
    """Return the row of a statement that needs what is not here, with the reason."""
    return Statement(source, Standing.UNTESTABLE, computed, why=why)


@dataclass(frozen=True)
class Ledger:
    """All statements, in the order of the publication."""

    statements: tuple[Statement, ...] = field(default=())

    def __post_init__(self) -> None:
        keys = [s.source.key for s in self.statements]
        twice = sorted({key for key in keys if keys.count(key) > 1})
        if twice:
            raise ValueError(f"statements that are there twice: {', '.join(twice)}")

    def __getitem__(self, key: str) -> Statement:
        """Return the statement of a key; raise KeyError for one that is not there."""
        for statement in self.statements:
            if statement.source.key == key:
                return statement
        raise KeyError(key)

    def count(self, standing: Standing) -> int:
        """Return how many statements have a standing."""
        return sum(s.standing is standing for s in self.statements)

    def frame(self) -> pd.DataFrame:
        """Return the ledger as a table, one row a statement."""
        import pandas as pd

        return pd.DataFrame([statement.record() for statement in self.statements])
