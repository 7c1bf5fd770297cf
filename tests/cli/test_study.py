"""``study`` from the command line: what is refused, before anything runs."""

import json
from pathlib import Path

import pytest


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
