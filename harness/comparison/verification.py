"""All that a verification found: the checks, and the evidence behind them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.divergence import Comparison
from harness.comparison.engine_evidence import EngineEvidence
from harness.comparison.evidence import InclineEvidence, TowerEvidence
from harness.comparison.verdicts import Check, Verdict
from harness.observables.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

SCHEMA = 1
"""Version of the published form of results.json; raised when a key goes or changes its meaning."""


@dataclass(frozen=True)
class Verification:
    """The result of ``verify``.

    ``status`` is the exit status: 3 when an engine died, 1 when a verdict
    failed, else 0. ``scripts`` are the exact inputs that ran, by name, ``logs``
    the engine's log of one run that finished for each script, by the same names.
    ``measured`` are the cases of the baseline that were run, ``parted`` the
    series that left the band about their reference, ``baseline`` is where the
    accepted ones lie. ``engines`` is what engines beside LAMMPS left, None where none
    was asked for.
    """

    level: str
    started: str
    seconds: float
    platform: str
    harness_version: str
    provenance: Provenance | None
    checks: tuple[Check, ...]
    incline: InclineEvidence
    tower: TowerEvidence
    scripts: dict[str, str]
    engine_errors: tuple[str, ...] = ()
    measured: tuple[BaselineRecord, ...] = ()
    parted: tuple[Comparison, ...] = ()
    baseline: str = ""
    logs: dict[str, str] = field(default_factory=dict)
    engines: EngineEvidence | None = None

    @property
    def status(self) -> int:
        """Return the exit status that the verdicts ask for."""
        if self.engine_errors:
            return 3
        return 1 if any(check.verdict is Verdict.FAIL for check in self.checks) else 0

    def frame(self) -> pd.DataFrame:
        """Return the checks as a table, one row each."""
        import pandas as pd

        return pd.DataFrame([check.record() for check in self.checks])

    def record(self) -> dict[str, Any]:
        """Return everything but the series as a JSON-ready mapping."""
        evidence = self.incline
        ladders = [a.record() for angles in evidence.by_contact.values() for a in angles]
        return {
            "schema": SCHEMA,
            "level": self.level,
            "started": self.started,
            "seconds": self.seconds,
            "platform": self.platform,
            "harness_version": self.harness_version,
            "status": self.status,
            "engine": self.provenance.record() if self.provenance else None,
            "engine_errors": list(self.engine_errors),
            "baseline": self.baseline,
            "divergences": [series.record() for series in self.parted],
            "closed_form_deg": evidence.closed_form_deg,
            "checks": [check.record() for check in self.checks],
            "extrapolated": evidence.extrapolated.record() if evidence.extrapolated else None,
            "engines": self.engines.record() if self.engines else None,
            "critical_angles": ladders + [a.record() for a in evidence.routes],
            "scripts": {
                name: hashlib.sha256(text.encode()).hexdigest()
                for name, text in self.scripts.items()
            },
        }
