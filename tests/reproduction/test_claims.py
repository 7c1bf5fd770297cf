import math
from dataclasses import replace

import pytest

from harness.reproduction.claims import (
    ClaimStatus,
    Ledger,
    Source,
    bounded,
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
    row = compare(
        SOURCE,
        printed=printed,
        found=10.2078,
        computed="",
        corrected=corrected,
    )
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


def test_a_key_stands_once():
    row = untestable(SOURCE, "why")
    with pytest.raises(ValueError, match="eq-6"):
        Ledger((row, row))


@pytest.mark.parametrize(
    ("corrected", "status"),
    [
        ([1.0, 2.0, 3.0], ClaimStatus.CORRECTED),
        (
            [1.1, 2.0, 3.0],
            ClaimStatus.NOT_REPRODUCED,
        ),  # right where the formula is worst, not all over
        (None, ClaimStatus.NOT_REPRODUCED),
    ],
)
def test_a_formula_must_hold_at_every_sample(corrected, status):
    row = compare(
        SOURCE,
        printed=[1.0, 2.5, 3.1],
        found=[1.0, 2.0, 3.0],
        computed="",
        corrected=corrected,
    )
    assert row.status is status
    assert (row.printed, row.found) == (2.5, 2.0)


def test_a_sample_without_a_number_is_the_worst():
    row = compare(SOURCE, printed=[1.0, math.nan], found=[1.0, 2.0], computed="")
    assert row.status is ClaimStatus.NOT_REPRODUCED
    assert row.found == 2.0


@pytest.mark.parametrize("noise", [0.0, 4e-16, -9e-16])
def test_samples_that_agree_are_shown_by_the_middle_one_and_a_bound(noise):
    exact = replace(SOURCE, tolerance=1e-12, unit="m")
    found = [1.0 + noise, 2.0, 3.0 - noise]
    row = compare(exact, printed=[1.0, 2.0 - noise, 3.0], found=found, computed="tried").to_json()
    assert row["computed"] == "tried; off by less than 1e-12 m"
    assert (row["printed"], row["found"]) == (2.0, 2.0)


def test_of_samples_that_are_off_alike_round_off_does_not_choose():
    rows = [
        compare(SOURCE, printed=[2.0, 3.0 + e, 4.0], found=[1.0, 2.0, 3.0], computed="")
        for e in (-4e-16, 0.0, 4e-16)
    ]
    assert {row.printed for row in rows} == {2.0}


@pytest.mark.parametrize(
    ("value", "tolerance", "recorded"),
    [
        (10.205311688960117, 0.01, 10.20531),
        (-4.5e-17, 1e-9, 0.0),
        (1e-20, math.nan, 1e-20),
        (-0.0, math.nan, 0.0),
        (0.05000000000000015, 1e-12, 0.05),
    ],
)
def test_numbers_are_recorded_without_round_off(value, tolerance, recorded):
    assert str(rounded(value, tolerance)) == str(recorded)


@pytest.mark.parametrize(
    ("value", "said"), [(3e-16, "less than 1e-12"), (-2e-17, "less than 1e-12"), (2.4e-5, "2e-05")]
)
def test_a_difference_of_round_off_is_told_as_a_bound(value, said):
    assert bounded(value) == said
