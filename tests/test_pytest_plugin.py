"""The pytest plugin: a row a test, the fixture, and wrong options as usage errors."""

import json
import signal
import subprocess
from dataclasses import replace
from xml.etree import ElementTree

import pandas  # noqa: F401 - pytester forgets what is first imported in its runs; numpy loads once
import pytest

import harness.cli.output  # noqa: F401 - likewise, a tenth of a second each time
from harness import pytest_plugin
from harness.results.rows import Failure, Row, Tolerance, Verdict, failed, judge, not_tested, table
from harness.store.runs import json_records

pytest_plugins = ["pytester"]
VERIFICATION = pytest_plugin.verification
WIDTH = Tolerance(0.1, reason="a reason")
OWN = """
def test_own(dem_verification):
    rows = dem_verification.set_index("quantity")
    assert set(rows.loc["angle", "expected"].dropna()) == {10.2}
"""


def row(setup, value=10.2, **more):
    blank = Row(case="incline", setup=setup, quantity="angle", engine="lammps", unit="deg")
    return judge(replace(blank, value=value, expected=10.2, **more), WIDTH)


ROWS = (
    row("k = 1.5e6 N/m"),
    row("off", 10.5),
    replace(row("known", 10.5), verdict=Verdict.KNOWN_DEFECT, note="tsuji: a cause"),
    replace(row("gone"), verdict=Verdict.FIXED, note="no longer there"),
    not_tested(row("away"), "it has no springs"),
    failed(row("hung"), Failure.TIMEOUT, "5 s", "the last line of the log"),
)


@pytest.fixture(autouse=True)
def verified(monkeypatch):
    """Stand in for the verification; return the options it was called with."""
    calls = []

    def verification(words):
        calls.append(words)
        rows = json_records(table(ROWS))
        strict = "--strict" in words
        return {"status": 1, "headline": "Failed: 2 cross-code", "strict": strict, "rows": rows}

    monkeypatch.setattr("harness.pytest_plugin.verification", verification)
    return calls


@pytest.fixture
def ran(pytester):
    """Run pytest with the plugin on a file of tests."""

    def run(*words, text="def test_plain(): pass"):
        pytester.makepyfile(text)
        return pytester.runpytest_inprocess("-p", "no:cacheprovider", "-ra", *words)

    return run


def test_each_row_is_a_test_with_its_verdict(ran):
    result = ran("--dem-harness")
    result.assert_outcomes(passed=2, failed=2, xfailed=1, skipped=2)
    result.stdout.fnmatch_lines(
        ["*incline (off), lammps: angle: fail", "10.5, expected 10.2 deg; difference 0.3, tol*"]
    )
    result.stdout.fnmatch_lines(["out of time", "5 s", "the last line of the log"])


def test_without_the_flag_nothing_is_verified(ran, verified):
    ran().assert_outcomes(passed=1)
    assert not verified


def test_the_options_are_those_of_verify(ran, verified):
    ran("--dem-harness", "--dem-harness-options=--quick --strict --cases tower").assert_outcomes(
        passed=2, failed=3, xfailed=1, skipped=1
    )
    assert verified[0][:5] == ["--quick", "--strict", "--cases", "tower", "--output"]


def test_the_fixture_is_the_table_of_the_one_verification(ran, verified):
    ran("--dem-harness", "-k", "test_own", text=OWN).assert_outcomes(passed=1, deselected=6)
    assert len(verified) == 1


def test_rows_are_chosen_by_name_and_mark_and_are_cases_of_junit(ran, pytester):
    ran("--dem-harness", "-k", "gone", "--junitxml=out.xml").assert_outcomes(
        skipped=1, deselected=6
    )
    cases = ElementTree.parse(pytester.path / "out.xml").findall(".//testcase")
    assert [case.get("name") for case in cases] == ["analytic: incline (gone), lammps: angle"]
    ran("--dem-harness", "-m", "not dem_harness").assert_outcomes(passed=1, deselected=6)


def test_an_engine_that_failed_and_a_verification_that_died_are_errors(ran, monkeypatch):
    record = {"status": 3, "headline": "an engine died", "strict": False, "rows": []}
    died = subprocess.CompletedProcess([], -signal.SIGKILL, "")
    monkeypatch.setattr(pytest_plugin.subprocess, "run", lambda *_, **__: died)
    ways = {"an engine died": lambda _: record, "verify ended with -9": VERIFICATION}
    for words, verification in ways.items():
        monkeypatch.setattr("harness.pytest_plugin.verification", verification)
        result = ran("--dem-harness")
        result.assert_outcomes(passed=1, errors=1)
        result.stdout.fnmatch_lines([f"*{words}*"])


def test_a_change_against_the_accepted_run_is_an_error_and_the_rows_stay(ran, monkeypatch):
    record = {"status": 1, "headline": "Against the accepted run: 1 moved", "strict": False,
              "rows": json_records(table([ROWS[0], row("k = 2e6 N/m")])),
              "regressions": [{}]}  # fmt: skip
    monkeypatch.setattr("harness.pytest_plugin.verification", lambda _: record)
    result = ran("--dem-harness", text=OWN)
    result.assert_outcomes(passed=3, errors=1)
    result.stdout.fnmatch_lines(["*Against the accepted run: 1 moved*"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        # engines are looked up first: that of the suite was found
        ("--engines mine:Mine --cases nix", "--cases 'nix' is not known"),
        ("--colour red", "--colour"),
        ("'", "No closing quotation"),
    ],
)
def test_wrong_options_are_usage_errors_and_engines_of_the_suite_are_found(
    ran, pytester, monkeypatch, options, words
):
    folder = pytester.mkdir("engines")
    (folder / "mine.py").write_text("from harness.engines.reference import Reference as Mine")
    pytester.syspathinsert(folder)
    monkeypatch.setattr("harness.pytest_plugin.verification", VERIFICATION)
    result = ran("--dem-harness", f"--dem-harness-options={options}")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert words in result.stderr.str()
    assert json.dumps(options)[1:-1] in result.stderr.str()
