import math

import pytest

from harness.reproduction.claims import (
    ClaimStatus,
    Ledger,
    Source,
    claim,
    compare,
    rounded,
    untestable,
)

SOURCE = Source(
    "eq-6",
    "Background, eq. (6)",
    "sin^2(pi/12 - theta/4)",
    tolerance=0.005,
    unit="deg",
    why="half the last digit printed",
    correction="theta/2",
)


@pytest.mark.parametrize(
    ("printed", "corrected", "status"),
    [
        (10.21, math.nan, ClaimStatus.REPRODUCED),
        (13.87, 10.208, ClaimStatus.CORRECTED),
        (13.87, math.nan, ClaimStatus.NOT_REPRODUCED),
        (13.87, 10.5, ClaimStatus.NOT_REPRODUCED),
        (math.nan, math.nan, ClaimStatus.NOT_REPRODUCED),
    ],
)
def test_the_status_follows_from_the_numbers(printed, corrected, status):
    row = compare(SOURCE, printed=printed, found=10.2078, computed="", corrected=corrected)
    assert row.status is status
    assert bool(row.correction) == (status is not ClaimStatus.REPRODUCED)


@pytest.mark.parametrize(
    ("holds", "corrected", "status"),
    [
        (True, False, ClaimStatus.REPRODUCED),
        (False, True, ClaimStatus.CORRECTED),
        (False, False, ClaimStatus.NOT_REPRODUCED),
    ],
)
def test_a_claim_in_words(holds, corrected, status):
    row = claim(SOURCE, holds=holds, computed="", corrected_holds=corrected)
    assert row.status is status
    assert bool(row.correction) == (not holds)


def test_ledger_as_a_table():
    ledger = Ledger((untestable(SOURCE, "the points are not published"),))
    assert ledger.count(ClaimStatus.UNTESTABLE) == 1
    frame = ledger.to_frame()
    assert list(frame.columns[:4]) == ["key", "where", "says", "status"]
    assert frame["why"][0] == "the points are not published"
    assert ledger["eq-6"].source is SOURCE
    with pytest.raises(KeyError):
        ledger["eq-7"]
    with pytest.raises(ValueError, match="eq-6"):
        Ledger(ledger.statements * 2)


@pytest.mark.parametrize(
    ("corrected", "status"),
    [
        ([1.0, 2.0, 3.0], ClaimStatus.CORRECTED),
        # right where the formula is worst, not all over
        ([1.1, 2.0, 3.0], ClaimStatus.NOT_REPRODUCED),
    ],
)
def test_a_formula_must_hold_at_every_sample(corrected, status):
    printed, found = [1.0, 2.5, 3.1], [1.0, 2.0, 3.0]
    row = compare(SOURCE, printed=printed, found=found, computed="", corrected=corrected)
    assert row.status is status
    assert (row.printed, row.found) == (2.5, 2.0)


@pytest.mark.parametrize(
    ("value", "tolerance", "recorded"),
    [
        (10.205311688960117, 0.01, 10.20531),
        (-4.5e-17, 1e-9, 0.0),
        (1e-20, math.nan, 1e-20),
    ],
)
def test_numbers_are_recorded_without_round_off(value, tolerance, recorded):
    assert str(rounded(value, tolerance)) == str(recorded)
