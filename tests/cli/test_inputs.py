import ast
from pathlib import Path

import pytest

from harness.workflows.engine_status import generated_inputs

COMMITTED = Path(__file__).parents[2] / "inputs"
SCRIPTS = {
    "lammps": "incline-source.in",
    "liggghts": "silo.in",
    "yade": "silo.py",
    "kratos": "silo.py",
    "mfix": "tower/mfix.dat",
}


def files_in(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


def test_what_is_written_passes_the_check(harness, tmp_path):
    harness("inputs", "--folder", "scripts")
    harness("inputs", "--folder", "scripts", "--check")
    assert files_in(tmp_path / "scripts") == set(generated_inputs())


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


@pytest.mark.parametrize("engine", SCRIPTS)
def test_the_scripts_of_an_engine_are_written_and_compile(answer, tmp_path, engine):
    folder = tmp_path / "made" / "scripts"
    written = answer("inputs", "--engine", engine, "--output", str(folder))["written"]
    assert {str(Path(path).relative_to(folder)) for path in written} == files_in(folder)
    assert SCRIPTS[engine] in files_in(folder)
    for script in folder.glob("*.py"):
        compile(script.read_text(), script.name, "exec", ast.PyCF_ONLY_AST)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--folder none --check", "no such folder"),
        ("--folder file", "cannot be written"),
        ("--engine yade", "--engine yade: needs --output DIR"),
        ("--output new", "--output new: needs --engine NAME"),
        ("--engine yade --output new --check", "--engine yade: does not go with --check"),
        ("--engine yade --output new --folder x", "--folder x: does not go with --engine"),
        ("--engine yad --output new", "--engine 'yad' is not known: must be one of lammps, "),
        ("--engine reference --output new", "'reference' runs without scripts: must be one of"),
        ("--engine yade --output full", "--output full: holds something already"),
        ("--engine yade --output file", "--output file: is a file"),
        ("--engine yade --output /proc/new", "--output /proc/new: cannot be written"),
    ],
)
def test_bad_options_are_named_and_nothing_is_written(harness, tmp_path, words, said):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "kept").write_text("")
    (tmp_path / "file").write_text("")
    before = files_in(tmp_path)
    assert said in harness("inputs", *words.split(), status=2).stderr
    assert files_in(tmp_path) == before
    assert not (tmp_path / "new").exists()
