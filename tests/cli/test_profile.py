"""``run --profile``, and the figure that a case has of a sweep."""

import json

import pandas as pd
import pytest

SMALL = ("--set", "preset=small", "--set", "settle_time=10", "--set", "flow_time=20")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("incline", "--profile", "a.csv"), "--profile a.csv: case 'incline' has no profile"),
        (("layers-flow", "--profile", "a.txt"), "--profile a.txt: must end in .csv"),
        (("layers-flow", "--profile", "no/a.csv"), "there is no folder no"),
    ],
)
def test_what_cannot_be_is_refused_at_once(command, tmp_path, words, told):
    out, err = command("run", *words, status=2)
    assert out == ""
    assert told in err
    assert list(tmp_path.iterdir()) == []


def test_a_case_without_a_profile_has_no_key_of_it(command):
    out = command("run", "tower", "--engine", "exact", "--json").out
    assert set(json.loads(out)) >= {"case", "quantities"}
    assert "profile" not in json.loads(out)


@pytest.mark.live
def test_the_profile_is_a_table_and_in_the_record(command, tmp_path, lammps_here):  # noqa: ARG001
    path = tmp_path / "profile.csv"
    words = ("run", "layers-flow", *SMALL, "--json", "--profile", str(path))
    out = command(*words).out
    frame, record = pd.read_csv(path), json.loads(out)
    assert list(frame["height"]) == record["profile"]["height"]
    assert {"velocity", "solid_fraction", "mu", "inertial_number", "mu_uncertainty"} <= set(frame)
    assert frame["height"].is_monotonic_increasing


@pytest.mark.live
def test_the_curves_of_a_silo_are_a_table(command, tmp_path, lammps_here):  # noqa: ARG001
    small = ("layers=5", "silo_radius=0.012", "orifice_radius=0.008", "cone_height=0.004")
    sets = [word for value in (*small, "settle_time=0.1", "duration=0.4")
            for word in ("--set", value)]  # fmt: skip
    path = tmp_path / "profile.csv"
    record = json.loads(command("run", "silo", *sets, "--json", "--profile", str(path)).out)
    frame = pd.read_csv(path)
    assert list(frame) == ["time_s", "remaining"]
    assert frame["remaining"].iloc[0] == 60.0
    assert frame["time_s"].iloc[-1] == pytest.approx(0.4)
    half = frame["time_s"][frame["remaining"] <= 30.0].iloc[0]
    assert half == pytest.approx(record["quantities"]["half_time_s"]["value"])
    assert list(frame["remaining"]) == record["profile"]["remaining"]


@pytest.mark.live
def test_a_sweep_writes_the_figure_of_the_case(command, tmp_path, lammps_here):  # noqa: ARG001
    words = ("sweep", "layers-flow", "--over", "angle=16,20", *SMALL, "--output")
    command(*words, str(tmp_path / "out"))
    assert (tmp_path / "out" / "flow-law.svg").is_file()
    assert "1 layers" not in (tmp_path / "out" / "flow-law.svg").read_text()
