"""``sweep`` from the command line: files, folders, kills."""

import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

EXAMPLE = Path(__file__).parents[2] / "inputs" / "sweeps" / "step-and-stiffness.toml"

ENGINE = '''
import os, time
from harness.engines.reference import Reference

class Counting(Reference):
    """The reference DEM, slowed down; it writes down which runs it begins."""
    name = "counting"

    def run(self, jobs):
        for job in [job for job in jobs if "angle" in job.values]:
            with open(os.environ["BEGUN"], "a") as file:
                file.write(f"{job.values['angle']!r}\\n")
            time.sleep(0.02)
        return super().run(jobs)
'''


@pytest.mark.live
def test_the_committed_example_runs(answer, tmp_path, lammps_here):  # noqa: ARG001
    found = answer("sweep", str(EXAMPLE), "--output", "mine")
    assert (found["failed"], found["not_tested"]) == (0, 0)
    table = pd.read_csv(tmp_path / "mine" / "rows.csv")
    assert len(table) == len(found["rows"]) == found["done"]
    assert {"engine", "engine_version", *found["over"]} <= set(table)
    names = {path.name for path in (tmp_path / "mine").iterdir()}
    assert names >= {"sweep.json", "rows.csv", "figure.svg", "figure.png"}
    again = answer("sweep", str(EXAMPLE), "--output", "mine")
    assert again["engine_runs"] == 0
    assert again["rows"] == found["rows"]


@pytest.mark.live
def test_measured_points_stand_in_the_figure(answer, tmp_path, lammps_here):  # noqa: ARG001
    (tmp_path / "mine.csv").write_text("angle_deg,rim_speed_ratio\n20,0.31\n")
    words = ("oblique", "--over", "angle=20,40", "--set", "preset=kharaz")
    more = ("--set", "steps_per_contact=50", "--quantity", "rim_speed_ratio", "--output", "mine")
    answer("sweep", *words, *more, "--reference", "mine.csv")
    assert "mine.csv" in (tmp_path / "mine" / "figure.svg").read_text()


@pytest.mark.live
def test_a_restitution_that_is_measured_stands_beside_the_one_that_was_asked_for(
    answer, tmp_path, lammps_here  # noqa: ARG001
):  # fmt: skip
    """Tsuji's damping coefficient of LAMMPS does not give the restitution it is asked for."""
    (tmp_path / "mine.csv").write_text("restitution,measured_restitution\n0.5,0.55\n")
    hertz = {"normal": "hertz", "normal_stiffness": "none", "youngs_modulus": "1e8"}
    values = {**hertz, "poisson_ratio": "0.3", "damping": "tsuji"}
    settings = [word for name, value in values.items() for word in ("--set", f"{name}={value}")]
    words = ("--over", "restitution=0.2:0.8:4", "--quantity", "restitution", "--output", "mine")
    found = answer("sweep", "head-on", *settings, *words, "--reference", "mine.csv")
    asked, measured = [0.2, 0.4, 0.6, 0.8], [0.3431, 0.5294, 0.6990, 0.8534]
    assert [row["restitution"] for row in found["rows"]] == asked
    table = pd.read_csv(tmp_path / "mine" / "rows.csv")
    assert list(table["restitution"]) == asked
    assert list(table["measured_restitution"]) == pytest.approx(measured, abs=1e-4)
    svg = (tmp_path / "mine" / "figure.svg").read_text()
    assert "mine.csv" in svg


def test_parquet_is_the_same_table(answer, tmp_path):
    pytest.importorskip("pyarrow", reason="pip install 'dem-harness[parquet]'")
    answer("sweep", "incline", "--over", "angle=9:11:3", "--engines", "reference", "--output", "a")
    table = pd.read_parquet(tmp_path / "a" / "rows.parquet")
    text = pd.read_csv(tmp_path / "a" / "rows.csv", keep_default_na=False, na_values=[""])
    # an empty text and none are the same in CSV
    pd.testing.assert_frame_equal(table.drop(columns="reason"), text.drop(columns="reason"))


