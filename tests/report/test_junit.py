from dataclasses import replace
from xml.etree import ElementTree

from harness.comparison.verdicts import Kind
from harness.report.junit import junit


def parsed(found):
    return ElementTree.fromstring(junit(found).encode())


def test_a_suite_for_each_kind_and_a_case_for_each_check_with_their_counts(verification):
    root = parsed(verification)
    names = [suite.get("name").removeprefix("dem-harness.") for suite in root]
    kinds = {check.kind for check in verification.checks}
    assert names == [str(kind) for kind in Kind if kind in kinds]
    cases = root.findall("testsuite/testcase")
    for check, case in zip(verification.checks, cases, strict=True):
        assert case.get("name") == check.name
        assert case.get("classname") == f"dem-harness.{check.kind}"
    tags = {"failures": "failure", "errors": "error", "skipped": "skipped"}
    for suite in root:
        assert int(suite.get("tests")) == len(suite)
        for key, tag in tags.items():
            assert int(suite.get(key)) == len(suite.findall(f"testcase/{tag}"))
    assert [suite.get("skipped") for suite in root] == ["0", "1", "1"]


def test_a_failure_has_its_numbers_and_an_engine_that_died_is_an_error_with_its_log(verification):
    root = parsed(verification)
    (failure,), (error,) = root.findall(".//failure"), root.findall(".//error")
    for said in ("value 10.2 deg", "expected 10.3 deg", "difference -0.1", "tolerance 0.0003"):
        assert said in failure.get("message")
    assert "a reason" in failure.text
    assert error.get("type") == "out of time"
    assert "Step 1 <&> 2" in error.text


def test_what_nobody_judged_is_skipped_with_the_reason(verification):
    said = [node.get("message") for node in parsed(verification).iter("skipped")]
    assert "not installed" in said[0]
    assert said[1].startswith("finding: value 1 deg, expected 2 deg")


def test_names_that_come_twice_are_told_apart_and_control_characters_are_replaced(verification):
    check = replace(verification.checks[0], name="bell \x07 and \x1b[31m")
    cases = parsed(replace(verification, checks=(check, check))).findall(".//testcase")
    assert [case.get("name") for case in cases] == ["bell ? and ?[31m", "bell ? and ?[31m (2)"]
