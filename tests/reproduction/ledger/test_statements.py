from pathlib import Path

import pytest

from harness.reproduction.claims import FIGURES, SOURCES, ClaimStatus, Ledger

ROOT = Path(__file__).parents[3]

# equation (A7) is (16) again
NUMBERED = {f"eq-{i}" for i in range(1, 19)} | {f"eq-a{i}" for i in range(1, 12) if i != 7}
STATUSES = {
    ClaimStatus.REPRODUCED: "text-t-n text-critical-angle text-mfix-angle eq-3",
    ClaimStatus.CORRECTED: "eq-2 eq-3-index eq-6 eq-7 eq-9 eq-12 eq-15 eq-16 eq-18 eq-a2 eq-a8 "
    "eq-a10 eq-four-inserted eq-u-2 text-divergence text-u-n-particles",
    ClaimStatus.NOT_REPRODUCED: "eq-13 text-t-c text-no-solution text-mfix-validation text-plateau "
    "text-impulses-decrease text-structure-window",
}


def test_every_statement_is_there(ledger):
    keys = {row.source.key for row in ledger.statements}
    assert keys == set(SOURCES) - set(FIGURES)
    assert keys >= NUMBERED


@pytest.mark.parametrize("status", STATUSES)
def test_status(ledger, status):
    keys = STATUSES[status].split()
    assert {key: ledger[key].status for key in keys} == dict.fromkeys(keys, status)


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
    assert rows["text-lammps-angle"].status is ClaimStatus.REPRODUCED
    assert rows["text-lammps-step"].status is ClaimStatus.NOT_REPRODUCED
    assert rows["text-restitution-angle"].status is ClaimStatus.NOT_REPRODUCED
    assert abs(rows["text-restitution-angle"].found - 10.21) < 0.02
