"""The verdict of a row, the class of each planted change, and which digests are of one input."""
# ruff: noqa: I001

import json
import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.cases.base import Check
from harness.cases.bench import Bench
from harness.cases.checks import run_checks
from harness.results.compare import (
    Change, cells, compare, counts, defect_counts, differ, digest, regressions,
)  # fmt: skip
from harness.results.rows import (
    KEY, Failure, Kind, Row, Tolerance, Verdict, failed, finding, judge, not_tested, rows_of,
    table,
)  # fmt: skip
from harness.store.runs import Meta
from tests.results.rows import NUMBERS, SEVERAL, recorded, row, rows

# ---- verdicts: within, beyond, undecided, and never a pass without a number


FAIL, PASS, UNDECIDED = Verdict.FAIL, Verdict.PASS, Verdict.NOT_TESTED
JUDGED = {  # value, uncertainty, expected, tolerance: verdict
    "at the edge": (1.5, 0.0, 1.0, 0.5, PASS),
    "beyond": (math.nextafter(1.5, 2.0), 0.0, 1.0, 0.5, FAIL),
    "undecided": (1.2, 0.6, 1.0, 0.5, UNDECIDED),
    "beyond by more than it is uncertain by": (2.0, 0.4, 1.0, 0.5, FAIL),
    "NaN": (math.nan, 0.0, 1.0, 0.5, FAIL),
    "NaN expected": (1.0, 0.0, math.nan, 0.5, FAIL),
    "NaN uncertain": (1.0, math.nan, 1.0, 0.5, FAIL),
    "NaN allowed": (1.0, 0.0, 1.0, math.nan, FAIL),
    "infinite": (math.inf, 0.0, 1.0, 0.5, FAIL),
    "infinite and uncertain": (math.inf, math.inf, 1.0, 0.5, FAIL),
    "infinite as expected": (math.inf, 0.0, math.inf, 0.5, FAIL),
    "all allowed": (1.0, 0.0, 1.0, math.inf, FAIL),
}


@pytest.mark.parametrize("name", JUDGED)
def test_verdict(name):
    value, uncertainty, expected, width, verdict = JUDGED[name]
    row = Row(case="a", setup="b", quantity="c", engine="d", value=value, expected=expected,
              uncertainty=uncertainty)  # fmt: skip
    assert judge(row, Tolerance(width)).verdict is verdict


@pytest.mark.parametrize("kind", [Kind.FINDING, Kind.RECORDED])
@pytest.mark.parametrize(("value", "uncertainty"), [(math.inf, 0.0), (1.0, math.nan)])
def test_what_is_not_judged_must_be_a_number_too(kind, value, uncertainty):
    row = Row(case="a", setup="b", quantity="c", engine="d", value=value, uncertainty=uncertainty,
              kind=kind)  # fmt: skip
    assert judge(row, Tolerance(0.0, 1.0)).failure is Failure.NOT_A_NUMBER
    recorded = replace(row, kind=Kind.RECORDED, value=1.0, uncertainty=0.0)
    assert judge(recorded, Tolerance(math.inf)).failure is Failure.HARNESS


@pytest.mark.parametrize("kind", Kind)
def test_a_measurement_that_is_not_a_number_fails_whatever_its_kind(kind):
    check = Check(
        setup="b", quantity="c", unit="1", measure=lambda _: math.nan, expected=1.0,
        tolerance=Tolerance(1.0), kind=kind,
    )  # fmt: skip
    (row,) = run_checks("a", [check], Bench(None))
    assert (row.verdict, row.failure, row.kind) == (FAIL, Failure.NOT_A_NUMBER, kind)


# ---- changes, and what of them fails a run


REQUEST = Meta(level="full", cases=("incline",), engines={"code": "1"})
QUICK = REQUEST.replace(level="quick")
DEFECT = {"verdict": Verdict.KNOWN_DEFECT, "failure": Failure.NONE, "defect": "weak"}
NARROW, WIDE = Tolerance(0.0, 1e-6), Tolerance(0.5)
MOVED = finding(row("difference", 0.3))

