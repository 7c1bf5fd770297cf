"""Failures that a defect of a release explains are told apart; what is gone is told as well."""

from dataclasses import replace

import pytest

from harness.comparison.known_defects import KnownDefect, told_apart
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Cell, Kind, Verdict, failed_run, judge
from harness.errors import EngineCrashError, RequestError
from harness.observables.release import release_of

DEFECT = KnownDefect(
    name="no-friction",
    engine="code",
    cases=["slide"],
    submodels=["old *"],
    systems=["wall"],
    since="28 Mar 2023",
    until="22 Jul 2025",
    cause="the spring is multiplied by the contact radius",
    upstream="issue 1",
)


def check(value, submodel="old spring", system="wall", case="slide", engine="code"):
    row = judge("row", Kind.ANALYTIC, value, 1.0, Tolerance("", 0.1, 0.0, "a tenth, for a test"))
    return replace(row, cell=Cell(case, submodel, system, engine))


def verdict(row, version="2 Aug 2023 - Update 3"):
    (found,) = told_apart([row], [DEFECT], {"code": version})
    return found.verdict


@pytest.mark.parametrize(
    ("version", "numbers"),
    [
        ("22 Jul 2025 - Update 4", (2025, 7, 22, 4)),
        ("2025.7.22.4.0", (2025, 7, 22, 4, 0)),
        ("4Feb2025", (2025, 2, 4)),
        ("10.2.1", (10, 2, 1)),
        ("", ()),
    ],
)
def test_releases_are_in_order_by_their_date_or_number(version, numbers):
    assert release_of(version) == numbers


@pytest.mark.parametrize(
    ("version", "expected"),
    [
        ("23 Jun 2022 - Update 4", Verdict.FAIL),
        ("28 Mar 2023", Verdict.KNOWN_DEFECT),
        ("22 Jul 2025 - Update 4", Verdict.KNOWN_DEFECT),
        ("11 Feb 2026", Verdict.FAIL),
    ],
)
def test_a_failure_is_known_in_the_releases_that_have_the_defect(version, expected):
    assert verdict(check(2.0), version) is expected


@pytest.mark.parametrize(
    "elsewhere",
    [{"submodel": "spring"}, {"system": "sphere"}, {"case": "roll"}, {"engine": "other"}],
)
def test_a_failure_elsewhere_stays_one(elsewhere):
    assert verdict(check(2.0, **elsewhere)) is Verdict.FAIL


def test_a_cell_that_holds_where_it_is_listed_is_fixed_and_never_a_pass():
    assert verdict(check(1.0)) is Verdict.FIXED
    assert verdict(check(1.0), "23 Jun 2022") is Verdict.PASS


def test_a_row_that_holds_beside_one_that_fails_is_not_fixed():
    found = told_apart([check(1.0), check(2.0)], [DEFECT], {"code": "2 Aug 2023"})
    assert [one.verdict for one in found] == [Verdict.PASS, Verdict.KNOWN_DEFECT]


def test_a_defect_of_values_explains_no_invariance_and_one_of_an_invariance_no_value():
    restarted = check(2.0)
    restarted = replace(restarted, cell=replace(restarted.cell, invariance="restarted"))
    forgets = DEFECT.replace(name="forgets", invariances=("restarted",))
    for row, defect, expected in (
        (restarted, DEFECT, Verdict.FAIL),
        (restarted, forgets, Verdict.KNOWN_DEFECT),
        (check(2.0), forgets, Verdict.FAIL),
        (check(1.0), forgets, Verdict.PASS),
    ):
        (found,) = told_apart([row], [defect], {"code": "2 Aug 2023"})
        assert found.verdict is expected


def test_the_note_names_cause_and_upstream_and_an_engine_that_died_of_it_is_no_error():
    row = failed_run("row", Kind.ANALYTIC, EngineCrashError("it died"))
    row = replace(row, cell=Cell("slide", "old spring", "wall", "code"))
    (found,) = told_apart([row], [DEFECT], {"code": "2 Aug 2023"})
    assert found.verdict is Verdict.KNOWN_DEFECT
    assert not found.engine_died
    for words in ("no-friction", "contact radius", "issue 1", "it died"):
        assert words in found.note


@pytest.mark.parametrize("wrong", [{"cases": []}, {"cause": "short"}, {"where": "here"}])
def test_a_defect_that_says_too_little_or_too_much_is_refused(wrong):
    with pytest.raises(RequestError):
        KnownDefect(**{**DEFECT.model_dump(), **wrong})
