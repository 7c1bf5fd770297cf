import re
from pathlib import Path

import pytest

from harness.reproduction.claims import ClaimStatus, Ledger
from harness.reproduction.ledger import statements

ROOT = Path(__file__).parents[3]

REPRODUCED, CORRECTED = ClaimStatus.REPRODUCED, ClaimStatus.CORRECTED
NOT = ClaimStatus.NOT_REPRODUCED
NUMBERED = {f"eq-{i}" for i in range(1, 19)} | {f"eq-a{i}" for i in range(1, 12)}
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
    "eq-a7": CORRECTED,
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
ERRATA_OF_THE_RESTATEMENT_THAT_NEED_A_CORRECTION = {"erratum-7", "erratum-12"}


def test_every_numbered_equation_display_and_table_is_there(ledger):
    keys = {row.source.key for row in ledger.statements}
    assert keys >= NUMBERED | UNNUMBERED | TABLE
    assert {f"erratum-{i}" for i in range(1, 14)} <= keys
    assert {f"beyond-{i}" for i in range(1, 9)} <= keys


def test_equations_stand_in_the_order_of_the_publication(ledger):
    keys = [row.source.key for row in ledger.statements]
    numbered = [key for key in keys if key in NUMBERED]
    assert numbered == sorted(numbered, key=lambda k: ("a" in k, int(k.strip("eq-a"))))
    source = [key for key in keys if not key.startswith(("erratum", "beyond"))]
    assert keys[: len(source)] == source


def test_rows_about_the_restatement_are_told_apart(ledger):
    for row in ledger.statements:
        own = row.source.key.startswith(("erratum", "beyond"))
        assert own == bool(re.match("Errata|the source, App", row.source.where))


def test_status(ledger):
    assert {key: ledger[key].status for key in STATUSES} == STATUSES


def test_errata_hold_but_for_those_argued_otherwise(ledger):
    errata = [row for row in ledger.statements if row.source.key.startswith("erratum")]
    not_so = {row.source.key for row in errata if row.status is not REPRODUCED}
    assert not_so == ERRATA_OF_THE_RESTATEMENT_THAT_NEED_A_CORRECTION
    assert all(ledger[key].status is CORRECTED for key in not_so)


def test_evidence_exists(ledger):
    links = {link for row in ledger.statements for link in row.evidence}
    missing = [link for link in links if not (ROOT / link).is_file()]
    assert not missing


def test_rows_are_whole(ledger):
    for row in ledger.statements:
        key = row.source.key
        assert row.source.says, key
        assert row.source.where, key
        if row.status is ClaimStatus.UNTESTABLE:
            assert row.why, key
            continue
        assert re.search(r"\d", row.computed), key
        assert row.evidence or row.printed == row.printed, key
        if row.status is not REPRODUCED and not key.startswith(("erratum", "beyond")):
            assert row.correction or key in WITHOUT_CORRECTION, key
        if row.printed == row.printed:
            assert row.source.unit, key
            assert row.why, key


WITHOUT_CORRECTION = {
    "text-energy-agrees",  # two arguments of the source; neither corrects the other
    "text-tall-limit",
    "text-window-figure",  # caption or text, there is no telling
}


def test_without_an_engine_the_incline_cannot_be_tested(ledger):
    for key in ("text-lammps-angle", "text-lammps-step", "text-restitution-angle"):
        assert ledger[key].status is ClaimStatus.UNTESTABLE
        assert "engine" in ledger[key].why


def test_the_same_ledger_twice_with_progress_from_first_to_last(ledger):
    seen = []
    again = statements(progress=lambda stage, done, total: seen.append((stage, done, total)))
    assert [row.to_json()["computed"] for row in again] == [
        row.to_json()["computed"] for row in ledger.statements
    ]
    assert {stage for stage, _, _ in seen} == {"ledger"}
    assert [done for _, done, _ in seen] == list(range(len(seen)))
    assert seen[-1][1] == seen[-1][2]


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
