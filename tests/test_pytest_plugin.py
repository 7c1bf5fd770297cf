import pickle
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import entry_points
from xml.etree import ElementTree

import pytest

import harness.pytest_plugin
from harness.comparison.verdicts import (
    Kind,
    Tolerance,
    Verdict,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.comparison.verification import Findings, Verification
from harness.errors import EngineTimeoutError
from harness.observables.row import Row
from harness.workflows.verification import chosen_cases

pytest_plugins = ["pytester"]

INSTALLED = any(e.value == "harness.pytest_plugin" for e in entry_points(group="pytest11"))
HERE = {} if INSTALLED else {"plugins": [harness.pytest_plugin]}
ELSEWHERE = () if INSTALLED else ("-p", "harness.pytest_plugin")

OWN = """
def test_own(dem_verification):
    (told,) = dem_verification.headlines
    assert told.expected == 10.2
"""

STAND_IN = """
import pathlib
import pickle
import harness.pytest_plugin

def verify(config):
    with pathlib.Path("runs").open("a") as runs:
        runs.write("1")
    return pickle.loads(pathlib.Path("made-up.pickle").read_bytes())

harness.pytest_plugin._run = verify
"""


def made_up():
    """Return a verification with each verdict, and one name twice."""
    width = Tolerance("deg", 0.1, 0.0, "a reason")
    hung = EngineTimeoutError("5 s")
    hung.log = "the last line of the log"
    return Verification(
        level="quick",
        cases=("slope",),
        started="2030-01-01",
        seconds=1.0,
        platform="here",
        harness_version="0",
        provenance=None,
        checks=(
            judge("angle", Kind.ANALYTIC, 10.2, 10.2, width),
            judge("decimal, k = 1.5e6 N/m", Kind.ANALYTIC, 10.2, 10.2, width),
            judge("angle", Kind.CROSS_CODE, 10.5, 10.2, width),
            failed_run("hung", Kind.CROSS_CODE, hung),
            failed_run("hung", Kind.CROSS_CODE, hung),
            not_tested("away", Kind.REGRESSION, "no baseline"),
            finding("laws", 1.0, 2.0, "deg", "as they should"),
        ),
        solvers={"slope": Findings("slope", headlines=[Row("angle", 10.2, 0.1, "deg", 10.2, "x")])},
    )


FACTOR = "faulty:Faulty.factor=1.01"

FAULTY = """
from tests.engine_doubles import Twin

class Faulty(Twin):
    def __init__(self, factor: float = 1.0):
        super().__init__(lambda told: {**told, "gravity": factor * told["gravity"]})
"""


@pytest.fixture(scope="module", autouse=True)
def _imported_once():
    """Import here what pytester forgets after each run in-process: it loads once only."""
    import numba

    numba.njit(lambda: 0)()  # some of its modules are imported when it compiles
    chosen_cases("all")


def run_pytest(pytester, *arguments):
    """Run pytest here, or for xdist in a process of its own."""
    if "-n" in arguments:
        return pytester.runpytest_subprocess(*ELSEWHERE, *arguments)
    return pytester.runpytest_inprocess(*arguments, **HERE)


@pytest.fixture
def suite(pytester, monkeypatch):
    """Return a function that runs a user's suite, with a made-up verification that is counted."""
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    # put back after the test: what the suite's conftest replaces is this module's too
    monkeypatch.setattr(harness.pytest_plugin, "_run", harness.pytest_plugin._run)
    (pytester.path / "made-up.pickle").write_bytes(pickle.dumps(made_up()))
    pytester.makeconftest(STAND_IN)
    pytester.makeini("[pytest]\nfilterwarnings = error\n")

    def run(*arguments, **files):
        pytester.makepyfile(**(files or {"test_plain": "def test_plain(): pass"}))
        return run_pytest(pytester, "-p", "no:cacheprovider", *arguments)

    return run


def runs(pytester):
    path = pytester.path / "runs"
    return len(path.read_text()) if path.exists() else 0


def test_each_check_is_an_item_with_its_verdict(suite, pytester):
    result = suite("--dem-harness", "-v")
    result.assert_outcomes(passed=4, failed=3, skipped=1)
    result.stdout.fnmatch_lines(
        [
            "dem-harness::analytic: angle PASSED*",
            "dem-harness::cross-code: angle FAILED*",
            "dem-harness::cross-code: hung FAILED*",
            "dem-harness::cross-code: hung (2) FAILED*",
            "dem-harness::regression: away SKIPPED*no baseline*",
            "dem-harness::finding: laws PASSED*",
        ]
    )
    assert runs(pytester) == 1


def test_a_failure_reads_in_words_and_numbers_without_a_traceback(suite):
    result = suite("--dem-harness")
    result.stdout.fnmatch_lines(
        [
            "angle: 0.3 apart, 0.1 allowed",
            "  value       10.5 deg",
            "  expected    10.2 deg",
            "  difference  0.3",
            "  tolerance   0.1  (a reason)",
            "hung: out of time: 5 s",
            "the last line of the log",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")
    result.stdout.no_fnmatch_line("*pytest_plugin.py*")


def test_without_the_option_nothing_runs(suite, pytester):
    suite().assert_outcomes(passed=1)
    assert runs(pytester) == 0


def test_the_fixture_needs_no_option_and_shares_the_run(suite, pytester):
    suite(test_own=OWN).assert_outcomes(passed=1)
    assert runs(pytester) == 1
    suite("--dem-harness", test_own=OWN).assert_outcomes(passed=4, failed=3, skipped=1)
    assert runs(pytester) == 2


def test_under_xdist_one_worker_runs_it(suite, pytester):
    result = suite("--dem-harness", "-n", "2", test_own=OWN)
    result.assert_outcomes(passed=4, failed=3, skipped=1)
    assert runs(pytester) == 1


def test_checks_can_be_chosen_by_name_and_mark(suite):
    suite("--dem-harness", "-k", "angle").assert_outcomes(passed=1, failed=1, deselected=6)
    suite("--dem-harness", "-m", "not dem_harness").assert_outcomes(passed=1, deselected=7)


def test_a_known_defect_is_a_failure_that_is_expected(suite, pytester):
    wide = Tolerance("", 0.1, 0.0, "a reason")
    told = judge("told", Kind.ANALYTIC, 2.0, 1.0, wide, note="known defect tsuji: a cause")
    gone = judge("gone", Kind.ANALYTIC, 1.0, 1.0, wide, note="no longer there: a cause")
    checks = (replace(told, verdict=Verdict.KNOWN_DEFECT), replace(gone, verdict=Verdict.FIXED))
    found = pickle.dumps(replace(made_up(), checks=checks))
    (pytester.path / "made-up.pickle").write_bytes(found)
    result = suite("--dem-harness", "-rxs", "--junitxml=out.xml")
    result.assert_outcomes(passed=1, xfailed=1, skipped=1)
    assert result.ret == 0
    result.stdout.fnmatch_lines(
        [
            "XFAIL dem-harness::analytic: told - known defect tsuji: a cause",
            "SKIPPED * fixed: no longer there: a cause",
        ]
    )
    kinds = [node.get("type") for node in ElementTree.parse("out.xml").iter("skipped")]
    assert sorted(kinds) == ["pytest.skip", "pytest.xfail"]


@pytest.mark.parametrize("how", ["words", "ini"])
def test_engine_case_and_an_option_of_its_class_are_chosen_and_its_fault_fails(
    pytester, monkeypatch, how
):
    asked = {"engine": "faulty:Faulty", "cases": "drop,head-on", "engine_option": FACTOR}
    monkeypatch.syspath_prepend(pytester.path)
    pytester.makepyfile(faulty=FAULTY, test_plain="def test_plain(): pass")
    if how == "ini":
        lines = "".join(f"dem_harness_{name} = {text}\n" for name, text in asked.items())
        pytester.makeini("[pytest]\n" + lines)
        words = []
    else:
        words = [f"--dem-harness-{n.replace('_', '-')}={text}" for n, text in asked.items()]
    result = run_pytest(pytester, "--dem-harness", *words, "-v", "-k", "analytic or cross")
    result.stdout.fnmatch_lines(
        [
            "dem-harness::cross-code: twin: head-on SKIPPED*not tested*",
            "dem-harness::analytic: twin: static contact* FAILED*",
            "dem-harness::analytic: twin: free fall over g t^2 / 2 FAILED*",
        ]
    )
    result.assert_outcomes(passed=10, failed=2, skipped=1, deselected=12)
    assert result.ret == 1


def test_the_counts_of_a_choice_add_up(suite):
    result = suite("--dem-harness", "-k", "angle")
    result.stdout.fnmatch_lines(["collected 8 items / 6 deselected / 2 selected"])
    listed = suite("--dem-harness", "--collect-only", "-k", "plain")
    listed.stdout.fnmatch_lines(["*1/2 tests collected (1 deselected)*"])


def test_a_name_with_a_dot_stays_as_it_is(suite):
    result = suite("--dem-harness", "-v", "-k", "decimal")
    result.stdout.fnmatch_lines(["dem-harness::analytic: decimal, k = 1.5e6 N/m PASSED*"])
    result.stdout.no_fnmatch_line("*1::5e6*")


def test_a_list_of_what_is_collected_runs_nothing(suite, pytester):
    suite("--dem-harness", "--collect-only", "-q").stdout.fnmatch_lines(["dem-harness::verif*"])
    assert runs(pytester) == 0


def test_junit_has_the_kind(suite, pytester):
    suite("--dem-harness", "--junitxml=out.xml", "-o", "junit_family=xunit1")
    cases = ElementTree.parse(pytester.path / "out.xml").findall(".//testcase")
    kinds = {node.get("value") for case in cases for node in case.iter("property")}
    assert kinds == {"analytic", "cross-code", "regression", "finding"}


@pytest.mark.parametrize(
    "how",
    [
        ("--dem-harness-lmp", "/nowhere"),
        ("-o", "dem_harness_lmp=/nowhere"),
        ("-o", "dem_harness_lmp=/nowhere", "-n", "2"),
    ],
)
def test_options_that_are_wrong_fail_in_one_line(pytester, how):
    pytester.makepyfile(OWN)
    result = run_pytest(pytester, "--dem-harness", *how)
    result.assert_outcomes(failed=1, errors=1)
    result.stdout.fnmatch_lines(["dem-harness: --lmp '/nowhere': no such executable*"])
    result.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("--dem-harness-engine=nobody", "--engine 'nobody' is not known: must be one of *"),
        ("--dem-harness-program=yade=/bin/sh", "--program yade=/bin/sh: goes with * yade only"),
        ("--dem-harness-program=yade", "--program 'yade': must be NAME=VALUE"),
        ("--dem-harness-engine-option=x=1", "--engine-option 'x=1': must be NAME.KEY=VALUE"),
        ("--dem-harness-engines=nobody", "--engines 'nobody' is not known: must be all, or *"),
        ("--dem-harness-mpirun= ", "--mpirun ' ': must be a command, as in 'mpirun -np 4'"),
        ("--dem-harness-integrator=rk4", "--integrator 'rk4': engine 'lammps' takes the options*"),
    ],
)
def test_what_an_engine_is_not_is_refused_in_one_line(pytester, word, said):
    result = run_pytest(pytester, "--dem-harness", word)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["dem-harness: " + said])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_an_unknown_level_is_refused(pytester):
    result = run_pytest(pytester, "--dem-harness", "--dem-harness-level", "huge")
    result.stdout.fnmatch_lines(["dem-harness: level = 'huge' is not known*quick, default, full"])


def test_loading_imports_nothing_heavy():
    script = (
        "import sys, pytest, harness.pytest_plugin\n"
        "heavy = {'numpy', 'scipy', 'pandas', 'matplotlib', 'numba', 'pydantic', 'lammps'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.slow
@pytest.mark.live
def test_a_real_verification(pytester, lammps_here):  # noqa: ARG001
    pytester.makepyfile(
        "def test_angle(dem_verification):\n"
        "    found = dem_verification.headlines[0]\n"
        "    assert abs(found.value - 10.2078187) < found.uncertainty\n"
    )
    result = pytester.runpytest_subprocess(*ELSEWHERE, "--dem-harness", "-W", "error")
    counts = result.parseoutcomes()
    assert counts["passed"] > 50
    assert "failed" not in counts
