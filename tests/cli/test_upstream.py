"""``dem-harness upstream`` and ``dem-harness defect``."""

import pytest

from harness.upstream.definition import read_test


def test_a_defect_is_shown_with_its_script(command):
    said = command("defect", "tsuji-restitution").out
    for text in ("sqrt(2) too weak", "22 Jul 2025", "pair_style granular", "pull request 5113"):
        assert text in said


def test_all_defects_are_listed(answer):
    names = {defect["name"] for defect in answer("defect")["defects"]}
    assert {"tsuji-restitution", "rot-elastic-scaled"} <= names


def test_a_wrong_name_names_the_near_one(command):
    said = command("defect", "tsuji-restituton", status=2).err
    assert "did you mean tsuji-restitution" in said


@pytest.mark.parametrize("option", ["--output", "--lmp"])
def test_an_option_of_the_test_needs_it(command, option, tmp_path):
    file = tmp_path / "x.yaml"
    said = command("defect", "tsuji-restitution", option, str(file), status=2).err
    assert option in said
    assert "--as-test" in said
    assert not file.exists()


@pytest.mark.slow
def test_the_test_of_a_defect_runs_upstream(command, answer, tmp_path):
    file, folder = tmp_path / "tsuji.yaml", tmp_path / "report"
    command("defect", "tsuji-restitution", "--as-test", "--output", str(file))
    assert read_test(file).atoms == 2
    said = command("upstream", str(file), "--output", str(folder)).out
    assert "tsuji-restitution" in said
    assert {path.name for path in folder.iterdir()} == {"report.md", "rows.csv"}
    page = (folder / "report.md").read_text()
    assert "| tsuji |" in page
    assert "known defect" in page
    assert answer("upstream", str(file))["rows"][0]["known_defect"] == "tsuji-restitution"


def test_a_path_without_tests_is_refused_and_leaves_nothing(command, tmp_path):
    empty = tmp_path / "empty"
    empty.mkdir()
    said = command("upstream", str(empty), "--output", str(tmp_path / "out"), status=2).err
    assert str(empty) in said
    assert not (tmp_path / "out").exists()
