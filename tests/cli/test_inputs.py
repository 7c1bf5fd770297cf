from contextlib import contextmanager
from pathlib import Path

import pytest

from harness.cli.publish import inputs
from harness.workflows.engine_status import generated_inputs

COMMITTED = Path(__file__).parents[2] / "inputs"


def test_what_is_written_passes_the_check(harness, tmp_path):
    harness("inputs", "--folder", "scripts")
    harness("inputs", "--folder", "scripts", "--check")
    folder = tmp_path / "scripts"
    written = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}
    assert written == set(generated_inputs())


def test_the_committed_ones_are_up_to_date(harness):
    harness("inputs", "--folder", str(COMMITTED), "--check")


def test_a_changed_or_missing_script_fails_the_check(answer, tmp_path):
    answer("inputs", "--folder", "scripts")
    changed, missing = (tmp_path / "scripts" / f"{name}.in" for name in ("incline-source", "tower"))
    changed.write_text(changed.read_text().replace("index 10.2", "index 10.3"))
    missing.unlink()
    record = answer("inputs", "--folder", "scripts", "--check", status=1)
    assert not record["up_to_date"]
    assert "index 10.3" in record["outdated"][changed.name]
    assert record["outdated"][missing.name] == "is missing"


def test_bad_folders(harness, tmp_path):
    (tmp_path / "file").write_text("")
    assert "no such folder" in harness("inputs", "--folder", "none", "--check", status=2).stderr
    assert "cannot be written" in harness("inputs", "--folder", "file", status=2).stderr


@pytest.mark.parametrize("check", [False, True])
def test_the_seconds_that_it_takes_are_counted_on_a_terminal(monkeypatch, tmp_path, check):
    told = []

    @contextmanager
    def bars(title, *, quiet):
        told.append((title, quiet))
        yield

    monkeypatch.setattr("harness.workflows.progress_bars", bars)
    inputs(folder=tmp_path, check=check)
    assert told == [("inputs", False)]