PLANTED = {  # the quantity, its row in the second run, the class, whether it fails the run
    "nothing": ("angle", row(), Change.SAME, False),
    "last bit": ("angle", row(value=math.nextafter(10.0, 11.0)), Change.ROUND_OFF, False),
    "tolerance": ("angle", row(value=10.0 + 5e-10), Change.WITHIN, False),
    "verdict lost": ("angle", row(value=10.1), Change.WORSE, True),
    "engine died": ("angle", failed(row(), Failure.ENGINE, "died"), Change.WORSE, True),
    "not tested any more": ("angle", not_tested(row(), "no such contact"), Change.WORSE, False),
    "row missing": ("angle", None, Change.WORSE, True),
    "recorded row missing": ("time", None, Change.WORSE, True),
    "finding missing": ("difference", None, Change.WORSE, True),
    "untested row missing": ("path", None, Change.NOT_COMPARABLE, False),
    "row of a longer level missing": ("steady", None, Change.NOT_COMPARABLE, False),
    "failure moved": ("shock", row("shock", 10.2), Change.MOVED, True),
    "recorded value moved": ("time", recorded("time", 3.1, NARROW), Change.MOVED, True),
    "recorded value moved within a wider tolerance": (
        "time", recorded("time", 3.1, WIDE), Change.MOVED, True),
    "value moved within a wider tolerance": (
        "angle", replace(row(value=10.0), value=10.1, tolerance=0.5), Change.MOVED, True),
    "finding moved": ("difference", replace(MOVED, tolerance=math.nan), Change.MOVED, False),
    "tolerated finding moved": ("difference", replace(MOVED, tolerance=0.01), Change.MOVED, True),
    "another parameter": ("angle", row(inputs="b"), Change.OTHER_INPUT, True),
    "another parameter, and moved": (
        "time", recorded("time", 3.1, WIDE, inputs="b"), Change.OTHER_INPUT, True),
    "no inputs": ("angle", row(inputs=""), Change.SAME, False),
    "mended": ("shock", row("shock"), Change.BETTER, False),
    "becomes a known defect": ("angle", replace(row(value=9.0), **DEFECT), Change.WORSE, False),
    "new row": ("sink", row("sink"), Change.NEW, False),
    "new row not tested": ("sink", not_tested(row("sink"), "why"), Change.NOT_COMPARABLE, False),
    "new row that fails": ("sink", row("sink", 11.0), Change.WORSE, True),
}  # fmt: skip


@pytest.mark.parametrize("name", PLANTED)
def test_class_of_a_planted_change(name):
    quantity, after, change, fails = PLANTED[name]
    changes = compare(rows(), rows((quantity, after)), covers_after=QUICK.covers)
    assert list(changes[changes["quantity"] == quantity]["change"]) == [change]
    assert (len(regressions(changes)) > 0) is fails
    others = changes[~changes["quantity"].isin([quantity, "steady"])]
    assert set(others["change"]) == {Change.SAME}


@pytest.mark.parametrize(
    "other",
    [{"cases": ("tower",)}, {"engines": {"other": "1"}}, {"only": "incline/*/shock"},
     {"left_out": ("other",)}],
)  # fmt: skip
def test_a_row_that_was_not_requested_is_not_comparable(other):
    covers = REQUEST.replace(**other).covers
    accepted = table([row(check="other")])
    missing = compare(accepted, accepted.iloc[:0], covers_after=covers)
    appeared = compare(accepted.iloc[:0], accepted, covers_before=covers)
    assert [*missing["change"], *appeared["change"]] == [Change.NOT_COMPARABLE] * 2


@pytest.mark.parametrize(
    ("check", "change"),
    [("reference", Change.WORSE), ("over Kratos", Change.WORSE), ("over Yade", None),
     ("under the rules of Yade, over Yade", None), ("yade", None)],
)  # fmt: skip
def test_a_row_that_is_missing_is_worse_unless_its_other_engine_was_left_out(check, change):
    covers = REQUEST.replace(left_out=("yade", "reference")).covers
    accepted = table([row(check=check)])
    changes = compare(accepted, accepted.iloc[:0], covers_after=covers)
    assert list(changes["change"]) == [change or Change.NOT_COMPARABLE]


def test_a_setup_that_is_refused_is_one_row_for_all_of_its_quantities():
    accepted = rows()
    refused = table([not_tested(row(), "no such contact")])
    changes = compare(accepted, refused)
    assert regressions(changes).empty
    assert set(changes["change"]) == {Change.WORSE, Change.NOT_COMPARABLE}
    assert list(changes[changes["change"] == Change.WORSE]["quantity"]) == ["angle"]


def test_a_setup_that_is_refused_has_no_variations_either():
    varied = row(check="two ranks")
    accepted, refused = table([row(), varied]), not_tested(row(), "no such contact")
    assert regressions(compare(accepted, table([refused]))).empty
    assert list(regressions(compare(accepted, table([row()])))["check"]) == ["two ranks"]
    other = table([refused, not_tested(varied, "no mpirun")])
    assert regressions(compare(accepted, other)).empty


def test_the_gravest_change_stands_first_and_the_largest_of_a_class():
    after = rows(("shock", row("shock", 10.2)), ("time", recorded("time", 3.1, WIDE)),
                 ("angle", None), ("sink", row("sink")),
                 ("torque", replace(row("torque", 8.0), **DEFECT)))  # fmt: skip
    changes = compare(rows(), after)
    assert list(changes["quantity"][:3]) == ["angle", "torque", "shock"]
    moved = changes.set_index("quantity").loc["shock"]
    assert moved["moved_by"] == pytest.approx(0.1)
    assert moved["in_tolerances"] == pytest.approx(1e8)
    first, second = (table([row(value=v, uncertainty=u)]) for v, u in ((10, 3e-10), (10.1, 4e-10)))
    (size,) = compare(first, second)["in_uncertainties"]
    assert size == pytest.approx(0.1 / 5e-10)


