"""``run``: the keys of its JSON, files on request, and bad input."""

import pytest

from tests.workflows import doubles


def test_the_keys_of_a_run(answer):
    record = answer("run", "bounce", "--engine", "good", "--set", "steps=100")
    assert record["parameters"]["steps"] == 100
    assert record["engine_version"] == "1"
    found = record["quantities"]["restitution"]
    assert found["reference_kind"] == "equal steps"
    assert (found["difference"], found["unit"]) == (0.0, "1")
    assert set(found) == {
        "value", "unit", "reference", "reference_kind", "difference", "limit", "step_error",
    }  # fmt: skip
    assert record["qualified"]


def test_the_usual_engine_is_lammps_or_a_solver_where_it_cannot(answer, monkeypatch):
    assert answer("run", "bounce")["engine"] == "lammps"
    monkeypatch.setattr("harness.workflows.runs.takes_job", lambda *_: False)
    assert answer("run", "bounce")["engine"] == "exact"


def test_files_are_written_whole(harness, tmp_path):
    words = ("--profile", "p.csv", "--script", "in.run", "--film", "f.png", "--frames", "5")
    harness("run", "bounce", "--engine", "good", *words)
    assert (tmp_path / "p.csv").read_text().splitlines()[0] == "time_s"
    assert (tmp_path / "in.run").read_text() == "run 200\n"
    assert (tmp_path / "f.png").read_bytes()[:4] == b"\x89PNG"


def test_an_engine_that_does_not_qualify_is_status_3(answer, harness):
    record = answer("run", "bounce", "--engine", "off", status=3)
    assert not record["qualified"]
    assert (
        "its result is not to be used" in harness("run", "bounce", "--engine", "off", status=3).err
    )


def test_a_run_that_dies_is_status_3(harness):
    assert "signal SIGSEGV" in harness("run", "bounce", "--engine", "dying", status=3).err
    assert "no program" in harness("run", "bounce", "--engine", "missing", status=3).err


def test_an_internal_error_is_one_line_and_status_4(harness, monkeypatch):
    monkeypatch.setattr(doubles.BounceCase, "measure", lambda *_: 1 / 0)
    text = harness("run", "bounce", "--engine", "good", status=4).err
    assert "internal error: ZeroDivisionError" in text
    assert "this is a bug; DEM_HARNESS_TRACEBACK=1" in text


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["nix"], ["case 'nix'", "must be one of bounce, wrong"]),
        (["bounce", "--set", "stiffness=-1"], ["--set stiffness = '-1' N/m", "greater than 0"]),
        (["bounce", "--set", "stiffness"], ["--set 'stiffness'", "NAME=VALUE"]),
        (["bounce", "--set", "steps=20", "--set", "steps=30"], ["--set", "steps is given twice"]),
        (["bounce", "--engine", "nix"], ["--engine 'nix'", "must be one of lammps", "exact"]),
        (["bounce", "--engine", "refusing"], ["'refusing'", "cannot run", "no springs"]),
        (["bounce", "--quantity", "mass"], ["--quantity 'mass'", "restitution, time_s"]),
        (["bounce", "--frames", "5"], ["--frames 5", "goes with --film only"]),
        (["bounce", "--film", "f.png", "--frames", "1.5"], ["--frames '1.5'", "whole number"]),
        (["bounce", "--film", "f.avi"], ["--film f.avi", ".gif, .mp4, .png"]),
        (["bounce", "--profile", "p.txt"], ["--profile p.txt", ".csv"]),
        (["bounce", "--script", "nowhere/x"], ["--script nowhere/x", "no folder nowhere"]),
        (["bounce", "--engine", "exact", "--film", "f.png"], ["--film", "a solver"]),
        (["bounce", "--cache", "/proc/x"], ["--cache /proc/x", "cannot be used"]),
        (["bounce", "--dask", "nowhere"], ["--dask"]),
        ([], ["CASE", "see dem-harness run --help"]),
    ],
)
def test_bad_input_is_status_2_and_names_option_value_and_allowed(harness, tmp_path, words, parts):
    text = harness("run", *words, status=2).err
    assert len(text.splitlines()) <= 2
    for part in parts:
        assert part in text
    assert not list(tmp_path.iterdir())


def test_a_run_that_takes_more_than_ten_minutes_is_refused(harness, monkeypatch):
    slow = doubles.replace(doubles.Good.traits, microseconds_per_step=1e7)
    monkeypatch.setattr(doubles.Good, "traits", slow)
    text = harness("run", "bounce", "--engine", "good", status=2).err
    assert "33.3 minutes on one core, 10 minutes are the limit" in text
    harness("run", "bounce", "--engine", "good", "--force")
