"""``dem-harness upstream`` and ``dem-harness defect``."""

import csv
from pathlib import Path

TSUJI = Path(__file__).parents[2] / "reports/defects/tsuji-restitution/test.yaml"


def test_a_defect_is_shown_with_its_script(command):
    said = command("defect", "tsuji-restitution").out
    for text in ("sqrt(2) too weak", "22 Jul 2025", "pair_style granular", "pull request 5113"):
        assert text in said


def test_all_defects_are_listed(answer):
    names = {defect["name"] for defect in answer("defect")["defects"]}
    assert {"tsuji-restitution", "old-wall-friction"} <= names


def test_a_wrong_name_names_the_near_one(command):
    said = command("defect", "tsuji-restituton", status=2).err
    assert "did you mean tsuji-restitution" in said


def test_a_known_defect_is_named_by_upstream(command, tmp_path):
    folder = tmp_path / "report"
    said = command("upstream", str(TSUJI), "--output", str(folder)).out
    assert "tsuji-restitution" in said
    assert {path.name for path in folder.iterdir()} == {"report.md", "rows.csv"}
    (row,) = csv.DictReader((folder / "rows.csv").read_text().splitlines())
    assert row["recorded"] == row["law"] == "known defect"
    assert row["known_defect"] == "tsuji-restitution"


def test_a_path_without_tests_is_refused_and_leaves_nothing(command, tmp_path):
    empty = tmp_path / "empty"
    empty.mkdir()
    said = command("upstream", str(empty), "--output", str(tmp_path / "out"), status=2).err
    assert str(empty) in said
    assert not (tmp_path / "out").exists()