@settings(max_examples=5)  # tables of pandas: 30 ms each
@given(old=NUMBERS, new=NUMBERS, width=st.floats(0.0, 1e3))
def test_the_class_of_two_recorded_values(old, new, width):
    blank = Row(case="c", setup="s", quantity="q", engine="e", tolerance=width,
                verdict=Verdict.RECORDED)  # fmt: skip
    before, after = (table([replace(blank, value=value)]) for value in (old, new))
    (change,) = compare(before, after)["change"]
    if old == new or (math.isnan(old) and math.isnan(new)):
        assert change == Change.SAME
    elif abs(new - old) <= 1e-12 * abs(old):
        assert change == Change.ROUND_OFF
    else:
        assert change == (Change.WITHIN if abs(new - old) <= width else Change.MOVED)


@settings(max_examples=5)
@given(SEVERAL, SEVERAL)
def test_a_table_has_its_rows_and_each_key_of_two_tables_one_change(first, second):
    assert repr(rows_of(table(first))) == repr(first)
    changes = compare(table(first), table(second))
    keys = {tuple(key) for key in changes[list(KEY)].to_numpy().tolist()}
    assert len(changes) == len(keys)
    assert keys == {one.key for one in [*first, *second]}


def test_two_rows_of_one_key_are_refused_and_none_are_a_table():
    with pytest.raises(ValueError, match="two rows of one key"):
        table([row(), row(value=9.0)])
    none = table(())
    assert regressions(compare(none, none)).empty
    assert counts(none).empty


def test_counts_of_verdicts_and_defects():
    late = rows(("angle", None), ("shock", row("shock")))
    numbers = counts(rows())
    assert numbers.loc["cross-code", "fail"] == 2
    assert numbers.loc["recorded", "recorded"] == 1
    assert defect_counts({"2022": rows(), "2023": late.iloc[:2]}).loc["weak"].tolist() == [1, 0]
    both = rows().replace({"defect": {"weak": "weak, soft"}})
    assert defect_counts({"1": both})["1"].to_dict() == {"soft": 1, "weak": 1}


def test_a_cell_has_its_worst_verdict_and_an_untested_variation_does_not_count():
    def cell(*several):
        return cells({"1": table(several)})["1"].tolist()

    variation = not_tested(row(check="two ranks"), "no mpirun")
    assert cell(row(), row("shock", 11.0)) == ["fail"]
    assert cell(row(), variation) == ["pass"]
    assert cell(variation) == ["not tested"]
    assert cell(row(), not_tested(row("path"), "no such contact")) == ["not tested"]
    assert cell(row(), replace(row("b", 9.0), **DEFECT)) == ["known defect"]


# ---- rounding and folders are no input, all else is


SCENE = {"steps": 50, "units": "si", "step": 2.0e-5, "bodies": [{"position": [0.0, -1.3e-6, 0.01]}]}
JOB = ["silo", {"places": "/home/one/beds/3f2a.data", "friction": 0.3}, SCENE]
CHANGES = {
    "a number off by 1e-7": (2.0e-5, 2.0e-5 * (1 + 1e-7)),
    "its sign": (-1.3e-6, 1.3e-6),
    "a zero": (0.0, 1e-12),
    "a whole number": (50, 51),
    "a text": ("si", "lj"),
    "another bed": ("/home/one/beds/3f2a.data", "/home/one/beds/3f2b.data"),
}


def changed(old, new):
    """Return the job with one value in place of another."""
    return json.loads(json.dumps(JOB).replace(json.dumps(old), json.dumps(new), 1))


def are_other(one, two):
    """Return whether two digests are of different inputs."""
    return list(differ([one], [two])) == [True]


@pytest.mark.parametrize("name", CHANGES)
def test_another_input(name):
    assert are_other(digest(JOB), digest(changed(*CHANGES[name])))
    assert are_other(digest([1.0, 2.0]), digest([2.0, 1.0]))


# among them all numbers that lie next to a limit of rounding, as 0.5 or 2.1889752155e-05
@given(st.lists(st.floats(1e-9, 1e9), min_size=1, max_size=20), st.floats(-1e-11, 1e-11))
def test_the_last_digits_of_numbers_are_no_input(numbers, share):
    other = [number * (1.0 + share) for number in numbers]
    assert not are_other(digest([numbers, 2]), digest([other, 2]))


def test_the_folder_of_a_file_named_by_its_content_and_the_sign_of_zero_are_no_input():
    moved = changed("/home/one/beds/3f2a.data", "/tmp/3f2a.data")
    assert digest(moved) == digest(JOB) == digest(changed(0.0, -0.0))
