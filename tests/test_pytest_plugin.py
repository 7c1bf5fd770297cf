import json
import subprocess
import sys
from dataclasses import replace
from xml.etree import ElementTree

import pandas  # noqa: F401 - pytester forgets what is first imported in its runs, numpy loads once
import pytest

from harness.cli import verify
from harness.comparison.verdicts import (
    Kind,
    Tolerance,
    Verdict,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.errors import EngineTimeoutError
from harness.workflows.verification import chosen_cases

pytest_plugins = ["pytester"]

PLAIN = "def test_plain(): pass"
OWN = """
def test_own(dem_verification):
    rows = dem_verification.set_index(["kind", "name"])
    assert rows.loc[("cross-code", "angle"), "expected"] == 10.2
"""

STAND_IN = """
import json, pathlib
import harness.cli.verify

def verified(choice, engine, folder, progress):
    pathlib.Path(f"run-{choice.level}-{choice.cases}-{engine.engine}").mkdir()
    record = json.loads(pathlib.Path("record.json").read_text())
    (folder / "logs").mkdir(parents=True)
    for row in record["checks"]:
        if row["log"]:
            (folder / "logs" / row["log"]).write_text("the last line of the log")
    return record

harness.cli.verify.verified = verified
"""

FAULTY = """
from tests.engine_doubles import Twin

class Faulty(Twin):
    def __init__(self, factor: float = 1.0):
        super().__init__(lambda told: {**told, "gravity": factor * told["gravity"]})
"""

WIDTH = Tolerance("deg", 0.1, 0.0, "a reason")


def rows():
    """Return a row of each verdict, and one name twice."""
    hung = EngineTimeoutError("5 s").with_log("written by the stand-in")
    known = judge("oblique", Kind.ANALYTIC, 10.5, 10.2, WIDTH, note="known defect tsuji: a cause")
    gone = judge("gone", Kind.ANALYTIC, 10.2, 10.2, WIDTH, note="no longer there: a cause")
    return (
        judge("decimal, k = 1.5e6 N/m", Kind.ANALYTIC, 10.2, 10.2, WIDTH),
        judge("angle", Kind.ANALYTIC, 10.2, 10.2, WIDTH),
        judge("angle", Kind.CROSS_CODE, 10.5, 10.2, WIDTH),
        failed_run("hung", Kind.CROSS_CODE, hung),
        failed_run("hung", Kind.CROSS_CODE, hung),
        not_tested("away", Kind.REGRESSION, "no baseline"),
        finding("laws", 1.0, 2.0, "deg", "as they should"),
        replace(known, verdict=Verdict.KNOWN_DEFECT),
        replace(gone, verdict=Verdict.FIXED),
    )


@pytest.fixture(scope="module", autouse=True)
def _imported_once():
    """Import here what pytester forgets after each run in-process: it loads once only."""
    import numba

    numba.njit(lambda: 0)()  # some of its modules are imported when it compiles
    chosen_cases("all")


def run_pytest(pytester, *words):
    """Run pytest with the flag here, or for xdist in a process of its own."""
    run = pytester.runpytest_subprocess if "-n" in words else pytester.runpytest_inprocess
    return run("-p", "no:cacheprovider", "--dem-harness", *words)


@pytest.fixture
def suite(pytester, monkeypatch):
    """Return a function that runs a user's suite, with a made-up verification."""
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    monkeypatch.setattr(verify, "verified", verify.verified)  # put back what STAND_IN replaces
    pytester.makeconftest(STAND_IN)
    pytester.makeini("[pytest]\nfilterwarnings = error\n")

    def run(*words, text=PLAIN, **more):
        checks = [check.to_json() for check in rows()]
        record = {"checks": checks, "engine_errors": [], "untested_cases": [], **more}
        (pytester.path / "record.json").write_text(json.dumps(record))
        pytester.makepyfile(test_user=text)
        return run_pytest(pytester, *words)

    return run


def runs(pytester):
    return [path.name for path in pytester.path.glob("run-*")]


def test_each_row_is_a_test_with_its_verdict_and_what_failed_has_its_numbers(suite, pytester):
    options = '--dem-harness-options=--full --cases "drop,oblique" --engine reference'
    result = suite("-v", "-rx", "--junitxml=out.xml", "-o", "junit_family=xunit1", options)
    result.assert_outcomes(passed=4, failed=3, skipped=2, xfailed=1)
    result.stdout.fnmatch_lines(
        [
            "dem-harness::analytic: decimal, k = 1.5e6 N/m PASSED*",
            "dem-harness::cross-code: angle FAILED*",
            "dem-harness::cross-code: hung (2) FAILED*",
            "dem-harness::regression: away SKIPPED*no baseline*",
            "dem-harness::finding: laws PASSED*",
            "dem-harness::analytic: gone SKIPPED*fixed: no longer there: a cause*",
            "angle: fail",
            "10.5 against 10.2 deg, 0.3 apart, 0.1 allowed",
            "tolerance: a reason",
            "out of time: 5 s",
            "the last line of the log",
            "XFAIL dem-harness::analytic: oblique - known defect tsuji: a cause",
        ]
    )
    result.stdout.no_fnmatch_line("*pytest_plugin.py*")
    assert runs(pytester) == ["run-full-drop,oblique-reference"]
    tests = ElementTree.parse("out.xml").findall(".//testcase")
    kinds = [node.get("value") for test in tests for node in test.iter("property")]
    assert kinds == [str(row.kind) for row in rows()]


@pytest.mark.parametrize("words", [(), ("-n", "2")])
def test_the_fixture_is_the_table_of_the_one_verification(suite, pytester, words):
    result = suite(*words, text=OWN)
    result.assert_outcomes(passed=4, failed=3, skipped=2, xfailed=1)
    assert len(runs(pytester)) == 1


def test_without_the_flag_the_fixture_alone_runs_it(suite, pytester):
    # the rows are not known before a run
    suite("--collect-only", "-q").stdout.fnmatch_lines(["dem-harness::verification"])
    pytester.runpytest_inprocess("-p", "no:cacheprovider").assert_outcomes(passed=1)
    assert runs(pytester) == []
    pytester.makepyfile(test_user=OWN)
    pytester.runpytest_inprocess("-p", "no:cacheprovider").assert_outcomes(passed=1)
    assert len(runs(pytester)) == 1


def test_rows_are_chosen_by_name_and_mark_and_the_counts_add_up(suite):
    result = suite("-k", "angle")
    result.assert_outcomes(passed=1, failed=1, deselected=8)
    result.stdout.fnmatch_lines(["collected 10 items / 8 deselected / 2 selected"])
    result = suite("-m", "not dem_harness", "--dem-harness-options=--quick")
    result.assert_outcomes(passed=1, deselected=9)


def test_a_named_folder_is_kept_and_not_written_over(suite, pytester):
    suite("--dem-harness-options=--output kept")
    assert (pytester.path / "kept" / "logs").is_dir()
    result = suite("--dem-harness-options=--output kept")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: *--output kept: holds something*"])


def test_in_a_strict_run_what_was_not_tested_fails(suite):
    result = suite("--dem-harness-options=--strict")
    result.assert_outcomes(passed=4, failed=4, skipped=1, xfailed=1)


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ({"engine_errors": ["yade: no such program"]}, "yade: no such program"),
        ({"untested_cases": ["drop"]}, "Nothing was tested in drop"),
    ],
)
def test_an_engine_that_failed_is_an_error_beside_the_rows_and_of_the_fixture(suite, more, text):
    result = suite(text=OWN, **more)
    result.assert_outcomes(passed=3, failed=3, skipped=2, xfailed=1, errors=2)
    result.stdout.fnmatch_lines(["*ERROR at setup of dem-harness: engines*", text])


