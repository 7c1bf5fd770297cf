"""``sweep``: table and figure in a folder that goes on, and bad input."""

import pandas as pd
import pytest

from tests.workflows import doubles

WORDS = ("sweep", "bounce", "--over", "restitution=0.2,0.8", "--engines", "good,exact")


def test_table_and_figure_are_written_and_the_same_sweep_goes_on(answer, tmp_path, monkeypatch):
    record = answer(*WORDS, "--output", "mine")
    assert (record["done"], record["failed"], record["engine_runs"]) == (4, 0, 3)  # one qualifies
    frame = pd.read_csv(tmp_path / "mine" / "rows.csv")
    assert frame["restitution"].tolist() == [0.2, 0.8, 0.2, 0.8]
    assert frame["measured_restitution"].to_numpy() == pytest.approx([0.2, 0.8] * 2, abs=5e-3)
    assert {"figure.svg", "figure.png", "sweep.json"} <= {
        p.name for p in (tmp_path / "mine").iterdir()
    }
    monkeypatch.setattr(doubles.Good, "ran", 0)
    answer(*WORDS, "--output", "mine")
    assert doubles.Good.ran == 0


def test_a_failed_run_is_status_3_and_a_reason_on_stderr(harness):
    said = harness("sweep", "bounce", "--over", "steps=20,30", "--engines", "good,dying", status=3)
    assert "2 of 4 runs: signal SIGSEGV" in said.err
    assert said.out.count("done") == 2


def test_a_file_and_options_on_top(answer, tmp_path):
    (tmp_path / "sweep.toml").write_text(
        'case = "bounce"\nengines = "good"\n[over]\nsteps = [20]\n'
    )
    record = answer("sweep", "sweep.toml", "--over", "restitution=0.2,0.4")
    assert [row["restitution"] for row in record["rows"]] == [0.2, 0.4]


def test_measured_points_join_the_figure(harness, tmp_path):
    (tmp_path / "points.csv").write_text("restitution,measured_restitution\n0.5,0.52\n")
    harness(*WORDS, "--quantity", "restitution", "--reference", "points.csv", "--output", "mine")
    assert "points.csv" in (tmp_path / "mine" / "figure.svg").read_text()


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["bounce"], ["--over", "must be given"]),
        (["bounce", "--over", "steps=a"], ["--over steps=a", "'a'"]),
        (["bounce", "--over", "steps=1:2"], ["--over steps=1:2", "ranges as"]),
        (["bounce", "--over", "steps"], ["--over 'steps'", "NAME=VALUE"]),
        (["nix", "--over", "steps=20"], ["case 'nix'", "bounce, wrong"]),
        (["no.toml"], ["no.toml", "No such file"]),
        (["bad.toml"], ["bad.toml", "--over colour=1", "no such parameter"]),
        (["bounce", "--over", "steps=20", "--engines", "nix"], ["--engines 'nix'", "exact"]),
        (["bounce", "--over", "steps=20", "--reference", "no.csv"], ["--reference no.csv"]),
        (["bounce", "--over", "steps=20", "--output", "bad.toml"], ["--output bad.toml", "file"]),
    ],
)
def test_bad_input_is_status_2_and_names_option_value_and_allowed(harness, tmp_path, words, parts):
    (tmp_path / "bad.toml").write_text('case = "bounce"\n[over]\ncolour = 1\n')
    text = harness("sweep", *words, status=2).err
    assert len(text.splitlines()) <= 2
    for part in parts:
        assert part in text
    assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]
