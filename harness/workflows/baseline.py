"""Compare a run with the baseline, or accept it as the new one."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.comparison.regression import Baseline
from harness.comparison.verdicts import Check, Kind
from harness.comparison.verification import Verification, beside_tolerances, counted
from harness.engines.contract import Engine
from harness.errors import EngineError, RequestError
from harness.shown import Shown, record_frame
from harness.store.acceptance import Change, changes, check_target, write
from harness.store.baseline import checkout_baseline, committed
from harness.workflows.progress import Progress, silent
from harness.workflows.request import chosen_baseline
from harness.workflows.verification_run import verify

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure


@dataclass(frozen=True, repr=False)
class BaselineComparison(Shown):
    """A run against the baseline: the rows of kind regression, and what accepting would change."""

    found: Verification
    changes: tuple[Change, ...]

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return the rows against the baseline."""
        return tuple(check for check in self.found.checks if check.kind is Kind.REGRESSION)

    @property
    def status(self) -> int:
        """Return the exit status: 3 when an engine died, 1 when a row failed, else 0."""
        if self.found.engine_errors:
            return 3
        return 1 if any(check.verdict == "fail" for check in self.checks) else 0

    def frame(self) -> pd.DataFrame:
        """Return the rows against the baseline as a table."""
        return record_frame(self.checks)

    def told(self) -> dict[str, str]:
        """Return the verdicts, what accepting would change, and who ran."""
        return {
            "verdicts": counted(self.checks) or "none",
            "accepting would write": f"{len(self.changes)} records",
            "baseline": self.found.baseline,
            "engine": self.found.provenance.told if self.found.provenance else "none",
        }

    def drawn(self) -> Figure:
        """Draw how much of its tolerance each row takes."""
        return beside_tolerances(self.checks)

    def record(self) -> dict[str, Any]:
        """Return everything but the series as a JSON-ready mapping."""
        return {
            "baseline": self.found.baseline,
            "level": self.found.level,
            "status": self.status,
            "engine": self.found.provenance.record() if self.found.provenance else None,
            "engine_errors": list(self.found.engine_errors),
            "checks": [check.record() for check in self.checks],
            "divergences": [series.record() for series in self.found.divergences],
            "changes": [change.record() for change in self.changes],
        }


def compare_with_baseline(
    level: str = "default",
    *,
    cases: str | Iterable[str] | None = None,
    baseline: Path | None = None,
    tolerances: Path | None = None,
    engine: Engine | None = None,
    progress: Progress = silent,
) -> BaselineComparison:
    """Run the cases of a level of ``verify`` and hold them against a baseline.

    The committed baseline unless a folder is given; a folder that is not there yet is
    empty. Raise RequestError for a damaged file, which is named.
    """
    new = baseline is not None and not baseline.exists()
    known = Baseline({}, str(baseline)) if new else chosen_baseline(baseline, tolerances)
    found = verify(level, cases=cases, engine=engine, progress=progress, baseline=known)
    return BaselineComparison(found, tuple(changes(found.records, known)))


def accept_baseline(compared: BaselineComparison, folder: Path | None = None) -> Path:
    """Write what a comparison found into a baseline's folder, all of it or nothing.

    Into the project's own unless a ``folder`` is given. Raise RequestError for
    the baseline of an installed package, which is not written, and EngineError
    after a run in which an engine died.
    """
    if compared.found.engine_errors:
        first = compared.found.engine_errors[0]
        raise EngineError(f"baseline: nothing is accepted from a run that died: {first}")
    for record in (change.measured for change in compared.changes):
        if not record.quantities:
            raise EngineError(f"baseline: {record.name}: has no quantity and is not accepted")
        for name, quantity in record.quantities.items():
            for value in (quantity.value, quantity.uncertainty):
                if not math.isfinite(value):
                    raise EngineError(f"baseline: {record.name}: {name} = {value} is not accepted")
    target = where_to_accept(folder)
    write(compared.changes, target)
    return target


def where_to_accept(folder: Path | None = None) -> Path:
    """Return the folder to write; raise RequestError, before any work, if it may not be."""
    target = folder or checkout_baseline() or committed()
    if target is None:
        raise RequestError("--baseline: this installation has no baseline; name a folder to write")
    check_target(target)
    return target
