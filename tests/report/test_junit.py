import re
from dataclasses import replace
from xml.etree import ElementTree

from harness.comparison.verdicts import Kind
from harness.report.folder import junit


def parsed(found):
    return ElementTree.fromstring(junit(found).encode())


def test_a_suite_for_each_kind_and_a_case_for_each_check(verification):
    root = parsed(verification)
    names = [suite.get("name").removeprefix("dem-harness ") for suite in root]
    kinds = {check.kind for check in verification.checks}
    assert len(kinds) > 2
    assert names == [str(kind) for kind in Kind if kind in kinds]
    cases = root.findall("testsuite/testcase")
    assert len(cases) == len(verification.checks)
    for check, case in zip(verification.checks, cases, strict=True):
        assert case.get("name") == check.name
        assert case.get("classname") == f"dem-harness.{check.kind}"


def test_the_counts_are_those_of_the_cases(verification):
    root = parsed(verification)
    tags = {"failures": "failure", "errors": "error", "skipped": "skipped"}
    for node in (root, *root):
        cases = list(node.iter("testcase"))
        assert int(node.get("tests")) == len(cases)
        for key in tags.keys() & node.keys():
            assert int(node.get(key)) == sum(case.find(tags[key]) is not None for case in cases)
    assert (root.get("failures"), root.get("errors")) == ("1", "1")
    assert [suite.get("skipped") for suite in root] == ["0", "1", "1"]


def test_the_attributes_are_those_that_readers_know(verification):
    known = {
        "testsuites": {"name", "time", "tests", "failures", "errors"},
        "testsuite": {"name", "tests", "failures", "errors", "skipped", "time", "timestamp"},
        "testcase": {"name", "classname", "time"},
        "property": {"name", "value"},
        "failure": {"type", "message"},
        "error": {"type", "message"},
        "skipped": {"message"},
    }
    for node in parsed(verification).iter():
        assert set(node.keys()) <= known.get(node.tag, set())
        if node.get("time"):
            assert re.fullmatch(r"\d+\.\d{3}", node.get("time"))


def test_a_failure_tells_all_its_numbers_and_why(verification):
    failure = parsed(verification).find(".//failure")
    for said in ("value 10.2 deg", "expected 10.3 deg", "difference -0.1", "tolerance 0.0003"):
        assert said in failure.get("message")
    assert "tolerance: a reason" in failure.text


def test_an_engine_that_died_is_an_error_with_its_log(verification):
    error = parsed(verification).find(".//error")
    assert error.get("type") == "out of time"
    assert "Step 1 <&> 2" in error.text


def test_what_nobody_judged_is_skipped_with_the_reason(verification):
    said = [node.get("message") for node in parsed(verification).iter("skipped")]
    assert said[0] == "not tested: not installed"
    assert said[1].startswith("finding, not judged: value 1 deg, expected 2 deg")


def test_names_that_come_twice_are_told_apart_and_control_characters_are_replaced(verification):
    check = replace(verification.checks[0], name="bell \x07 and \x1b[31m")
    cases = parsed(replace(verification, checks=(check, check))).findall(".//testcase")
    assert [case.get("name") for case in cases] == ["bell ? and ?[31m", "bell ? and ?[31m (2)"]
