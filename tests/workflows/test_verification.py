"""Verify: engines alike, whatever fails is a row, and the exit status says which."""

import os
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import pandas as pd
import pytest

from harness.cases.base import Check
from harness.cases.checks import run_checks
from harness.engines.registry import open_engine
from harness.errors import EngineCrashError, RequestError, Unsupported
from harness.report.content import Section
from harness.results.rows import Tolerance
from harness.store.cache import CachedEngine
from harness.workflows import verification, verify
from harness.workflows.executors import Queue
from tests.workflows import doubles
from tests.workflows.conftest import register

pytestmark = pytest.mark.usefixtures("registered")


def verified(engines="good", level="quick", **more):
    return verify(level, engines=engines, **{"open_engine": open_engine, **more})


def records(run, **where):
    """Return the rows that have these values."""
    rows = run.rows.to_dict("records")
    return [row for row in rows if all(row[name] == value for name, value in where.items())]


def verdicts(run, **where):
    return [row["verdict"] for row in records(run, **where)]


@pytest.fixture(scope="module")
def of_all():
    """A verification of every double at level default."""
    with pytest.MonkeyPatch.context() as patch:
        register(patch)
        return verified("good,off,dying,missing,refusing", "default")


def test_an_engine_at_equal_steps_passes_and_one_that_is_off_by_1e_6_fails(of_all):
    assert set(verdicts(of_all, engine="good")) == {"pass"}
    assert set(verdicts(of_all, engine="off", case="bounce")) == {"fail"}
    assert verdicts(of_all, engine="harness") == ["pass"]  # its own solvers
    assert verdicts(of_all, engine="off", case="engine") == ["finding"]  # a version not tried
    assert of_all.scripts["good/bounce/200 steps"] == "run 200\n"
    assert "; refusing tested nothing; " in of_all.headline


def test_an_engine_that_is_missing_dies_or_refuses_leaves_rows(of_all):
    columns = ["verdict", "failure", "note", "log"]
    found = {
        name: rows[columns].drop_duplicates().values.tolist()
        for name, rows in of_all.rows.groupby("engine")
    }
    assert found["missing"] == [["not tested", "", "missing: no program", ""]]
    assert found["dying"] == [["fail", "engine error", "crashed: signal SIGSEGV", "last words"]]
    assert found["refusing"] == [["not tested", "", "it has no springs", ""]]


@pytest.mark.parametrize(
    ("engines", "more", "status"),
    [
        ("good", {}, 0),
        ("off", {}, 1),
        ("dying", {}, 3),
        ("good,missing", {}, 3),
        ("all", {}, 3),
        ("refusing", {}, 3),  # also where rows of this package's solvers hold
        ("refusing", {"cases": "bounce"}, 3),  # a named case tested nothing
        ("young", {}, 3),  # nor does a remark on its version make it a tested one
        ("good,refusing", {}, 0),
        ("good,refusing", {"strict": True}, 1),
    ],
)
def test_the_status_of_engines(engines, more, status):
    assert verified(engines, **more).status == status


def test_an_engine_of_few_digits_is_named_as_one():
    run = verified("rough")
    assert run.headline == "All verdicts hold; rough is held to its 7 digits"
    assert verdicts(run, engine="rough", case="engine") == ["finding"]


def test_an_engine_without_a_version_is_no_missing_one(monkeypatch):
    identify = doubles.Good.identify
    monkeypatch.setattr(
        doubles.Good, "identify", lambda self: replace(identify(self), engine_version="")
    )
    run = verified("good")
    assert (run.status, run.meta.engines["good"]) == (0, "unknown")
    assert "could not be run" not in run.headline


def test_an_engine_that_is_missing_has_its_reason_under_any_pattern():
    run = verified("missing", only="*restitution")
    assert run.headline == "Nothing was judged; missing could not be run; 1 not tested"
    assert [row["note"] for row in records(run)] == ["missing: no program"]


def test_an_engine_of_all_may_be_missing(monkeypatch):
    two = {name: doubles.ENGINES[name] for name in ("good", "missing")}
    monkeypatch.setattr("harness.engines.registry.ENGINES", two)
    run = verified("all")
    assert run.status == 0
    assert "missing" not in run.meta.engines
    assert verdicts(run, engine="missing")


def test_each_level_has_the_checks_of_the_shorter_ones():
    setups = [set(verified(level=level).rows["setup"]) for level in ("quick", "default", "full")]
    assert setups[0] < setups[1] < setups[2]


