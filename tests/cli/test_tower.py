from __future__ import annotations

import json

import pandas as pd
import pytest


def test_json(command):
    said = command("tower", "--json", "--height", "2")
    assert said.err == ""
    record = json.loads(said.out)
    assert (record["law"], record["solver"], record["height"]) == ("deformable", "rk4", 2)
    assert record["impulse_Ns"] == pytest.approx(3.8187, abs=1e-3)
    assert record["contact_time_s"] == pytest.approx(3.1514e-3, abs=1e-6)
    assert record["contacts"][0] == [0.0, 1]


def test_exact_and_overlap(command):
    words = ("--json", "--law", "overlap", "--solver", "exact", "--gravity", "0")
    record = json.loads(command("tower", *words).out)
    assert record["impulse_Ns"] == pytest.approx(4.0, rel=1e-10)
    assert record["step_s"] is None


def test_short_duration_still_knows_the_impulse(command):
    record = json.loads(command("tower", "--json", "--duration", "0.2").out)
    assert record["impulse_Ns"] == pytest.approx(4.0309, abs=1e-3)
    assert record["duration_s"] == pytest.approx(0.2 * record["contact_time_s"])


def test_series(command, tmp_path):
    path = tmp_path / "series.csv"
    command("tower", "--series", str(path), "--steps-per-contact", "200")
    frame = pd.read_csv(path)
    assert "grain_force_N" in frame
    assert len(frame) > 500
    assert [p.name for p in tmp_path.iterdir()] == ["series.csv"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--height", "0"), "--height 0"),
        (("--mass", "nan"), "--mass nan"),
        (("--stiffness", "-1"), "--stiffness -1.0"),
        (("--duration", "0"), "--duration 0.0 t0"),
        (("--steps-per-contact", "1"), "--steps-per-contact 1.0"),
        (("--speed", "0", "--gravity", "0"), "--speed 0.0"),
        (("--height", "9", "--window", "structure"), "too short"),
        (("--series", "/nowhere/at/all.csv"), "/nowhere/at/all.csv"),
        (("--law", "hertz"), "hertz"),
        (("--height", "x"), "--height 'x': must be a whole number"),
        (("--solver", "nobody"), "--solver 'nobody' is not known: must be one of lammps"),
        (("--solver", "exact", "--lmp", "sh"), "--lmp 'sh': goes with --solver lammps only"),
        (("--solver", "exact", "--program", "yade=sh"), "--program yade=sh: goes with --solver"),
        (("--solver", "yade", "--engine-option", "yade"), "--engine-option 'yade': must be"),
        (("--solver", "lammps", "--mpirun", '"'), "--mpirun '\"': no closing quotation"),
    ],
)
def test_bad_requests_end_with_status_2(command, words, said):
    done = command("tower", *words, status=2)
    assert done.out == ""
    assert said in done.err
    assert "Traceback" not in done.err
