"""Verify: engines alike, whatever fails is a row, and the exit status says which."""

import pytest

from harness.cases.base import Check
from harness.cases.checks import run_checks
from harness.engines.registry import open_engine
from harness.errors import RequestError
from harness.results.rows import KEY, Tolerance, Verdict
from harness.workflows import verify
from tests.workflows import doubles

pytestmark = pytest.mark.usefixtures("registered")


def verified(engines="good", level="quick", **more):
    return verify(level, engines=engines, open_engine=open_engine, **more)


def verdicts(run, **where):
    rows = run.rows
    for column, value in where.items():
        rows = rows[rows[column] == value]
    return dict(zip(zip(*(rows[name] for name in KEY), strict=True), rows["verdict"], strict=True))


@pytest.fixture(scope="module")
def of_all():
    """A verification of every double at level default."""
    with pytest.MonkeyPatch.context() as patch:
        from tests.workflows.conftest import register

        register(patch)
        return verified("good,off,dying,missing,refusing", "default")


def test_an_engine_at_equal_steps_passes_and_one_that_is_off_by_1e_6_fails(of_all):
    assert set(verdicts(of_all, engine="good").values()) == {"pass"}
    assert set(verdicts(of_all, engine="off", case="bounce").values()) == {"fail"}
    assert list(verdicts(of_all, engine="harness").values()) == ["pass"]  # its own solvers
    assert of_all.scripts["good/bounce/200 steps"] == "run 200\n"


def test_an_engine_that_is_missing_dies_or_refuses_leaves_rows(of_all):
    rows = of_all.rows.set_index("engine")
    assert rows.loc["missing", ["verdict", "note"]].tolist() == [
        "not tested",
        "missing: no program",
    ]
    dying = rows.loc["dying"]
    assert set(dying["verdict"]) == {"fail"}
    assert set(dying["failure"]) == {"engine error"}
    assert set(dying["log"]) == {"last words"}
    refusing = rows.loc["refusing"]
    assert set(refusing["verdict"]) == {"not tested"}
    assert set(refusing["note"]) == {"it has no springs"}


def test_a_version_that_the_engine_was_not_tried_with_is_a_finding(of_all):
    (row,) = of_all.rows[of_all.rows["case"] == "engine"].to_dict("records")
    assert (row["engine"], row["setup"], row["verdict"]) == ("off", "version", "finding")


@pytest.mark.parametrize(
    ("engines", "more", "status"),
    [
        ("good", {}, 0),
        ("off", {}, 1),
        ("dying", {}, 3),
        ("good,missing", {}, 3),
        ("all", {}, 3),
        ("refusing", {}, 0),
        ("refusing", {"cases": "bounce"}, 3),  # a named case tested nothing
        ("good,refusing", {}, 0),
        ("good,refusing", {"strict": True}, 1),
    ],
)
def test_the_status_of_engines(engines, more, status):
    assert verified(engines, **more).status == status


def test_the_headline_names_an_engine_that_tested_nothing():
    assert "; refusing tested nothing; " in verified("good,refusing").headline
    assert "nothing" not in verified("good").headline


def test_an_engine_of_all_may_be_missing(monkeypatch):
    monkeypatch.setattr(
        "harness.engines.registry.ENGINES",
        {name: doubles.ENGINES[name] for name in ("good", "missing")},
    )
    run = verified("all")
    assert run.status == 0
    assert "missing" not in run.meta.engines
    assert verdicts(run, engine="missing")


def test_each_level_has_the_checks_of_the_shorter_ones():
    setups = [set(verified(level=level).rows["setup"]) for level in ("quick", "default", "full")]
    assert setups[0] < setups[1] < setups[2]


def test_engines_are_held_against_one_another():
    compared = verdicts(verified("good,lammps"), check="good")
    assert list(compared.values()) == ["pass"]


class Other(doubles.BounceCase):
    name, qualifies = "other", False


OTHER = Other()


@pytest.fixture
def other(registered, monkeypatch):
    """Register a second case, which does not qualify."""
    groups = {**registered.GROUPS, "second": {"other": f"{__name__}:OTHER"}}
    monkeypatch.setattr("harness.cases.registry.GROUPS", groups)