REFUSED = {
    "--quick=3": "--quick '3': must be a flag",
    "--nope": "Unknown option: --nope*",
    "--quick --json": "--json: goes with the command dem-harness verify only",
    '--lmp "lmp': "No closing quotation",
    "--cases nobody": "--cases 'nobody' is not known: must be all, a group*",
    "--lmp /nowhere": "--lmp '/nowhere': no such executable*",
    "--integrator rk4": "--integrator 'rk4': engine 'lammps' takes the options*",
}


@pytest.mark.parametrize("options", REFUSED)
def test_options_that_are_wrong_are_a_usage_error(pytester, options):
    pytester.makepyfile(PLAIN)
    result = run_pytest(pytester, f"--dem-harness-options={options}")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: --dem-harness-options {options!r}: {REFUSED[options]}"])
    result.stdout.no_fnmatch_line("*passed*")


def test_a_fault_of_an_engine_fails_and_a_program_that_is_none_is_an_error(pytester, monkeypatch):
    monkeypatch.syspath_prepend(pytester.path)
    pytester.makepyfile(faulty=FAULTY, test_plain=PLAIN)
    options = (
        "--quick --engine faulty:Faulty --cases drop --engine-option faulty:Faulty.factor=1.01"
    )
    result = run_pytest(pytester, f"--dem-harness-options={options}", "-k", "analytic")
    result.stdout.fnmatch_lines(["FAILED dem-harness::analytic: twin: free fall over g t^2 / 2*"])
    assert result.parseoutcomes()["failed"] == 2
    result = run_pytest(pytester, "--dem-harness-options=--lmp /bin/true")
    result.assert_outcomes(passed=1, errors=1)
    result.stdout.fnmatch_lines(["dem-harness: --lmp /bin/true is not LAMMPS*"])


def test_loading_imports_nothing_heavy():
    script = (
        "import sys, pytest, harness.pytest_plugin\n"
        "heavy = {'numpy', 'pandas', 'matplotlib', 'numba', 'pydantic', 'lammps', 'cyclopts'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
def test_a_real_verification(pytester):
    pytester.makepyfile(
        "def test_angle(dem_verification):\n"
        "    rows = dem_verification[dem_verification.kind == 'analytic']\n"
        "    assert (rows.difference.abs() <= rows.tolerance).all() and len(rows) > 3\n"
    )
    options = "--dem-harness-options=--quick --cases drop"
    result = pytester.runpytest_subprocess("--dem-harness", options, "-W", "error")
    counts = result.parseoutcomes()
    assert counts["passed"] > 10
    assert "failed" not in counts