def test_a_case_without_checks_of_a_level_is_not_tested_there(monkeypatch):
    checks = doubles.BounceCase.checks

    def longer(case, engine):
        return [check for check in checks(case, engine) if check.level != "quick"]

    monkeypatch.setattr(doubles.BounceCase, "checks", longer)
    (row,) = records(verified("good"), engine="good", case="bounce")
    assert row["note"] == "the case has no checks of this engine at level quick"
    assert verdicts(verified("good", "default"), engine="good") == ["pass"]


def test_engines_are_held_against_one_another():
    assert verdicts(verified("good,lammps"), check="good") == ["pass"]


@pytest.fixture
def other(registered, monkeypatch):
    """Register a second case, which does not qualify."""
    groups = {**registered.GROUPS, "second": {"bounce2": f"{doubles.HERE}:BOUNCE2"}}
    monkeypatch.setattr("harness.cases.registry.GROUPS", groups)


@pytest.mark.usefixtures("other")
def test_an_engine_that_does_not_qualify_is_tested_no_further():
    run = verified("off", cases="bounce2")
    (row,) = records(run, case="bounce2", engine="off")
    assert row["verdict"] == "not tested"
    assert row["note"].startswith("not qualified: bounce (200 steps), off: restitution")
    assert "fail" in verdicts(run, case="bounce")  # the reason is shown
    assert set(verified("good", cases="bounce2").rows["case"]) == {"bounce2"}  # no reason, no rows


def test_an_engine_qualifies_by_all_quick_rows_whatever_a_pattern_shows(monkeypatch):
    stiff = doubles.Off.scene_of
    monkeypatch.setattr(
        doubles.Off,
        "scene_of",
        lambda self, job: stiff(self, job) if job.scene.steps == 200 else job.scene,
    )
    run = verified("off,good", "default", only="bounce/400 steps")
    found = {(row["engine"], row["setup"]): row["verdict"] for row in records(run, case="bounce")}
    assert found["off", "400 steps"] == "pass"
    assert found.pop(("off", "200 steps")) == "fail"  # the reason
    assert run.meta.unqualified == ("off",)
    assert {setup for _, setup in found} == {"400 steps"}


@pytest.mark.usefixtures("other")
def test_rows_that_an_engine_was_not_qualified_for_are_none_that_got_worse(monkeypatch):
    accepted = verified("good", cases="bounce2").rows.replace({"engine": {"good": "off"}})
    monkeypatch.setattr("harness.workflows.verification.accepted_rows", lambda _: accepted)
    run = verified("off", cases="bounce2")
    assert set(run.regressions["case"]) == {"bounce"}  # the reason
    assert "off does not qualify" in run.headline
    assert run.status == 3  # nothing was tested
    assert not verified("refusing,good", cases="bounce2").meta.unqualified


@pytest.mark.usefixtures("other")
@pytest.mark.parametrize(
    ("error", "verdict", "text"),
    [
        (Unsupported("it has no springs"), "not tested", "it has no springs"),
        (EngineCrashError("died"), "fail", "crashed: died"),
        (ZeroDivisionError("planted"), "fail", "checks raised ZeroDivisionError: planted"),
    ],
)
def test_a_qualification_whose_checks_cannot_be_listed_is_a_row(monkeypatch, error, verdict, text):
    checks = doubles.BounceCase.checks

    def raising(case, engine):
        if (case.name, engine.name) == ("bounce", "off"):
            raise error
        return checks(case, engine)

    monkeypatch.setattr(doubles.BounceCase, "checks", raising)
    run = verified("off,good", cases="bounce2")
    (row,) = records(run, case="bounce", engine="off")
    assert row["verdict"] == verdict
    assert text in row["note"]
    assert "pass" in verdicts(run, engine="good")  # the rest goes on


@pytest.mark.usefixtures("other")
def test_engines_that_are_only_compared_qualify_as_well(monkeypatch):
    monkeypatch.setattr(doubles.Second, "checks", lambda *_: [])
    run = verified("good,off", cases="bounce2")
    assert verdicts(run, case="bounce", engine="off") == ["fail"]
    assert "fail" not in verdicts(run, case="bounce2")


class ForCopies(Queue):
    """A queue from which this process takes nothing."""

    here = os.getpid()

    def __iter__(self):
        return iter(()) if os.getpid() == self.here else super().__iter__()


