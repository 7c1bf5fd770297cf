"""All that a reproduction found: ledger, figures, motions and findings."""

from __future__ import annotations

from dataclasses import dataclass

from harness.comparison.findings import Findings
from harness.observables.motions import Motions
from harness.observables.provenance import Provenance
from harness.reproduction.claims import Ledger
from harness.reproduction.figure_data import Exhibits


@dataclass(frozen=True)
class Reproduction:
    """The result of ``reproduce``; the same code and engine give the same one."""

    ledger: Ledger
    exhibits: Exhibits
    motions: Motions
    findings: Findings
    provenance: Provenance
    platform: str
    harness_version: str