@pytest.mark.usefixtures("other")
def test_an_engine_that_does_not_qualify_is_tested_no_further():
    rows = verified("off", cases="other").rows
    (row,) = rows[(rows["case"] == "other") & (rows["engine"] == "off")].to_dict("records")
    assert row["verdict"] == "not tested"
    assert row["note"].startswith("not qualified: bounce (200 steps), off: restitution")
    assert Verdict.FAIL in set(rows[rows["case"] == "bounce"]["verdict"])  # the reason is shown
    assert set(verified("good", cases="other").rows["case"]) == {"other"}  # no reason, no rows


@pytest.mark.parametrize(
    ("only", "setups"),
    [("bounce/400 steps", {"400 steps"}), ("*restitution", {"200 steps", "400 steps"})],
)
def test_a_pattern_chooses_rows(only, setups):
    assert set(verified(level="default", only=only).rows["setup"]) == setups


@pytest.mark.parametrize(
    ("mode", "found"),
    [
        ("none", "raised TypeError"),
        ("raise", "raised ZeroDivisionError"),
        ("type", "returned a int"),
    ],
)
def test_a_case_that_raises_or_returns_a_wrong_type_is_one_row(monkeypatch, mode, found):
    monkeypatch.setattr(doubles.Wrong, "mode", mode)
    rows = verified(cases="wrong").rows
    (row,) = rows[(rows["case"] == "wrong") & (rows["engine"] == "good")].to_dict("records")
    assert (row["verdict"], row["failure"]) == ("fail", "harness error")
    for part in ("package 'tests'", "case 'wrong'", f"checks {found}", "must return a list of"):
        assert part in row["note"]


def test_two_checks_of_one_key_are_a_harness_error(monkeypatch):
    check = Check(setup="s", quantity="q", unit="1", measure=lambda _: 1.0, expected=1.0,
                  tolerance=Tolerance(1.0))  # fmt: skip
    monkeypatch.setattr(doubles.BounceCase, "own_checks", lambda _: [check, check])
    rows = verified().rows
    (row,) = rows[rows["engine"] == "harness"].to_dict("records")
    assert (row["failure"], row["note"].partition(":")[0]) == ("harness error", "ValueError")


def test_a_comparison_with_the_key_of_a_check_is_a_failed_row(monkeypatch):
    def again(case, engines):
        return [(engine, next(case.checks(engine))) for engine in engines]

    monkeypatch.setattr(doubles.BounceCase, "comparisons", again)
    rows = verified().rows
    one, two = rows[rows["engine"] == "good"].to_dict("records")
    assert (one["verdict"], two["verdict"]) == ("pass", "fail")
    assert (two["failure"], two["check"]) == ("harness error", "(2)")


@pytest.mark.usefixtures("other")
def test_checks_and_comparisons_that_raise_are_a_row_each(monkeypatch):
    def raising(case, *arguments, **options):
        if case == "other":
            raise RuntimeError("planted")
        return run_checks(case, *arguments, **options)

    monkeypatch.setattr("harness.workflows.verification.run_checks", raising)
    rows = verified("good,lammps", cases="other").rows
    assert set(rows["failure"]) == {"harness error"}
    assert sorted(rows["engine"]) == ["good", "harness", "lammps", "lammps"]


def test_a_case_whose_comparisons_raise_keeps_its_checks(monkeypatch):
    monkeypatch.setattr(doubles.BounceCase, "comparisons", lambda *_: 1 / 0)
    rows = verified().rows
    own = rows[rows["engine"] == "harness"]
    assert own["verdict"].tolist() == ["fail", "pass"]
    assert "comparisons raised ZeroDivisionError" in own["note"].iloc[0]


def test_an_unknown_level_is_refused():
    with pytest.raises(RequestError, match=r"level = 'long'.*quick, default, full"):
        verified(level="long")


def test_the_expected_time_is_told_before_anything_runs(monkeypatch):
    monkeypatch.setattr(doubles.Good, "ran", 0)

    def refuse(seconds):
        assert seconds == pytest.approx(200 * 0.05e-6)
        raise RequestError("too long")

    with pytest.raises(RequestError, match="too long"):
        verified(check_duration=refuse)
    assert doubles.Good.ran == 0
