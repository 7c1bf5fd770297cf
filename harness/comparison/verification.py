"""All that a verification found: the checks, and the evidence behind them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from harness.comparison.extrapolation import ExtrapolatedAngle
from harness.comparison.verdicts import Check, Verdict
from harness.observables.critical_angle import CriticalAngle
from harness.observables.incline import InclineRun
from harness.observables.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Recursion:
    """Energy after each shock in a run, and by the recursion from the first; in m g d."""

    run: InclineRun
    measured: NDArray[np.float64]
    predicted: NDArray[np.float64]


@dataclass
class InclineEvidence:
    """What the engine's runs of the incline left for tables and figures.

    ``by_contact`` maps the name of a contact to its angles over stiffness and
    step. What could not be measured is missing.
    """

    closed_form_deg: float
    extrapolated: ExtrapolatedAngle | None = None
    by_contact: dict[str, list[CriticalAngle]] = field(default_factory=dict)
    routes: list[CriticalAngle] = field(default_factory=list)
    motions: list[InclineRun] = field(default_factory=list)
    recursion: Recursion | None = None


@dataclass(frozen=True)
class Verification:
    """The result of ``verify``.

    ``status`` is the exit status: 3 when an engine died, 1 when a verdict
    failed, else 0. ``scripts`` are the exact inputs that ran, by name.
    """

    level: str
    started: str
    seconds: float
    platform: str
    harness_version: str
    provenance: Provenance | None
    checks: tuple[Check, ...]
    incline: InclineEvidence
    scripts: dict[str, str]
    engine_errors: tuple[str, ...] = ()

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
            "level": self.level,
            "started": self.started,
            "seconds": self.seconds,
            "platform": self.platform,
            "harness_version": self.harness_version,
            "status": self.status,
            "engine": self.provenance.record() if self.provenance else None,
            "engine_errors": list(self.engine_errors),
            "closed_form_deg": evidence.closed_form_deg,
            "checks": [check.record() for check in self.checks],
            "extrapolated": evidence.extrapolated.record() if evidence.extrapolated else None,
            "critical_angles": ladders + [a.record() for a in evidence.routes],
        }
