import json
from dataclasses import replace

import pytest

from harness.cases import registry
from harness.comparison.regression import Baseline
from harness.comparison.verdicts import Kind, Planned, Triage, Verdict
from harness.comparison.verification import Findings, read_published
from harness.engines import registry as engine_registry
from harness.errors import EngineCrashError, RequestError
from harness.report.page import report_markdown
from harness.report.plain import finite
from harness.workflows import sections, verify
from tests.workflows import fakes

pytestmark = pytest.mark.usefixtures("registered")


def verified(cases="line", engine=None, **more):
    return verify("quick", cases=cases, engine=engine or fakes.Toy(), **{"baseline": False, **more})


def rows(found, *words):
    return [check for check in found.checks if all(word in check.name for word in words)]


def row(found, *words):
    (only,) = rows(found, *words)
    return only


def failed(found):
    return [check.name for check in found.checks if check.verdict is Verdict.FAIL]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"level": "huge"}, "level = 'huge' is not known: must be one of quick, default, full"),
        ({"cases": "nobody"}, "'nobody' is not known"),
        ({"engines": "toy,nobody"}, "--engines 'nobody' is not known: must be all, or one or"),
        ({"engines": ""}, "names no engine"),
    ],
)
def test_a_request_that_cannot_be_met_is_refused_before_anything_runs(more, said, monkeypatch):
    monkeypatch.setattr(fakes.Toy, "run", lambda *_: pytest.fail("it ran"))
    asked = {"level": "quick", "engine": fakes.Toy(), "baseline": False, **more}
    with pytest.raises(RequestError, match=said):
        verify(**asked)


def test_without_names_the_main_cases_run():
    found = verify("quick", engine=fakes.Toy(), baseline=False)
    assert found.cases == ("line", "kept", "raising")


def test_a_plan_is_a_row_and_the_rows_are_counted():
    found = verified()
    assert [check.name for check in found.checks] == [
        "line: usual, toy: y",
        "line: rows of level quick, toy",
    ]
    assert {check.verdict for check in found.checks} == {Verdict.PASS}
    assert found.status == 0
    assert found.logs == {"toy/line.in": "multiplied"}


def test_rows_that_are_missing_are_a_failure(monkeypatch):
    monkeypatch.setattr(
        fakes.LineVerification,
        "planned",
        lambda *_: [Planned("line: usual"), Planned("line: other")],
    )
    check = row(verified(), "rows of level quick")
    assert (check.verdict, check.kind) == (Verdict.FAIL, Kind.ANALYTIC)
    assert check.triage == Triage.MISSING
    assert check.note == "missing: line: other"
    assert row(verified(), "line: other").verdict is Verdict.FAIL


def test_an_exception_of_a_case_is_a_failed_row_and_the_others_go_on():
    found = verified("raising,line")
    main, own = rows(found, "raising: ")
    assert main.note == "IndexError: list index out of range"
    assert own.note == "ZeroDivisionError: by nothing"
    assert {main.triage, own.triage} == {Triage.HARNESS}
    assert not main.engine_died
    assert row(found, "line: usual").verdict is Verdict.PASS
    assert found.status == 1
    (section,) = sections(found)
    assert "RuntimeError: no ink" in section.paragraphs[0]


def test_a_dying_engine_is_status_3_and_its_rows_are_not_counted():
    found = verified(engine=fakes.Dying(), cases="gate,line")
    assert row(found, "line: usual").engine_died
    assert not rows(found, "line: rows of level")
    assert found.status == 3
    assert found.engine_errors == ("crashed: signal SIGSEGV",)


def test_without_its_engine_own_solvers_are_checked_all_the_same():
    found = verified("kept", engine=fakes.Missing())
    assert row(found, "engine missing").engine_died
    assert row(found, "kept: by pencil").verdict is Verdict.PASS
    assert found.provenance is None
    assert found.status == 3


def test_a_case_without_a_template_is_not_tested():
    found = verified(engine=fakes.Blind())
    assert row(found, "blind: line").note == "it has no template 'line'"


