"""Failures that a defect of a release explains are told apart; what is gone is told as well."""

from dataclasses import replace

import pytest

from harness.comparison.known_defects import KnownDefect, Prediction, mark_known_defects
from harness.comparison.verdicts import (
    Cell,
    Kind,
    PredictedSize,
    Tolerance,
    Verdict,
    failed_run,
    judge,
)
from harness.errors import EngineCrashError, RequestError
from harness.observables.provenance import release_of

DEFECT = KnownDefect(
    name="no-friction",
    engine="code",
    cases=["slide"],
    submodels=["old *"],
    systems=["wall"],
    since="28 Mar 2023",
    until="22 Jul 2025",
    cause="the spring is multiplied by the contact radius",
    predicts={"rules": {"factor": 2.0}},
    upstream="issue 1",
)


def twice(prediction, _):
    """Return what the toy case computes: the law's value, 1, times the factor of the defect."""
    value = float(prediction.rules["factor"])
    return PredictedSize(((value - 0.1, value + 0.1),))


def check(value, submodel="old spring", system="wall", case="slide", engine="code"):
    row = judge("row", Kind.ANALYTIC, value, 1.0, Tolerance("", 0.1, 0.0, "a tenth, for a test"))
    return replace(row, cell=Cell(case, submodel, system, engine), predict=twice)


def verdict(row, version="2 Aug 2023 - Update 3"):
    (found,) = mark_known_defects([row], [DEFECT], {"code": version})
    return found.verdict


