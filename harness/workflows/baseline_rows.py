"""The records of a verification, and its rows against the baseline."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any

from harness.cases.contract import Case
from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.findings import Findings
from harness.comparison.regression import Baseline, Expected, Regression, against_baseline
from harness.errors import EngineError


def here() -> str:
    """Return the platform that a record is measured on."""
    return f"{platform.system()} {platform.machine()}"


@dataclass(frozen=True)
class Measured:
    """What a verification measured at a level in its main engine and the own solvers.

    ``engine`` is the name that the main engine's records have. ``broken`` says why a part ended
    early, by the name of its case.
    """

    level: str
    engine: str
    cases: Sequence[Case[Any]]
    findings: Sequence[Findings]
    broken: dict[str, str] = field(default_factory=dict)

    @property
    def records(self) -> list[BaselineRecord]:
        """Return every record, each once."""
        once = {record.name: record for found in self.findings for record in found.records}
        return [record.at(self.level, here()) for record in once.values()]

    @property
    def errors(self) -> dict[str, EngineError]:
        """Return the errors of records whose run died, by name."""
        return {name: error for found in self.findings for name, error in found.errors.items()}

    def reason(self, record: BaselineRecord) -> str:
        """Return why a record could not be made, or nothing where it should have been."""
        for found in self.findings:
            for pattern, reason in found.untested.items():
                if fnmatchcase(record.name, pattern):
                    return reason
        return self.broken.get(record.case, "")


def baseline_rows(
    measured: Measured, baseline: Baseline, beside: Iterable[BaselineRecord]
) -> Regression:
    """Return the rows of a verification against the baseline.

    Of engines ``beside`` the main one, which run less, those records that the baseline has.
    """
    names = {record.name for record in measured.records}
    solvers = {solver for case in measured.cases for solver in case.solvers}
    own = {record.engine for record in measured.records}
    expected = Expected(
        engines={measured.engine, *solvers, *own},
        cases={case.name for case in measured.cases},
        errors=measured.errors,
        reason=measured.reason,
    )
    known = [
        record.at(measured.level, here())
        for record in beside
        if record.name in baseline.records and record.name not in names
    ]
    return against_baseline(
        [*measured.records, *known],
        baseline,
        measured.level,
        expected,
        {case.name: case.regression for case in measured.cases},
    )
