"""``verify``: what is printed and written, kept verifications, and exit status."""

import pytest

from tests.workflows import doubles


def test_the_json_has_status_headline_and_the_columns_of_the_table(answer):
    record = answer("verify", "--quick", "--engines", "good")
    assert (record["status"], record["headline"]) == (0, "All verdicts hold")
    assert {"case", "setup", "quantity", "engine", "check", "verdict"} <= set(record["rows"][0])


def test_the_folder_has_report_rows_and_scripts(harness, tmp_path):
    harness("verify", "--engines", "good", "--output", "mine", "--png")
    assert {path.name for path in (tmp_path / "mine").iterdir()} == {
        "report.html", "report.md", "rows.csv", "run.json", "junit.xml", "scripts",
    }  # fmt: skip


def test_a_failure_is_printed_with_value_tolerance_and_class(harness):
    text = harness("verify", "--engines", "off", status=1).out
    for part in ("fail: bounce (200 steps), off: restitution", "tolerance 1e-12",
                 "out of tolerance", "Failed: 2 cross-code"):  # fmt: skip
        assert part in text


def test_the_same_verification_is_kept_whole(answer, monkeypatch, tmp_path):
    first = answer("verify", "--engines", "good", "--output", "one")
    monkeypatch.setattr(doubles.Good, "ran", 0)
    again = answer("verify", "--engines", "good", "--output", "two")
    assert (first["cached"], again["cached"]) == (False, True)
    assert again["rows"] == first["rows"]
    assert (tmp_path / "two" / "rows.csv").read_bytes() == (
        tmp_path / "one" / "rows.csv"
    ).read_bytes()
    assert doubles.Good.ran == 0
    assert not answer("verify", "--engines", "good", "--fresh")["cached"]
    assert doubles.Good.ran == 2
    for other in (["--quick"], ["--strict"], ["--only", "bounce/200*"], ["--cases", "bounce"]):
        assert not answer("verify", "--engines", "good", *other)["cached"]


def test_a_verification_of_an_engine_that_died_is_not_kept(answer):
    for _ in range(2):
        assert not answer("verify", "--engines", "dying", status=3)["cached"]


def test_defects_of_a_file_are_read_and_a_bad_one_is_refused(harness, tmp_path):
    (tmp_path / "mine.toml").write_text("[defect.soft]\ncause = 3\n")
    text = harness("verify", "--engines", "off", "--known-defects", "mine.toml", status=2).err
    assert "mine.toml" in text
    assert "soft" in text


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["--quick", "--full"], ["--quick and --full", "one of them"]),
        (["--cases", "nix"], ["--cases 'nix'", "all, a group (balls, others)"]),
        (["--engines", "nix"], ["--engines 'nix'", "all, or one or more of lammps"]),
        (["--only", "bounc/*"], ["--only 'bounc/*'", "near it: ", "'bounce'"]),
        (["--known-defects", "no.toml"], ["--known-defects no.toml", "no such file"]),
        (["--program", "good"], ["--program 'good'", "NAME=VALUE"]),
        (["--program", "good=x"], ["--program good=x", "goes with --engines good only"]),
        (["--engines", "good", "--lmp", "x"], ["--lmp 'x'", "goes with --engines lammps only"]),
        (
            ["--engine-option", "lammps.colour=red"],
            ["--engine-option lammps.colour=red", "takes the options"],
        ),
        (["--engine-option", "colour"], ["--engine-option 'colour'", "NAME=VALUE"]),
        (["--mpirun", "'"], ['--mpirun "\'"', "quotation"]),
        (["--colour", "red"], ["--colour", "see dem-harness verify --help"]),
        (["--output", "."], ["--output .", "holds something already"]),
    ],
)
def test_a_wrong_option_is_named_with_value_and_what_is_allowed(harness, tmp_path, words, parts):
    (tmp_path / "letter.txt").touch()
    text = harness("verify", *words, status=2).err
    assert len(text.splitlines()) <= 2
    for part in parts:
        assert part in text
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]
