"""``study`` from the command line: what is refused, before anything runs."""

import json
import shlex
from pathlib import Path

import pytest

from harness.cases.study import Conclusion
from harness.cli.study import _write
from harness.workflows.study_run import StudyResult


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("incline",), "case 'incline' has no study: must be one of layers"),
        (("layers", "--quick", "--full"), "--quick and --full: give one of them only"),
        (("layers", "--reference", "none.csv"), "--reference none.csv: No such file"),
        (("layers", "--quick", "--runs", "none.csv"), "--runs none.csv: No such file"),
        (("layers", "--runs", "none.csv", "--cost"), "--runs none.csv: No such file"),
        (("layers", "--runs", "a.csv", "--fresh"), "--runs and --fresh: give one of them only"),
        (("layers", "--ranks", "2"), "--ranks 2: goes with --executor slurm only"),
        (
            ("layers", "--full"),
            "runs of study layers (level full, what is kept counted as well) would take",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(harness, words, told):
    done = harness("study", *words, status=2)
    assert told in done.stderr
    assert done.stdout == ""


def test_what_full_costs_by_the_committed_runs_is_what_their_page_says(harness):
    folder = Path(__file__).parents[2] / "reports/layers"
    runs = str(folder / "runs.csv")
    done = harness("study", "layers", "--full", "--cost", "--runs", runs, "--json")
    first = json.loads(done.stdout)["rows"][0]
    assert first["cores"] == 1
    assert f"| 1 | {first['wall_time_h']:.1f} |" in (folder / "report.md").read_text("utf-8")


@pytest.mark.parametrize("name", ["runs.csv", "runs of two machines.csv"])
def test_a_report_names_the_file_of_runs_and_no_place_of_a_machine(tmp_path, name):
    found = StudyResult(
        "layers", "Layers", "Where do they stop?", "default", "lammps",
        runs=({"status": "done", "engine_version": "1"},),
        conclusion=Conclusion(({"layers": 1},), ("They stop.",), "none", ()),
        taken=1,
    )  # fmt: skip
    folder = tmp_path / "report"
    _write(found, folder, tmp_path / "elsewhere" / name)
    for path in (one for one in folder.rglob("*") if one.is_file()):
        assert tmp_path.name not in path.read_text("utf-8"), path.name
    (command,) = [line for line in (folder / "report.md").read_text("utf-8").splitlines()
                  if line.startswith("- command: ")]  # fmt: skip
    assert shlex.split(command.replace("\\", ""))[-2:] == ["--runs", name]
    assert "--runs" in (folder / "report.html").read_text("utf-8")
