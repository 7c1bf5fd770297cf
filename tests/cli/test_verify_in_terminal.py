"""What verify prints and leaves, with a made-up verification in place of a long one."""

import json
import sys
import threading
from dataclasses import replace
from datetime import datetime

import pytest

import harness.workflows
from harness.cli import files, main
from harness.comparison.verdicts import Kind, Tolerance, failed_run, finding, judge, not_tested
from harness.comparison.verification import Findings, Verification
from harness.errors import EngineCrashError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.row import Row

WIDTH = Tolerance("deg", 3e-4, 0.0, "a reason")
HELD = tuple(
    judge(f"a row with a name of some length, k = {n}e6 N/m", Kind.REGRESSION, 1.0, 1.0, WIDTH)
    for n in range(100)
)
FOUND = Verification(
    level="quick",
    cases=(),
    started="2030-01-01T00:00:00+00:00",
    seconds=1.5,
    platform="a test",
    harness_version="0",
    provenance=Provenance("toy", "1 Jan 2030", (), "/bin/toy", "executable"),
    checks=(*HELD, *(finding(f"laws differ {n}", 1.0, 2.0, "deg", "noted") for n in range(9))),
    main={
        "slope": Findings(
            "slope",
            "toy",
            headlines=[Row("critical angle", 10.206981, 0.00042, "deg", 10.2078187, "toy")],
        )
    },
)


def crash():
    error = EngineCrashError("signal SIGSEGV \x1b[31m")
    error.log = "# toy -in slope.in -var angle 10.2\nlast words\n"
    return error


FAILED = (
    judge("angle of the slope", Kind.ANALYTIC, 10.2, 10.3, WIDTH, note="a \x1b[31mnote"),
    failed_run("a run that died", Kind.CROSS_CODE, crash()),
)


@pytest.fixture
def verify(monkeypatch, capsys, tmp_path):
    """Return a function that runs the command on a made-up verification."""
    monkeypatch.chdir(tmp_path)

    def run(found, *words):
        monkeypatch.setenv("COLUMNS", "80")
        monkeypatch.setattr(
            harness.workflows,
            "verify",
            lambda *_, strict=False, **__: replace(found, strict=strict),
            raising=False,
        )
        words = ("--fresh", "--engine", "reference", *words)
        monkeypatch.setattr(sys, "argv", ["dem-harness", "verify", *words])
        with pytest.raises(SystemExit) as left:
            main()
        said = capsys.readouterr()
        return left.value.code or 0, said.out, said.err

    return run


def test_a_run_that_holds_is_told_in_a_screen(verify):
    status, out, _ = verify(FOUND, "--output", "run")
    lines = out.splitlines()
    assert status == 0
    assert lines[-3:] == [
        "critical angle: expected 10.2078 deg; toy 10.2070 +- 0.0004 deg",
        "report: run/report.html",
        "All verdicts hold",
    ]
    assert "regression: 100 of 100 hold" in lines
    assert "finding: 9 reported" in lines
    assert "and 4 more: --verbose prints all" in lines
    assert "a row with a name" not in out


def test_what_failed_comes_first_and_the_end_says_so(verify):
    found = replace(FOUND, checks=(*FOUND.checks, *FAILED), engine_errors=("crashed: SIGSEGV",))
    status, out, err = verify(found, "--output", "run")
    lines = out.splitlines()
    assert status == 3
    assert lines[0] == "fail: angle of the slope (analytic)"
    assert "    10.2 against 10.3 deg, -0.1 apart, 0.0003 allowed" in lines
    assert "    run it again: toy -in slope.in -var angle 10.2" in lines
    assert lines[-1].startswith("FAILED: 1 analytic, 1 cross-code; an engine could not be run")
    assert "\x1b" not in out + err
    assert "dem-harness: crashed: SIGSEGV" in err


def test_strict_counts_what_was_not_tested(verify):
    found = replace(FOUND, checks=(*FOUND.checks, not_tested("away", Kind.ANALYTIC, "not here")))
    assert verify(found, "--output", "one")[0] == 0
    status, out, _ = verify(found, "--output", "two", "--strict")
    assert status == 1
    assert out.splitlines()[-1] == "FAILED: 1 not tested"
    record = json.loads(verify(found, "--output", "three", "--strict", "--json")[1])
    assert (record["status"], record["folder"]) == (1, "three")


def test_the_default_folder_has_the_date_and_is_reserved(verify, tmp_path, monkeypatch):
    class Clock(datetime):
        @classmethod
        def now(cls, tz=None):
            return cls(2030, 1, 2, 3, 4, 5, tzinfo=tz)

    monkeypatch.setattr(files, "datetime", Clock)
    for _ in range(2):
        assert verify(FOUND)[0] == 0
    runs = tmp_path / "reports" / "runs"
    names = ["2030-01-02-030405", "2030-01-02-030405-2"]
    assert sorted(path.name for path in runs.iterdir()) == names
    assert all((runs / name / "report.html").is_file() for name in names)


def test_runs_that_start_together_take_different_folders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    taken, everybody = [], threading.Barrier(8)

    def start():
        everybody.wait()
        with files.output_folder(None) as folder:
            taken.append(folder)
            (folder / "mine").write_text("")

    threads = [threading.Thread(target=start) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(taken)) == 8


def test_a_run_that_comes_to_nothing_leaves_no_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(KeyboardInterrupt), files.output_folder(None):
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "reports").write_text("a file")
    with pytest.raises(RequestError, match=r"--output reports/runs/.*: cannot be made"):
        files.output_folder(None).__enter__()
