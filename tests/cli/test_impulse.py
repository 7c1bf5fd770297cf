from __future__ import annotations

import json
import os

import pandas as pd
import pytest

FAST = ("--heights", "1-3", "--stiffness", "1e6", "--speed", "2")
KEYS = {
    "height", "stiffness_N_per_m", "speed_m_per_s", "law", "window", "impulse_ratio",
    "critical_angle_deg", "impulse_Ns", "window_s", "gamma",
}  # fmt: skip


@pytest.fixture
def impulse(command):
    """Return a function that runs the command and returns what it printed."""
    return lambda *words, **more: command("impulse", *map(str, words), **more)


@pytest.fixture
def answer(impulse):
    def run(*words):
        said = impulse(*words, "--json")
        assert said.err == ""
        return json.loads(said.out)

    return run


def test_rows(answer):
    found = answer(*FAST)
    assert (found["reading"], found["solver"]) == ("lost", "rk4")
    assert len(found["rows"]) == 3 * 2
    assert all(set(row) >= KEYS for row in found["rows"])
    two = next(r for r in found["rows"] if r["height"] == 2 and r["law"] == "deformable")
    assert two["impulse_ratio"] == pytest.approx(0.947, abs=1e-3)
    assert two["critical_angle_deg"] == pytest.approx(9.507, abs=1e-3)
    assert two["gamma"] == pytest.approx(9.81 / 2 / 1e3)
    assert two["window"] == "turnaround"


def test_without_options_it_is_the_sources_runs(answer):
    rows = answer("--solver", "exact")["rows"]
    assert len(rows) == 19 * 6 * 2
    assert {row["height"] for row in rows} == set(range(1, 20))
    assert {row["stiffness_N_per_m"] for row in rows} == {1e5, 1e6, 1e7}
    assert {row["speed_m_per_s"] for row in rows} == {2.0, 4.0}


def test_a_window_that_does_not_exist_is_null(answer):
    rows = answer("--heights", "9", "--stiffness", "1e6", "--speed", "2", "--window", "structure")[
        "rows"
    ]
    for row in rows:
        for key in ("impulse_ratio", "critical_angle_deg", "impulse_Ns", "window_s"):
            assert row[key] is None


def test_options_reach_the_towers(answer):
    found = answer(
        "--heights", "30,2", "--stiffness", "1e5,1e6", "--stiffness", "4e6", "--speed", "3",
        "--law", "overlap", "--window", "first-contact", "--solver", "exact", "--gravity", "0",
        "--mass", "2", "--reading", "kept",
    )  # fmt: skip
    rows = found["rows"]
    assert [row["height"] for row in rows] == [30, 2] * 3
    assert [row["stiffness_N_per_m"] for row in rows] == [1e5, 1e5, 1e6, 1e6, 4e6, 4e6]
    assert rows[0]["impulse_ratio"] == pytest.approx(0.5661397, abs=1e-6)
    assert rows[0]["impulse_Ns"] == pytest.approx(0.5661397 * 2 * 2 * 3, abs=1e-5)
    assert rows[0]["critical_angle_deg"] > 10.21
    assert rows[0]["gamma"] == 0


def test_figure(impulse, tmp_path):
    reference = tmp_path / "mine.csv"
    reference.write_text("h_over_d,theta_deg\n2,9\n", encoding="utf-8-sig")
    target = tmp_path / "figure.svg"
    said = impulse(*FAST, "--reference", reference, "--figure", target)
    assert said.err == f"--figure: {target} is written\n"
    assert target.read_bytes().startswith(b"<?xml")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["mine.csv", target.name])


def test_csv_holds_the_rows(impulse, answer, tmp_path):
    target = tmp_path / "table.csv"
    impulse(*FAST, "--csv", target)
    rows = pd.DataFrame(answer(*FAST)["rows"])
    pd.testing.assert_frame_equal(pd.read_csv(target), rows)