@pytest.mark.parametrize("cases", ["line", "lines", ["line"], "line,gate"])
def test_a_case_that_was_asked_for_and_tested_nothing_is_status_3(cases):
    found = verified(cases, engine=fakes.Blind())
    assert "line" in found.untested_cases
    assert found.status == 3
    assert found.to_json()["untested_cases"] == list(found.untested_cases)
    assert "Nothing was tested in" in report_markdown(found, [])


def test_a_group_may_have_cases_that_are_not_tested_beside_one_that_is(monkeypatch):
    monkeypatch.setattr(fakes.Raising, "group", "others")
    monkeypatch.setattr(fakes.Gate, "template", replace(fakes.Line.template, name="gate"))
    monkeypatch.setattr(fakes.Blind, "states", classmethod(lambda _, one: one.name == "gate"))
    assert verified("lines", engine=fakes.Blind()).status == 0
    named = verified("line,lines", engine=fakes.Blind())
    assert (named.status, named.untested_cases) == (3, ("line",))


def test_a_case_that_nobody_named_may_be_not_tested():
    for cases in (None, "all"):
        found = verified(cases, engine=fakes.Blind())
        assert not found.untested_cases
        assert found.status != 3


def test_a_case_without_any_row_is_a_row_that_says_so(monkeypatch):
    monkeypatch.setattr(fakes.Line, "plans", lambda *_: [])
    monkeypatch.setattr(registry, "MAIN", ("line",))
    check = row(verified(None), "line")
    assert (check.verdict, check.note) == (Verdict.NOT_TESTED, "it left no row")
    assert verified(None).status == 0
    assert verified(None, strict=True).status == 1
    assert verified("line").status == 3


def test_a_case_that_leaves_no_row_in_an_engine_beside_is_not_tested(monkeypatch):
    whole = fakes.LineVerification.run

    def run(verification, engine, study):
        found = whole(verification, engine, study)
        lost = study.role == "other" and verification.case.name == "line"
        return Findings("line", engine.name) if lost else found

    monkeypatch.setattr(fakes.LineVerification, "run", run)
    found = verified("line", engines="other", strict=True)
    check = row(found, "other: line")
    assert (check.verdict, check.note) == (Verdict.NOT_TESTED, "it left no row")
    assert found.status == 1
    assert not rows(verified("line", engines="toy"), "toy: line")  # its rows are there


def test_an_engine_that_nothing_qualifies_is_not_tested():
    found = verified("gate", engines="blind", strict=True)
    check = row(found, "blind: gate")
    assert (check.verdict, check.note) == (Verdict.NOT_TESTED, "nothing was checked")
    assert found.status == 1


def test_an_engine_beside_tests_a_case_that_the_main_one_cannot_state():
    found = verified("line", engine=fakes.Blind(), engines="other")
    assert not found.untested_cases
    assert found.status == 0


BASELINE = Baseline(
    {
        record.name: record.at("quick", "here")
        for record in (fakes.record(6.0, fakes.Toy().identify()), fakes.record(6.0, None))
    },
    "somewhere",
    digest="ab",
)


def test_records_are_held_against_the_baseline():
    found = verified("kept", baseline=BASELINE)
    assert row(found, "baseline: toy/line: y").verdict is Verdict.PASS
    assert row(found, "baseline: pencil/line: y").verdict is Verdict.PASS
    assert (found.baseline, found.baseline_sha256) == ("somewhere", "ab")
    wrong = verified("kept", fakes.Wrong(), baseline=BASELINE)
    assert row(wrong, "baseline: wrong/line").verdict is Verdict.NOT_TESTED


def leave(monkeypatch, change):
    """Have the case change what it found."""
    kept = fakes.KeptVerification.run

    def verify_less(self, engine, study):
        found = kept(self, engine, study)
        change(found)
        return found

    monkeypatch.setattr(fakes.KeptVerification, "run", verify_less)


