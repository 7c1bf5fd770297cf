"""Commands: keys of their JSON, files, exit status, signals, help without heavy imports."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from importlib.metadata import EntryPoint
from pathlib import Path
from unittest.mock import Mock

import pandas as pd
import pytest

from harness.cases.registry import ENTRY_POINT
from harness.cli import COMMANDS
from harness.cli.output import output_folder
from harness.errors import EngineTimeoutError
from tests.workflows import doubles
from tests.workflows.doubles import start

# without loss: no limit of small steps is searched, which takes most of a run
RUN = ("run", "bounce", "--set", "restitution=1")
QUICK = ("verify", "--quick", "--engines", "good")
SWEEP = ("sweep", "bounce", "--over", "restitution=0.2,0.8", "--engines", "good,exact")


# ---- the app


def test_help_lists_every_command_and_imports_nothing_heavy():
    code = (
        "import sys; sys.argv = ['dem-harness', '--help']\n"
        "from harness.cli import main\n"
        "try: main()\nexcept SystemExit: pass\n"
        "print([m for m in ('numpy', 'pandas', 'pydantic', 'matplotlib', 'numba', 'scipy') "
        "if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"
    for name in COMMANDS:
        assert f" {name} " in done.stdout


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_a_command_with_its_status_and_leaves_nothing(tmp_path, number, status):
    words = ("run", "bounce", "--engine", "tests.workflows.doubles:Sleeping")
    process = start(tmp_path, *words, stderr=subprocess.PIPE)
    deadline = time.monotonic() + 300
    while not (tmp_path / "asleep").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    (tmp_path / "asleep").unlink()
    process.send_signal(number)
    said = process.communicate(timeout=300)[1]
    assert process.returncode == status, said
    assert "nothing half-written is left" in said
    assert not list(tmp_path.iterdir())


def test_a_closed_pipe_is_no_error(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    process = start(tmp_path, "cases", stdout=writer, stderr=subprocess.PIPE)
    said = process.communicate(timeout=300)[1]
    os.close(writer)
    assert (process.returncode, said) == (0, "")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_is_no_bug(tmp_path, monkeypatch, unbuffered):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    with Path("/dev/full").open("w") as full:
        process = start(tmp_path, "cases", stdout=full, stderr=subprocess.PIPE)
        said = process.communicate(timeout=300)[1]
    assert (process.returncode, len(said.splitlines())) == (4, 1), said
    assert re.search(r"stdout.*: .*No space left", said)


def test_an_internal_error_is_status_4(harness, monkeypatch):
    monkeypatch.setattr(doubles.BounceCase, "measure", lambda *_: 1 / 0)
    text = harness("run", "bounce", "--engine", "good", status=4).err
    assert "internal error: ZeroDivisionError" in text
    assert "DEM_HARNESS_TRACEBACK=1" in text


def test_a_file_that_may_not_be_read_is_the_user_s_error(harness, monkeypatch):
    error = PermissionError(13, "Permission denied", "mine/run.json")
    monkeypatch.setattr("harness.store.runs.read_run", Mock(side_effect=error))
    said = harness("reproduce", "--check", status=2).err
    assert said == "dem-harness: mine/run.json: Permission denied\n"


def test_ctrl_c_while_the_command_line_is_imported_is_a_line(tmp_path):
    (tmp_path / "cyclopts.py").write_text("raise KeyboardInterrupt")
    done = subprocess.run([sys.executable, "-m", "harness"], capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(tmp_path)}, check=False)  # fmt: skip
    assert (done.returncode, done.stderr) == (130, "dem-harness: interrupted\n")


def test_json_is_all_of_stdout_where_stderr_is_closed():
    shell = f"{sys.executable} -m harness engines --program nix=x --json 2>&-"
    done = subprocess.run(["sh", "-c", shell], capture_output=True, text=True, check=False)
    record = json.loads(done.stdout)
    assert record["status"] == done.returncode == 2
    assert "--program nix" in record["error"]


def test_two_reports_of_one_second_have_two_folders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with output_folder(None) as one, output_folder(None) as two:
        assert one != two
        (one / "report.html").touch()
    assert (one.exists(), two.exists()) == (True, False)


# ---- the tower


def test_heights_may_be_repeated(command):
    words = ("--heights", "1", "--heights", "3", "--stiffness", "1e6", "--speed", "2")
    rows = json.loads(command("impulse", *words, "--law", "overlap", "--json").out)["rows"]
    assert [row["height"] for row in rows] == [1, 3]


# ---- run


def test_the_keys_of_a_run(answer):
    record = answer("run", "bounce", "--engine", "good", "--set", "steps=100")
    assert record["parameters"]["steps"] == 100
    assert record["engine_version"] == "1"
    assert set(record["quantities"]["restitution"]) == {
        "value", "unit", "reference", "reference_kind", "difference", "limit", "step_error",
    }  # fmt: skip
    assert record["qualified"]


def test_the_usual_engine_is_lammps_or_a_solver_where_it_cannot(answer, monkeypatch):
    assert answer(*RUN)["engine"] == "lammps"
    monkeypatch.setattr("harness.workflows.runs.takes_job", lambda *_: False)
    assert answer(*RUN)["engine"] == "exact"


def test_files_of_a_run(harness, tmp_path):
    words = ("--profile", "p.csv", "--script", "in.run", "--film", "f.png", "--frames", "5")
    harness(*RUN, "--engine", "good", *words)
    profile = (tmp_path / "p.csv").read_text().splitlines()
    assert (profile[0], len(profile)) == ("time_s", 202)
    assert (tmp_path / "in.run").read_text() == "run 200\n"
    assert (tmp_path / "f.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("engine", "words"),
    [("off", "its result is not to be used"), ("dying", "SIGSEGV"), ("missing", "no program")],
)
def test_an_engine_that_does_not_qualify_dies_or_is_missing_is_status_3(harness, engine, words):
    assert words in harness(*RUN, "--engine", engine, status=3).err


def test_a_run_that_takes_more_than_ten_minutes_is_refused(harness, monkeypatch):
    slow = doubles.replace(doubles.Good.traits, microseconds_per_step=1e7)
    monkeypatch.setattr(doubles.Good, "traits", slow)
    text = harness(*RUN, "--engine", "good", status=2).err
    assert "33.3 minutes on one core, 10 minutes are the limit" in text
    harness(*RUN, "--engine", "good", "--force")


@pytest.mark.parametrize(
    "words",
    [
        (*RUN, "--engine", "missing", "--script", "in.run", "--film", "f.png"),
        ("sweep", "bounce", "--over", "restitution=0.2,0.8", "--engines", "good,missing"),
        ("sweep", "bounce", "--over", "restitution=0.2,0.8", "--engines", "good,missing",
         "--output", "a/b"),
    ],
)  # fmt: skip
def test_an_engine_that_is_missing_leaves_no_file(harness, tmp_path, words):
    harness(*words, status=3)
    assert not list(tmp_path.iterdir())


# ---- sweep


def test_a_sweep_leaves_table_and_figure_and_goes_on(answer, tmp_path, monkeypatch):
    (tmp_path / "points.csv").write_text("restitution,measured_restitution\n0.5,0.52\n")
    words = (*SWEEP, "--quantity", "restitution", "--reference", "points.csv", "--output", "mine")
    record = answer(*words)
    assert (record["done"], record["failed"], record["engine_runs"]) == (4, 0, 3)  # one qualifies
    frame = pd.read_csv(tmp_path / "mine" / "rows.csv")
    assert frame["restitution"].tolist() == [0.2, 0.8, 0.2, 0.8]
    assert frame["measured_restitution"].to_numpy() == pytest.approx([0.2, 0.8] * 2, abs=5e-3)
    assert "points.csv" in (tmp_path / "mine" / "figure.svg").read_text()
    monkeypatch.setattr(doubles.Good, "ran", 0)
    answer(*words)
    assert doubles.Good.ran == 0


def test_a_failed_run_of_a_sweep_is_status_3_and_a_reason_on_stderr(harness):
    said = harness("sweep", "bounce", "--over", "steps=20,30", "--engines", "good,dying", status=3)
    assert "2 of 4 runs: signal SIGSEGV" in said.err
    assert re.search(r"--output reports/runs/.*-sweep: is written", said.err)
    assert said.out.count("done") == 2


def test_a_run_that_would_overflow_is_a_refused_row(command):
    words = ("sweep", "tower", "--over", "speed=1,2,1e300", "--set", "height=1")
    record = json.loads(command(*words, "--engines", "exact", "--json").out)
    assert [row["status"] for row in record["rows"]] == ["done", "done", "refused"]
    assert record["rows"][2]["reason"] == "speed = 1e+300: must be from 0 to 1e30"


def test_a_file_and_options_on_top(answer, tmp_path):
    text = 'case = "bounce"\nengines = "good"\n[over]\nsteps = [20]\n'
    (tmp_path / "sweep.toml").write_text(text)
    record = answer("sweep", "sweep.toml", "--over", "restitution=0.2,0.4")
    assert [row["restitution"] for row in record["rows"]] == [0.2, 0.4]


# ---- verify, and what is done with its folders


def test_a_verification_is_printed_and_leaves_a_folder(answer, harness, tmp_path):
    record = answer(*QUICK, "--output", "mine", "--png")
    assert (record["status"], record["headline"]) == (0, "All verdicts hold")
    assert {"case", "setup", "quantity", "engine", "check", "verdict"} <= set(record["rows"][0])
    assert {path.name for path in (tmp_path / "mine").iterdir()} == {
        "report.html", "report.md", "rows.csv", "run.json", "junit.xml", "scripts",
    }  # fmt: skip
    text = harness("verify", "--engines", "off", status=1).out
    for part in ("fail: bounce (200 steps), off: restitution", "tolerance 1e-12",
                 "out of tolerance", "Failed: 2 cross-code"):  # fmt: skip
        assert part in text


def test_the_same_verification_is_kept_whole(answer, monkeypatch, tmp_path):
    first = answer(*QUICK, "--output", "one")
    monkeypatch.setattr(doubles.Good, "ran", 0)
    again = answer(*QUICK, "--output", "two")
    assert (first["cached"], again["cached"]) == (False, True)
    texts = [(tmp_path / name / "rows.csv").read_bytes() for name in ("one", "two")]
    assert texts[0] == texts[1]
    assert doubles.Good.ran == 0
    for other in (["--fresh"], ["--strict"], ["--only", "bounce/200*"], ["--cases", "bounce"]):
        assert not answer(*QUICK, *other)["cached"]
    for _ in range(2):  # one in which an engine died is not kept
        assert not answer("verify", "--quick", "--engines", "dying", status=3)["cached"]


def test_a_kept_verification_is_of_these_defects_and_of_cases_of_this_package(
    answer, monkeypatch, tmp_path
):
    def cached(*words):
        return [answer(*QUICK, *words)["cached"] for _ in range(2)]

    assert cached() == [False, True]
    edited = tmp_path / "known-defects.toml"
    edited.write_text("# edited")
    place = {"inputs/known-defects.toml": edited, "reports/accepted": tmp_path / "none"}
    monkeypatch.setattr("harness.cli.runs.committed", place.__getitem__)
    assert cached() == [False, True]
    plugin = EntryPoint("bounce2", f"{doubles.HERE}:BOUNCE2", ENTRY_POINT)  # may change at any time
    monkeypatch.setattr("harness.cases.registry._plugins", lambda: {"bounce2": plugin})
    assert cached("--cases", "bounce2") == [False, False]


def test_what_failed_in_an_engine_is_told(harness, monkeypatch):
    def hangs(_, jobs):
        return [EngineTimeoutError("it did not finish within 1 s") for _ in jobs]

    monkeypatch.setattr(doubles.Dying, "run", hangs)
    told = harness("verify", "--engines", "dying", status=3).err
    assert "bounce (200 steps), dying: restitution: out of time: it did not finish" in told
    told = harness("verify", "--engines", "good,missing", status=3).err
    assert "All verdicts hold; missing could not be run; 1 not tested" in told
    assert "engine 'missing' could not be run: missing: no program" in told


def test_diff_and_accept_of_runs(answer, tmp_path):
    answer(*QUICK, "--output", "one")
    assert answer("diff", "one", "one")["status"] == 0
    accepted = answer("accept", "one", "--folder", "accepted")
    assert len(accepted["files"]) == 2  # of the engine, and of this package's solvers
    assert (tmp_path / "accepted" / "good" / "1" / "rows.csv").is_file()


def test_broken_packages_are_rows_of_all_and_harm_no_other(harness, answer, monkeypatch):
    for room in ("cases", "engines"):
        point = EntryPoint("lost", "nowhere:X", f"dem_harness.{room}")
        monkeypatch.setattr(
            f"harness.{room}.registry._plugins", lambda point=point: {"lost": point}
        )
    monkeypatch.setattr("harness.engines.registry.ENGINES", {"good": doubles.ENGINES["good"]})
    record = answer("verify", "--quick", "--engines", "all", "--cases", "all", status=1)
    lost = [row for row in record["rows"] if "lost" in (row["case"], row["engine"])]
    cells = {("lost", "harness"), ("bounce", "lost"), ("wrong", "lost")}
    assert {(row["case"], row["engine"]) for row in lost} == cells
    assert {row["verdict"] for row in lost} == {"not tested"}
    assert all("lost" in row["note"] and "'nowhere'" in row["note"] for row in lost)
    sweep = ("sweep", "bounce", "--over", "restitution=0.2", "--engines")
    run, verify = (*RUN, "--engine"), ("verify", "--engines")
    for words in (["engines"], ["cases"], ["cases", "bounce"], [*run, "good"], [*sweep, "all"]):
        answer(*words)
    for words in (["cases", "lost"], ["run", "lost"], [*run, "lost"], [*sweep, "lost"],
                  [*verify, "good", "--cases", "lost"], [*verify, "lost"]):  # fmt: skip
        assert "nowhere" in harness(*words, status=3).err


# ---- lists


def test_cases_and_engines_are_objects_of_lists(answer, harness):
    assert [case["name"] for case in answer("cases")["cases"]] == ["bounce", "wrong"]
    (case,) = answer("cases", "bounce")["cases"]
    assert {"presets", "refused_by", "meanings"} <= set(case)
    assert case["quantities"] == {"restitution": "1", "time_s": "s"}
    assert case["derived"] == {"softest": "N/m"}
    stiffness = case["parameters"]["stiffness"]
    assert (stiffness["default"], stiffness["unit"]) == (1e5, "N/m")
    assert stiffness["description"] == "normal stiffness"
    assert {"good", "refusing"} <= set(case["engines"])
    assert (case["solvers"], case["by_default"]) == (["exact"], True)
    engines = {e["engine"]: e for e in answer("engines")["engines"]}
    assert engines["good"]["available"]
    assert not engines["missing"]["available"]
    assert engines["missing"]["reason"] == "missing: no program; to get it: make good"
    assert "nobody 2020" in harness("cases", "bounce").out


def test_the_cache_is_shown_and_cleared(answer):
    answer("run", "bounce", "--engine", "good")
    assert answer("cache")["sorts"]["run"]["entries"] == 1
    assert not answer("cache", "--clear", "--older-than", "1")["sorts"]
    answer("cache", "--clear")
    assert "run" not in answer("cache")["sorts"]
