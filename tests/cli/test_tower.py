from __future__ import annotations

import json
import subprocess
import sys

import pandas as pd
import pytest

from harness.cli import main


def run(monkeypatch, capsys, *words):
    """Return exit status, stdout and stderr of the command."""
    monkeypatch.setattr(sys, "argv", ["dem-harness", "tower", *words])
    with pytest.raises(SystemExit) as left:
        main()
    printed = capsys.readouterr()
    return left.value.code or 0, printed.out, printed.err


def test_json(monkeypatch, capsys):
    status, out, err = run(monkeypatch, capsys, "--json", "--height", "2")
    assert status == 0
    assert err == ""
    record = json.loads(out)
    assert (record["law"], record["solver"], record["height"]) == ("deformable", "rk4", 2)
    assert record["impulse_Ns"] == pytest.approx(3.8187, abs=1e-3)
    assert record["contact_time_s"] == pytest.approx(3.1514e-3, abs=1e-6)
    assert record["contacts"][0] == [0.0, 1]


def test_exact_and_overlap(monkeypatch, capsys):
    words = ("--json", "--law", "overlap", "--solver", "exact", "--gravity", "0")
    record = json.loads(run(monkeypatch, capsys, *words)[1])
    assert record["impulse_Ns"] == pytest.approx(4.0, rel=1e-10)
    assert record["step_s"] is None


def test_short_duration_still_knows_the_impulse(monkeypatch, capsys):
    record = json.loads(run(monkeypatch, capsys, "--json", "--duration", "0.2")[1])
    assert record["impulse_Ns"] == pytest.approx(4.0309, abs=1e-3)
    assert record["duration_s"] == pytest.approx(0.2 * record["contact_time_s"])


def test_series(monkeypatch, capsys, tmp_path):
    path = tmp_path / "series.csv"
    status, _, _ = run(monkeypatch, capsys, "--series", str(path), "--steps-per-contact", "200")
    assert status == 0
    frame = pd.read_csv(path)
    assert "grain_force_N" in frame
    assert len(frame) > 500
    assert [p.name for p in tmp_path.iterdir()] == ["series.csv"]


def test_table(monkeypatch, capsys):
    status, out, _ = run(monkeypatch, capsys, "--window", "first-contact")
    assert status == 0
    assert "impulse_Ns" in out


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
def test_bad_requests_end_with_status_2(monkeypatch, capsys, words, said):
    status, out, err = run(monkeypatch, capsys, *words)
    assert status == 2
    assert out == ""
    assert said in err
    assert "Traceback" not in err


def test_help_is_fast_and_loads_nothing_heavy():
    code = (
        "import sys; from harness.cli.command import app\n"
        "try: app(['tower', '--help'])\n"
        "except SystemExit: pass\n"
        "assert not {'numba', 'numpy', 'pandas', 'matplotlib'} & set(sys.modules)"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert "Drop a grain" in result.stdout
