"""A record of the baseline: what one run, or one search, left in numbers and a series."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Required, TypedDict

from harness.comparison.divergence import Series
from harness.comparison.verdicts import Cell
from harness.observables.provenance import Provenance


@dataclass(frozen=True)
class Quantity:
    """A number with its uncertainty, which is 0 for a run that is the same every time."""

    value: float
    uncertainty: float
    unit: str


@dataclass(frozen=True)
class BaselineRecord:
    """A record, measured now or kept in the baseline; two of the same name are compared.

    ``name`` is ``engine/what`` and the path of its file. ``parameters`` is
    JSON-ready. ``levels`` are the levels of ``verify`` that run it. ``case`` is the name of the
    case, ``label`` says in short what the record is, and records of one ``family`` tell about
    each other.
    """

    name: str
    parameters: Mapping[str, Any]
    quantities: Mapping[str, Quantity]
    engine: str
    engine_version: str
    how: str = ""
    platform: str = ""
    script: str = ""
    script_sha256: str = ""
    levels: tuple[str, ...] = ()
    case: str = ""
    label: str = ""
    family: tuple[str, ...] = ()
    series: Series | None = field(default=None, repr=False)

    def at(self, level: str, platform: str) -> BaselineRecord:
        """Return the case as measured at a level of ``verify``, on a platform."""
        return replace(self, levels=(level,), platform=platform)


class Made(TypedDict, total=False):
    """Who made a case, as fields of it."""

    engine: Required[str]
    engine_version: Required[str]
    how: str
    script: str
    script_sha256: str


def record_name(engine: str, case: str, words: str) -> str:
    """Return ``engine/case-words``, of the words letters, digits, points and underscores only."""
    kept = "".join(c if c.isalnum() or c in "._" else " " for c in words)
    return f"{engine}/{case}-{'-'.join(kept.split())}"


def name_in_cell(cell: Cell) -> str:
    """Return the name of the record of a cell's values, in its engine."""
    return record_name(cell.engine, cell.case, f"{cell.submodel} {cell.system}")


def made_by(who: Provenance | None, solver: str = "", version: str = "") -> Made:
    """Return who made a case: an engine, or a solver of this harness in its ``version``."""
    if who is None:
        return {"engine": solver, "engine_version": f"dem-harness {version}"}
    return {
        "engine": who.engine,
        "engine_version": who.engine_version,
        "how": who.how,
        "script": who.script,
        "script_sha256": who.script_sha256,
    }
