"""All that a reproduction found: ledger, figures, motions and findings."""

from __future__ import annotations

from dataclasses import dataclass

from harness.observables.provenance import Provenance
from harness.reproduction.claims import Ledger
from harness.reproduction.figure_data import Exhibits
from harness.reproduction.findings_tables import Findings
from harness.reproduction.row_motion import Motions


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
