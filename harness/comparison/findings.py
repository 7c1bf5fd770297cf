"""What verifying one case in one engine leaves: checks, values for the baseline, evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.divergence import Comparison
from harness.comparison.published import Number
from harness.comparison.verdicts import Check
from harness.errors import EngineError


@dataclass(frozen=True)
class Headline:
    """A result to be told first: expected value and measured one with its uncertainty.

    ``name`` is the quantity, ``who`` the engine that measured it (as its provenance names it),
    ``note`` how.
    """

    name: str
    unit: str
    expected: Number
    value: Number
    uncertainty: Number
    who: str
    note: str = ""


@dataclass
class Findings:
    """What a case found in an engine (or in the harness's own solvers, ``engine`` empty).

    ``records`` are the values held against the baseline, ``errors`` those of records whose run
    died, by the record's name, ``untested`` why a record could not be made, by its name or a
    pattern of names (``*``, ``?``); ``divergences`` the series that left the band about their
    reference. ``published`` are keys of results.json. ``evidence`` is the case's own: what its
    sections are made from.
    """

    case: str
    engine: str = ""
    checks: list[Check] = field(default_factory=list)
    records: list[BaselineRecord] = field(default_factory=list)
    errors: dict[str, EngineError] = field(default_factory=dict)
    untested: dict[str, str] = field(default_factory=dict)
    divergences: list[Comparison] = field(default_factory=list)
    headlines: list[Headline] = field(default_factory=list)
    published: Mapping[str, Any] = field(default_factory=dict)
    evidence: Any = field(default=None, repr=False)

    def add(self, other: Findings) -> None:
        """Add the records, errors and headlines of a part that was run beside others."""
        self.records += other.records
        self.errors |= other.errors
        self.headlines += other.headlines