def test_without_pyarrow_the_sweep_says_so(command, tmp_path, monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *a: None if name == "pyarrow" else find(name, *a)
    )
    words = ("incline", "--over", "angle=9,10", "--engines", "reference", "--json")
    found = json.loads(command("sweep", *words).out)
    assert any("pip install 'dem-harness[parquet]'" in note for note in found["notes"])
    assert not (tmp_path / found["output"] / "rows.parquet").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere", "--over", "angle=9,10"], "case 'nowhere' is not known"),
        (["nowhere.toml"], "nowhere.toml: No such file"),
        (["slides.toml"], "slides.toml: [over] friction=-0.1: friction = '-0.1': must be greater"),
        (["rough.toml"], "rough.toml: [set] friction = '-0.1': must be greater"),
        (["rough.toml", "--set", "radius=1"], "rough.toml: --set: friction = '-0.1': must be"),
        (["incline"], "--over: must be given"),
        (["incline", "--over", "angle=9:99:3"], "--over angle=54: angle = '54' deg: must be"),
        (["incline", "--over", "angle=9", "--quantity", "mass"], "--quantity 'mass'"),
        (["incline", "--over", "angle=9", "--reference", "file"], "file: --quantity must say what"),
        (
            [
                "oblique",
                "--over",
                "angle=9",
                "--quantity",
                "rim_speed_ratio",
                "--reference",
                "mine.csv",
            ],
            "--reference mine.csv, row 1: no column rim_speed_ratio; found angle_deg, spin",
        ),
        (["incline", "--over", "angle=9", "--output", "file"], "--output file: is a file"),
    ],
)
def test_a_bad_request_is_an_error_of_a_line(arguments, said, command, tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "slides.toml").write_text('case = "oblique"\n[over]\nfriction = [0.3, -0.1]\n')
    (tmp_path / "mine.csv").write_text("angle_deg,spin\n5,0.1\n")
    (tmp_path / "rough.toml").write_text(
        'case = "oblique"\n[set]\nfriction = -0.1\n[over]\nangle = [10, 20]\n'
    )
    done = command("sweep", *arguments, status=2)
    assert said in done.err
    assert done.err.count("\n") == 1
    assert done.out == ""


def test_what_an_engine_refuses_is_a_row_and_the_rest_goes_on(answer):
    found = answer("sweep", "tower", "--over", "height=1,2", "--engines", "reference,exact")
    assert [row["status"] for row in found["rows"]] == ["not tested"] * 2 + ["done"] * 2
    assert found["rows"][0]["reason"] == "it writes no forces"
    # an engine that runs nothing is not held against theory first
    assert not [note for note in found["notes"] if "engine" in note]


def test_a_sweep_that_could_make_no_run_is_no_success(harness):
    words = ("sweep", "tower", "--over", "height=1,2", "--engines", "reference", "--output", "mine")
    done = harness(*words, status=3)
    assert "1 of 2 runs: it writes no forces" in done.stderr


def started(folder, *words):
    """Start a sweep in a process of its own, in a folder that has the counting engine."""
    return subprocess.Popen(
        [sys.executable, "-m", "harness", "sweep", "incline", *words],
        cwd=folder,
        env={**os.environ, "BEGUN": str(folder / "begun")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def test_a_sweep_that_is_killed_leaves_its_table_and_repeats_nothing_that_ended(tmp_path, home):
    (tmp_path / "counting.py").write_text(ENGINE.replace("0.02", "0.2"), encoding="utf-8")
    words = ["--over", "angle=9:11:40", "--engines", "counting:Counting", "--json"]
    words += ["--engine-option", "counting:Counting.workers=1", "--output", "mine"]
    table = tmp_path / "mine" / "rows.csv"

    def kept():
        return {path.name for path in (home / "cache").glob("??/*")}

    process, until = started(tmp_path, *words), time.monotonic() + 120.0
    while not table.exists() or len(kept()) < 3:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    rows = pd.read_csv(table)
    assert (len(rows), set(rows["status"])) == (40, {"done", "pending"})
    assert rows["margin_over_mgd"].notna().equals(rows["status"] == "done")
    before = kept()
    (tmp_path / "counting.py").write_text(ENGINE, encoding="utf-8")
    process = started(tmp_path, *words)
    out, said = process.communicate(timeout=300)
    assert process.returncode == 0, said
    found = json.loads(out)
    assert found["done"] == 40
    assert (found["engine_runs_from_cache"], found["engine_runs"]) == (
        len(before),
        40 - len(before),
    )
    begun = (tmp_path / "begun").read_text().splitlines()
    assert len(set(begun)) == 40
    assert len(begun) <= 41  # only the run that was under way is begun again


def test_two_sweeps_in_one_folder_at_once_are_refused(tmp_path, harness):
    (tmp_path / "counting.py").write_text(ENGINE, encoding="utf-8")
    begun = tmp_path / "begun"
    words = ["sweep", "incline", "--over", "angle=9:11:2000", "--engines", "counting:Counting"]
    words += ["--output", "mine"]
    first = started(tmp_path, *words[2:])
    try:
        while not begun.exists():
            assert first.poll() is None, first.communicate()
            time.sleep(0.01)
        refused = harness(*words, status=2)
        assert "--output mine: another sweep runs in it" in refused.stderr
    finally:
        first.kill()
        first.communicate()