@pytest.mark.parametrize(
    ("version", "numbers"),
    [
        ("22 Jul 2025 - Update 4", (2025, 7, 22, 4)),
        ("2025.7.22.4.0", (2025, 7, 22, 4, 0)),
        ("10.2.1", (10, 2, 1)),
        ("12 Rev 2024", (12, 2024)),  # no month, and no error
        ("unknown", ()),
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


@pytest.mark.parametrize("version", ["", "unknown"])
@pytest.mark.parametrize("since", ["", "28 Mar 2023"])
def test_a_version_that_cannot_be_read_excuses_nothing_and_has_nothing_fixed(since, version):
    defect = DEFECT.replace(since=since)
    rows = mark_known_defects([check(2.0), check(1.0, system="plane")], [defect], {"code": version})
    assert [row.verdict for row in rows] == [Verdict.FAIL, Verdict.PASS]
    (held,) = mark_known_defects([check(1.0)], [defect], {"code": version})
    assert held.verdict is Verdict.PASS


@pytest.mark.parametrize(
    "elsewhere",
    [{"submodel": "spring"}, {"system": "sphere"}, {"case": "roll"}, {"engine": "other"}],
)
def test_a_failure_elsewhere_stays_one(elsewhere):
    assert verdict(check(2.0, **elsewhere)) is Verdict.FAIL


def test_another_size_than_the_cause_predicts_is_a_failure_that_names_all_three():
    for value in (58.7, 1.5, -2.0, float("nan")):
        (row,) = mark_known_defects([check(value)], [DEFECT], {"code": "2 Aug 2023"})
        assert row.verdict is Verdict.FAIL
        assert row.cell.defect == ""
    (row,) = mark_known_defects([check(58.7)], [DEFECT], {"code": "2 Aug 2023"})
    said = "no-friction predicts 2 +- 0.1, the law asks for 1, the engine left 58.7"
    assert said in row.note


def test_a_row_that_the_defect_does_not_touch_fails_as_a_failure_and_holds_as_a_pass():
    untouched = DEFECT.replace(predicts=Prediction(rules={"factor": 1.0}))
    for value, expected in ((2.0, Verdict.FAIL), (1.0, Verdict.PASS)):
        (row,) = mark_known_defects([check(value)], [untouched], {"code": "2 Aug 2023"})
        assert row.verdict is expected


def test_a_row_of_which_no_size_can_be_computed_is_not_excused():
    def cannot(*_):
        raise RequestError("the contact does not end")

    for predict in (None, cannot):
        row = replace(check(2.0), predict=predict)
        (row,) = mark_known_defects([row], [DEFECT], {"code": "2 Aug 2023"})
        assert row.verdict is Verdict.FAIL
        assert "cannot be computed" in row.note


def test_two_defects_of_a_cell_predict_one_size_together():
    def product(prediction, _):
        value = float(prediction.rules["factor"]) * float(prediction.law.get("k", 1.0))
        return PredictedSize(((value - 0.1, value + 0.1),))

    other = DEFECT.replace(name="stiff", predicts=Prediction(law={"k": 3.0}))
    for value, expected in ((6.0, Verdict.KNOWN_DEFECT), (2.0, Verdict.FAIL), (3.0, Verdict.FAIL)):
        row = replace(check(value), predict=product)
        (row,) = mark_known_defects([row], [DEFECT, other], {"code": "2 Aug 2023"})
        assert row.verdict is expected
        assert "no-friction and stiff predict" in row.note


def test_a_defect_of_the_values_lies_beneath_one_of_an_invariance():
    seen = []

    def difference(prediction, beneath):
        seen.append((prediction, beneath))
        return PredictedSize(((1.9, 2.1),))

    row = replace(check(2.0), predict=difference)
    row = replace(row, cell=replace(row.cell, invariance="restarted"))
    forgets = DEFECT.replace(
        name="forgets", invariances=("restarted",), predicts=Prediction(scheme={"restart": "lost"})
    )
    for known, under in (([forgets], None), ([DEFECT, forgets], DEFECT.predicts)):
        (found,) = mark_known_defects([row], known, {"code": "2 Aug 2023"})
        assert (found.verdict, found.cell.defect) == (Verdict.KNOWN_DEFECT, "forgets")
        assert seen.pop() == (forgets.predicts, under)


def test_a_bound_includes_what_is_below_it_alone():
    assert PredictedSize(()).includes(float("nan"))
    assert not PredictedSize(()).includes(1.0)
    size = PredictedSize(((-0.5, 0.5),), "a first-order error")
    assert size.includes(0.5)
    assert not size.includes(0.6)
    assert not size.includes(float("nan"))
    assert str(size) == "at most 0.5 (a first-order error)"


def test_a_cell_that_holds_where_it_is_listed_is_fixed_and_never_a_pass():
    assert verdict(check(1.0)) is Verdict.FIXED
    assert verdict(check(1.0), "23 Jun 2022") is Verdict.PASS


def test_a_row_that_holds_beside_one_that_fails_is_not_fixed():
    found = mark_known_defects([check(1.0), check(2.0)], [DEFECT], {"code": "2 Aug 2023"})
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
        (found,) = mark_known_defects([row], [defect], {"code": "2 Aug 2023"})
        assert found.verdict is expected


def test_the_note_names_cause_and_upstream_and_an_engine_that_died_of_it_is_no_error():
    row = failed_run("row", Kind.ANALYTIC, EngineCrashError("it died"))
    row = replace(row, cell=Cell("slide", "old spring", "wall", "code"))
    (other,) = mark_known_defects([row], [DEFECT], {"code": "2 Aug 2023"})
    assert (other.verdict, other.engine_died) == (Verdict.FAIL, True)
    elsewhere = DEFECT.replace(predicts=Prediction(error="it hung"))
    (other,) = mark_known_defects([row], [elsewhere], {"code": "2 Aug 2023"})
    assert (other.verdict, other.engine_died) == (Verdict.FAIL, True)
    dies = DEFECT.replace(name="dies", predicts=Prediction(error="it died"))
    (named,) = mark_known_defects([row], [DEFECT, dies], {"code": "2 Aug 2023"})
    assert (named.verdict, named.cell.defect) == (Verdict.KNOWN_DEFECT, "dies")
    assert (
        mark_known_defects([check(1.0)], [dies], {"code": "2 Aug 2023"})[0].verdict is Verdict.FIXED
    )
    assert (
        mark_known_defects([check(2.0)], [dies], {"code": "2 Aug 2023"})[0].verdict is Verdict.FAIL
    )
    assert not named.engine_died
    for words in ("dies", "contact radius", "issue 1", "it died"):
        assert words in named.note


@pytest.mark.parametrize(
    "wrong",
    [
        {"cases": []},
        {"cause": "short"},
        {"where": "here"},
        {"predicts": {}},
        {"kind": "quirk"},
    ],
)
def test_a_defect_that_says_too_little_or_too_much_is_refused(wrong):
    with pytest.raises(RequestError):
        KnownDefect(**{**DEFECT.model_dump(), **wrong})


def undecided(value):
    row = check(value)
    return replace(row, verdict=Verdict.NOT_TESTED, note="undecided")


def test_what_is_undecided_against_the_law_may_be_decided_against_the_prediction():
    assert verdict(undecided(2.0)) is Verdict.KNOWN_DEFECT
    assert verdict(undecided(1.5)) is Verdict.NOT_TESTED
    # a prediction that has room for the law, too, decides nothing
    wide = replace(undecided(2.0), predict=lambda *_: PredictedSize(((0.5, 2.5),)))
    assert verdict(wide) is Verdict.NOT_TESTED
