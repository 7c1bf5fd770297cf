"""``run --profile``, and the figure that a case has of a sweep."""

import json
import sys

import pandas as pd
import pytest

from harness.cli import main

SMALL = ("--set", "preset=small", "--set", "settle_time=10", "--set", "flow_time=20")


def run(monkeypatch, capsys, *words):
    monkeypatch.setattr(sys, "argv", ["dem-harness", *words])
    with pytest.raises(SystemExit) as left:
        main()
    printed = capsys.readouterr()
    return left.value.code or 0, printed.out, printed.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("incline", "--profile", "a.csv"), "--profile a.csv: case 'incline' has no profile"),
        (("layers-flow", "--profile", "a.txt"), "--profile a.txt: must end in .csv"),
        (("layers-flow", "--profile", "no/a.csv"), "there is no folder no"),
    ],
)
def test_what_cannot_be_is_refused_at_once(monkeypatch, capsys, tmp_path, words, told):
    monkeypatch.chdir(tmp_path)
    status, out, err = run(monkeypatch, capsys, "run", *words)
    assert (status, out) == (2, "")
    assert told in err
    assert list(tmp_path.iterdir()) == []


def test_a_case_without_a_profile_has_no_key_of_it(monkeypatch, capsys):
    _, out, _ = run(monkeypatch, capsys, "run", "tower", "--engine", "exact", "--json")
    assert set(json.loads(out)) >= {"case", "quantities"}
    assert "profile" not in json.loads(out)


@pytest.mark.live
def test_the_profile_is_a_table_and_in_the_record(monkeypatch, capsys, tmp_path, lammps_here):  # noqa: ARG001
    path = tmp_path / "profile.csv"
    words = ("run", "layers-flow", *SMALL, "--json", "--profile", str(path))
    status, out, err = run(monkeypatch, capsys, *words)
    assert status == 0, err
    frame, record = pd.read_csv(path), json.loads(out)
    assert list(frame["height"]) == record["profile"]["height"]
    assert {"velocity", "solid_fraction", "mu", "inertial_number", "mu_uncertainty"} <= set(frame)
    assert frame["height"].is_monotonic_increasing


@pytest.mark.live
def test_a_sweep_writes_the_figure_of_the_case(monkeypatch, capsys, tmp_path, lammps_here):  # noqa: ARG001
    words = ("sweep", "layers-flow", "--over", "angle=16,20", *SMALL, "--output")
    status, _, err = run(monkeypatch, capsys, *words, str(tmp_path / "out"))
    assert status == 0, err
    assert (tmp_path / "out" / "flow-law.svg").is_file()
    assert "1 layers" not in (tmp_path / "out" / "flow-law.svg").read_text()