@pytest.mark.parametrize(
    ("why", "verdict", "triage"),
    [
        ({}, Verdict.FAIL, Triage.MISSING),
        ({"untested": {"toy/l*": "toy cannot"}}, Verdict.NOT_TESTED, Triage.NOT_TESTED),
        ({"errors": {"toy/line": EngineCrashError("signal")}}, Verdict.FAIL,
         "engine error: crashed"),
    ],
    ids=["missing", "explained", "died"],
)  # fmt: skip
def test_a_record_that_is_not_there_has_the_verdict_of_its_reason(
    monkeypatch, why, verdict, triage
):
    def change(found):
        found.records.clear()
        for name, reasons in why.items():
            getattr(found, name).update(reasons)

    leave(monkeypatch, change)
    check = row(verified("kept", baseline=BASELINE), "baseline: toy/line")
    assert (check.verdict, check.triage) == (verdict, triage)


def test_records_of_cases_that_were_not_asked_for_are_left_out():
    assert not rows(verified("line", baseline=BASELINE), "baseline: toy")


def test_engines_beside_qualify_first_and_what_is_wrong_with_one_is_told_of_it():
    names = "other,wrong,missing,dead,dying,confused,blind"
    found = verified(engines=names)
    summary = {told.engine: told.summary for told in found.engines}
    assert summary == {
        "other": "qualified",
        "wrong": "did not qualify",
        "missing": "missing",
        "dead": "missing",
        "dying": "qualified",
        "confused": "did not qualify",
        "blind": "did not qualify",
    }
    assert row(found, "other: version").verdict is Verdict.FINDING
    assert row(found, "line: usual, other: y").verdict is Verdict.PASS
    assert "did not qualify: usual, wrong: y" in row(found, "wrong: line").note
    assert row(found, "missing: line").note == "no such program; to get it: buy one"
    assert row(found, "dead: identification").triage == "engine error: crashed"
    assert row(found, "line: usual, dying").engine_died
    why = "engine 'confused' of package 'tests': run raised AttributeError: no attribute"
    assert any(why in check.note and check.engine_died for check in found.checks)
    assert "nothing was checked" in row(found, "blind: line").note
    told = {error.partition(":")[0] for error in found.engine_errors}
    assert told == {"missing", "dead", "dying", "confused"}
    assert found.status == 3


class Namesake(fakes.Other):
    factor = 1.1


@pytest.mark.parametrize(
    ("engine", "engines"), [(fakes.Other, ""), (fakes.Toy, "other,")], ids=["main", "beside"]
)
def test_a_second_engine_of_one_name_is_refused_and_no_row_is_taken_for_its_own(engine, engines):
    name = f"{__name__}:Namesake"
    found = verified("kept", engine=engine(), engines=f"{engines}{name}")
    assert {check.verdict for check in rows(found, name)} == {Verdict.NOT_TESTED}
    assert not failed(found)
    (error,) = found.engine_errors
    assert "calls itself 'other', as another engine does" in error
    assert found.status == 3


def test_of_all_engines_those_that_are_missing_are_no_errors():
    assert verified(engines="all").engine_errors == ()


def test_the_main_engine_stands_beside_the_others_without_being_opened_again():
    opened = []

    def open_one(name):
        opened.append(name)
        return engine_registry.open_engine(name)

    found = verified(engines="toy,other", open_one=open_one)
    assert opened == ["other"]
    assert set(found.others) == {"toy", "other"}


def test_what_engines_publish_stands_under_engines():
    record = verified("kept", engines="other").to_json()
    assert record["kept_y_m"] == 6.0
    assert record["engines"]["kept"] == [{"engine": "other"}]
    assert [told["engine"] for told in record["engines"]["declared"]] == ["other"]


def test_engines_are_held_against_one_another_by_the_case():
    found = verified("kept", engines="toy,other")
    assert row(found, "toy and other").verdict is Verdict.PASS
    broken = verified("raising", engines="other")
    assert "KeyError" in row(broken, "raising: engines against").note
    assert "IndexError" in row(broken, "other: raising").note


def test_a_run_is_published_and_read_back():
    found = verified("line,kept,raising", engines="other,missing", baseline=BASELINE)
    record = json.loads(json.dumps(finite(found.to_json()), allow_nan=False))
    read = read_published(record)
    assert [check.name for check in read.checks] == [check.name for check in found.checks]
    assert [c.verdict for c in read.checks] == [c.verdict for c in found.checks]
    assert read.engines.declared == found.engines
    assert read.engine == found.provenance
    assert read.baseline_sha256 == "ab"
    assert read.scripts.keys() == found.scripts.keys()