@pytest.fixture
def shared(monkeypatch):
    """Return a verification by two processes, the copy has all cases but the first."""
    monkeypatch.setattr("harness.workflows.verification.CASES_OF_A_COPY", 1)
    monkeypatch.setattr("harness.workflows.verification.Queue", ForCopies)
    names = ("bounce2", "bounce3")
    places = {name: f"{doubles.HERE}:{name.upper()}" for name in names}
    monkeypatch.setattr("harness.cases.registry.GROUPS", {**doubles.GROUPS, "more": places})
    return partial(verified, cases="bounce,wrong,bounce2,bounce3", processes=2)


@pytest.mark.parametrize("engines", ["good,lammps", "off,good", "dying,missing,refusing"])
def test_processes_that_share_the_cases_have_the_rows_of_one(
    shared, engines, monkeypatch, tmp_path
):
    together = shared(engines, "default", output=tmp_path / "run")
    monkeypatch.setattr("harness.workflows.verification.Queue", Queue)
    alone = shared(engines, "default", processes=1)
    pd.testing.assert_frame_equal(together.rows, alone.rows)
    assert together.scripts == alone.scripts
    assert together.headline == alone.headline
    assert together.meta.unqualified == alone.meta.unqualified


def test_runs_and_notes_of_a_copy_are_those_of_the_verification(shared, monkeypatch, tmp_path):
    engines, notes = [], lambda case, bench: f"{case.name} on {bench.name}"

    @contextmanager
    def opened(name):
        with open_engine(name) as engine:
            engines.append(CachedEngine(engine, None))
            yield engines[-1]

    def sections(case, benches):
        return [Section(case.name, benches["good"].notes[case.name])]

    monkeypatch.setattr(doubles.BounceCase, "notes", notes)
    monkeypatch.setattr(doubles.BounceCase, "sections", sections)
    run = shared(open_engine=opened, output=tmp_path / "run")
    assert engines[0].ran == 2  # the same scene in both processes
    page = (tmp_path / "run" / "report.md").read_text()
    assert all(f"{name} on good" in page for name in ("bounce", "bounce2", "bounce3"))
    monkeypatch.setattr(doubles.BounceCase, "notes", lambda *_: 1 / 0)
    run = shared(output=tmp_path / "other")
    assert {row["case"] for row in records(run, failure="harness error", engine="good")} >= {
        "bounce", "bounce2", "bounce3",
    }  # fmt: skip


def test_an_engine_that_cannot_be_copied_is_used_by_one_process_alone(shared, monkeypatch):
    monkeypatch.setattr(doubles.Good, "can_be_copied", False)
    monkeypatch.setattr("harness.workflows.verification.Copy", pytest.fail)
    monkeypatch.setattr("harness.workflows.verification.Queue", Queue)
    assert verdicts(shared(), case="bounce3", engine="good") == ["pass"]


def test_a_pattern_may_choose_rows_that_one_of_the_processes_has(shared):
    assert set(shared(only="bounce2/*").rows["case"]) == {"bounce2"}
    with pytest.raises(RequestError, match="matches no case"):
        shared(only="bounce2/other")


@pytest.mark.parametrize(
    ("only", "setups"),
    [("bounce/400 steps", {"400 steps"}), ("*restitution", {"200 steps", "400 steps"})],
)
def test_a_pattern_chooses_rows(only, setups):
    assert set(verified(level="default", only=only).rows["setup"]) == setups


@pytest.mark.parametrize(
    ("mode", "found"),
    [("none", "raised TypeError"), ("raise", "raised ZeroDivision"), ("type", "returned a int")],
)
def test_a_case_that_raises_or_returns_a_wrong_type_is_one_row(monkeypatch, mode, found):
    monkeypatch.setattr(doubles.Wrong, "mode", mode)
    (row,) = records(verified(cases="wrong"), case="wrong", engine="good")
    assert (row["verdict"], row["failure"]) == ("fail", "harness error")
    for part in ("package 'tests'", "case 'wrong'", f"checks {found}", "must return a list of"):
        assert part in row["note"]


@pytest.mark.parametrize("more", [{"level": "slow"}, {"jobs": doubles.CASE.job(doubles.Bounce())}])
def test_a_check_of_no_level_or_with_a_bare_job_is_one_row(monkeypatch, more):
    def checks(*_):
        return [Check(setup="s", quantity="q", unit="1", measure=lambda _: 1.0, **more)]

    monkeypatch.setattr(doubles.Wrong, "checks", checks)
    (row,) = records(verified(cases="wrong"), case="wrong", engine="good")
    assert "case 'wrong': checks raised" in row["note"]