def test_reference_is_in_the_json(impulse, tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("theta_deg,h_over_d\n9,2\n6,11.5\n", encoding="utf-8")
    figure = tmp_path / "f.svg"
    said = impulse(*FAST, "--reference", path, "--figure", figure, "--json")
    assert json.loads(said.out)["reference"] == [
        {"h_over_d": 2.0, "theta_deg": 9.0},
        {"h_over_d": 11.5, "theta_deg": 6.0},
    ]


FIGURE = ("--figure", "never.svg")
GOOD = "h_over_d,theta_deg\n2,9\n"


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "is empty"),
        (GOOD.encode("utf-16"), "is UTF-16 or no text at all"),
        (b"h_over_d,theta_deg\n2,9\n3,8\xb0\n", "row 3: byte 0xb0 is not UTF-8 (Latin-1 perhaps)"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "is UTF-16 or no text at all"),
        (b"h_over_d;theta_deg\n2;9\n", "row 1: columns are separated by semicolons"),
        (b"h_over_d,angle\n2,9\n", "row 1: no column theta_deg"),
        (b"h_over_d,theta_deg\n2,9\nthree,8\n", "row 3: h_over_d = 'three' is not a number"),
        (b"h_over_d,theta_deg\n2,nan\n", "row 2: theta_deg = nan must be"),
        (b"h_over_d,theta_deg\n-2,9\n", "row 2: h_over_d = -2 must be"),
        (b"h_over_d,theta_deg\n2,91\n", "row 2: theta_deg = 91 must be at most 90"),
    ],
)
def test_bad_references_are_one_line_and_nothing_is_written(impulse, tmp_path, data, said):
    path = tmp_path / "mine.csv"
    path.write_bytes(data)
    words = ("--reference", path, "--figure", tmp_path / "f.svg", "--csv", tmp_path / "t.csv")
    out, err = impulse(*FAST, *words, "--json", status=2)
    assert json.loads(out) == {"error": err.removeprefix("dem-harness: ").strip(), "status": 2}
    assert f"--reference {path}" in err
    assert said in err
    assert err.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["mine.csv"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--heights", "0-3"), "--heights '0-3': 0-3 must rise within 1 to 10000"),
        (("--heights", "5-3"), "5-3 must rise"),
        (("--heights", "1-99999"), "1-99999 must rise"),
        (("--heights", "1,,2"), "'' must be a whole number or a range"),
        (("--heights", "2.5"), "'2.5' must be a whole number"),
        (("--stiffness", "1e5,soft"), "--stiffness '1e5,soft': 'soft' is not a number"),
        (("--stiffness", "-1"), "--stiffness -1.0"),
        (("--stiffness", "nan"), "--stiffness nan"),
        (("--speed", "inf"), "--speed inf"),
        (("--speed", "0", "--gravity", "0"), "--speed 0.0"),
        (("--mass", "0"), "--mass 0.0"),
        (("--gravity", "-1"), "--gravity -1.0"),
        (("--law", "hertz"), "hertz"),
        (("--window", "half"), "half"),
        (("--reading", "read"), "read"),
        (("--solver", "euler"), "euler"),
        (("--figure", "theta.jpg"), "--figure theta.jpg: must end in .svg, .png, .pdf"),
        (("--figure", "/nowhere/at/all.svg"), "there is no folder /nowhere/at"),
        (("--csv", "/nowhere/at/all.csv"), "there is no folder /nowhere/at"),
        (("--csv", "/tmp"), "--csv /tmp: is a folder"),
        (("--csv", "same.svg", "--figure", "same.svg"), "must be two files"),
        (("--reference", "r.csv"), "--reference r.csv: is drawn in a figure only; add --figure"),
        (("--reference", "/nowhere.csv", *FIGURE), "--reference /nowhere.csv: No such file"),
        (("--reference", "/tmp", *FIGURE), "--reference /tmp: Is a directory"),
        (("--reference", "/dev/zero", *FIGURE), "--reference /dev/zero: is longer than"),
        (("--csv", "x" * 300), "File name too long"),
        (("--program", "yade"), "--program 'yade': must be NAME=VALUE"),
    ],
)
def test_bad_requests_end_with_status_2(impulse, words, said):
    out, err = impulse("--heights", "1", *words, status=2)
    assert out == ""
    assert said in err
    assert "Traceback" not in err


def test_a_full_disk_is_status_4_and_leaves_no_file(impulse, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", fail)
    words = ("--figure", tmp_path / "f.svg", "--csv", tmp_path / "t.csv")
    out, err = impulse(*FAST, *words, status=4)
    assert out == ""
    assert "f.svg: No space left on device" in err
    assert list(tmp_path.iterdir()) == []


def test_the_program_of_an_engine_can_be_named(impulse):
    words = ("--solver", "yade", "--program", "yade=/nowhere/yade")
    said = impulse("--heights", "1", *words, status=2).err
    assert "--program yade '/nowhere/yade': no such executable" in said


def test_a_device_is_not_replaced_by_a_file(impulse, tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    said = impulse("--heights", "1", "--csv", "pipe.csv", status=2).err
    assert "pipe.csv: is a device" in said
    assert (tmp_path / "pipe.csv").is_fifo()
