from pathlib import Path

import pytest

from harness.reproduction.claims import FIGURES, SOURCES, ClaimStatus, Ledger

ROOT = Path(__file__).parents[3]

REPRODUCED, CORRECTED = ClaimStatus.REPRODUCED, ClaimStatus.CORRECTED
NOT = ClaimStatus.NOT_REPRODUCED
# equation (A7) is (16) again
NUMBERED = {f"eq-{i}" for i in range(1, 19)} | {f"eq-a{i}" for i in range(1, 12) if i != 7}
UNNUMBERED = {
    "eq-pair-distance",
    "eq-series-force",
    "eq-u-1",
    "eq-u-2",
    "eq-chain-length",
    "eq-four-inserted",
    "eq-four",
}
TABLE = {"table-1-well", "table-1-gain", "table-1-first-shock"}
STATUSES = {
    "eq-6": CORRECTED,
    "eq-16": CORRECTED,
    "eq-a2": CORRECTED,
    "eq-a8": CORRECTED,
    "eq-7": CORRECTED,
    "eq-9": CORRECTED,
    "eq-13": NOT,
    "text-t-c": NOT,
    "eq-12": CORRECTED,
    "text-t-n": REPRODUCED,
    "text-no-solution": NOT,
    "eq-15": CORRECTED,
    "text-divergence": CORRECTED,
    "eq-18": CORRECTED,
    "eq-u-2": CORRECTED,
    "text-u-n-particles": CORRECTED,
    "text-critical-angle": REPRODUCED,
    "text-mfix-angle": REPRODUCED,
    "text-mfix-validation": NOT,
    "eq-2": CORRECTED,
    "eq-3": REPRODUCED,
    "eq-3-index": CORRECTED,
    "eq-a10": CORRECTED,
    "eq-four-inserted": CORRECTED,
    "text-plateau": NOT,
    "text-impulses-decrease": NOT,
    "text-structure-window": NOT,
}


def test_every_numbered_equation_display_and_table_is_there(ledger):
    keys = {row.source.key for row in ledger.statements}
    assert keys >= NUMBERED | UNNUMBERED | TABLE
    assert keys == set(SOURCES) - set(FIGURES)


def test_status(ledger):
    assert {key: ledger[key].status for key in STATUSES} == STATUSES


def test_evidence_exists(ledger):
    links = {link for row in ledger.statements for link in row.evidence}
    missing = [link for link in links if not (ROOT / link).is_file()]
    assert not missing


def test_without_an_engine_the_incline_cannot_be_tested(ledger):
    for key in ("text-lammps-angle", "text-lammps-step", "text-restitution-angle"):
        assert ledger[key].status is ClaimStatus.UNTESTABLE
        assert "engine" in ledger[key].why


@pytest.mark.live
def test_incline_in_lammps(lammps_here):  # noqa: ARG001
    from harness.engines.registry import open_engine
    from harness.reproduction.claims import PRINTED
    from harness.reproduction.ledger import background

    with open_engine() as engine:
        rows = Ledger(tuple(background.background_incline_statements(PRINTED, engine)))
    assert rows["text-lammps-angle"].status is REPRODUCED
    assert rows["text-lammps-step"].status is NOT
    assert rows["text-restitution-angle"].status is NOT
    assert abs(rows["text-restitution-angle"].found - 10.21) < 0.02