def test_a_hidden_case_of_another_package_is_a_row_of_all(monkeypatch, tmp_path):
    hidden = {"lib:bounce": "package 'dem-harness' has a case of this name"}
    monkeypatch.setattr("harness.cases.registry.hidden_cases", lambda: hidden)
    run = verified(cases="all", output=tmp_path / "run")
    (row,) = records(run, case="lib:bounce")
    assert (row["verdict"], row["note"]) == ("not tested", hidden["lib:bounce"])
    assert not records(verified(cases="bounce"), case="lib:bounce")


def test_texts_that_an_engine_cannot_give_cost_no_rows():
    texts = dict.fromkeys(("logs", "script_text"), lambda *_: 1 / 0)
    run = verify("quick", open_engine=lambda _: type("Textless", (doubles.Good,), texts)())
    assert verdicts(run, engine="good") == ["pass"]
    assert (run.scripts, run.logs) == ({}, {})


def test_two_checks_of_one_key_are_a_harness_error(monkeypatch):
    check = Check(setup="s", quantity="q", unit="1", measure=lambda _: 1.0, expected=1.0,
                  tolerance=Tolerance(1.0))  # fmt: skip
    monkeypatch.setattr(doubles.BounceCase, "own_checks", lambda _: [check, check])
    (row,) = records(verified(), engine="harness")
    assert (row["failure"], row["note"].partition(":")[0]) == ("harness error", "ValueError")


def test_a_comparison_with_the_key_of_a_check_is_a_failed_row(monkeypatch):
    def again(case, engines):
        return [(engine, next(case.checks(engine))) for engine in engines]

    monkeypatch.setattr(doubles.BounceCase, "comparisons", again)
    one, two = records(verified(), engine="good")
    assert (one["verdict"], two["verdict"]) == ("pass", "fail")
    assert (two["failure"], two["check"]) == ("harness error", "(2)")


@pytest.mark.usefixtures("other")
def test_checks_and_comparisons_that_raise_are_a_row_each(monkeypatch):
    def raising(case, *arguments, **options):
        if case == "bounce2":
            raise RuntimeError("planted")
        return run_checks(case, *arguments, **options)

    monkeypatch.setattr("harness.workflows.session.run_checks", raising)
    rows = verified("good,lammps", cases="bounce2").rows
    assert set(rows["failure"]) == {"harness error"}
    assert sorted(rows["engine"]) == ["good", "harness", "lammps", "lammps"]


@pytest.mark.parametrize(
    ("comparisons", "note"),
    [
        (lambda *_: 1 / 0, "comparisons raised ZeroDivisionError"),
        (lambda *_: [("good",)], "ValueError: not enough values to unpack"),
        (lambda *_: [("good", None)], "AttributeError: 'str' object has no attribute 'name'"),
    ],
)
def test_a_case_whose_comparisons_raise_keeps_its_checks(monkeypatch, comparisons, note):
    monkeypatch.setattr(doubles.BounceCase, "comparisons", comparisons)
    failed, own = records(verified(), engine="harness")
    assert (failed["verdict"], own["verdict"]) == ("fail", "pass")
    assert note in failed["note"]


def test_an_unknown_level_is_refused():
    with pytest.raises(RequestError, match=r"level = 'long'.*quick, default, full"):
        verified(level="long")


def test_what_could_not_be_reported_is_refused_before_anything_runs(monkeypatch, tmp_path):
    def damaged(_):
        raise RequestError("rows.csv: is cut")

    monkeypatch.setattr(doubles.Good, "ran", 0)
    (tmp_path / "mine").touch()
    with pytest.raises(RequestError, match="holds something"):
        verified(output=str(tmp_path))
    monkeypatch.setattr("harness.workflows.verification.accepted_rows", damaged)
    with pytest.raises(RequestError, match="is cut"):
        verified()
    assert doubles.Good.ran == 0


def test_the_expected_time_is_told_before_cases_run(monkeypatch):
    # qualifications begin while checks are listed
    monkeypatch.setattr(verification.Session, "run", pytest.fail)

    def refuse(seconds):
        assert seconds == pytest.approx(200 * 0.05e-6)
        raise RequestError("too long")

    with pytest.raises(RequestError, match="too long"):
        verified(check_duration=refuse)
