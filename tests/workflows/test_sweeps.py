"""Sweeps: every combination a row, the cache as memory, and folders of one sweep each."""

import pandas as pd
import pytest

from harness.engines.registry import open_engine
from harness.errors import EngineMissingError, RequestError
from harness.workflows import sweep
from harness.workflows.settings import read_points, request_in, values_of
from harness.workflows.sweeps import plan
from tests.workflows import doubles

pytestmark = pytest.mark.usefixtures("registered")


def swept(over, engines="good", **more):
    return sweep("bounce", over, engines=engines, **{"open_engine": open_engine, **more})


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1,2,5", ["1", "2", "5"]),
        ("9:11:5", ["9", "9.5", "10", "10.5", "11"]),
        ("1e5:1e7:log3", ["100000", "1000000", "10000000"]),
        ("1,0.1:0.3:3,1", ["1", "0.1", "0.2", "0.3"]),
    ],
)
def test_the_values_of_a_text(text, values):
    assert values_of("angle", text) == values


@pytest.mark.parametrize("text", ["1,", "1:2", "1:2:x", "a:2:3", "0:1:log3", "1:2:1", "1:inf:3",
                                  "-1e308:1e308:3"])  # fmt: skip
def test_bad_values_are_refused_with_the_option(text):
    with pytest.raises(RequestError, match=f"--over angle={text}"):
        values_of("angle", text)


def test_a_failed_run_is_a_row_and_so_is_one_that_is_refused():
    frame = swept({"steps": "100,200"}, "good,dying,refusing").to_frame().set_index("engine")
    assert set(frame.loc["dying", "status"]) == {"failed"}
    assert set(frame.loc["dying", "reason"]) == {"signal SIGSEGV"}
    assert set(frame.loc["refusing", "status"]) == {"not tested"}
    assert set(frame.loc["good", "status"]) == {"done"}


@pytest.mark.parametrize(
    ("call", "engine", "returned"),
    [("measure", "good", lambda *_: None), ("solve", "exact", lambda *_: 1 / 0)],
)
def test_a_case_that_raises_or_returns_nothing_is_a_failed_row(monkeypatch, call, engine, returned):
    monkeypatch.setattr(doubles.BounceCase, call, returned)
    (row,) = swept({"steps": "100"}, engine).rows
    assert row["status"] == "failed"
    assert "Error: " in row["reason"]


def test_values_that_the_case_refuses_together_are_a_row():
    result = swept({"law.tangential": "none,linear_nohistory"})
    assert [row["status"] for row in result.rows] == ["done", "refused"]
    assert "needs a damping" in result.rows[1]["reason"]


def test_a_run_that_the_case_refuses_is_a_row_unless_it_refuses_all(monkeypatch):
    def job(case, parameters):
        if parameters.steps == 100:
            raise RequestError("it takes no steps")
        return whole(case, parameters)

    whole = doubles.BounceCase.job
    monkeypatch.setattr(doubles.BounceCase, "job", job)
    planned = plan("bounce", {"steps": "100,200"}, engines="good")
    assert planned.seconds() > 0.0
    assert [row["status"] for row in swept({"steps": "100,200"}).rows] == ["not tested", "done"]
    with pytest.raises(RequestError, match="it takes no steps"):
        plan("bounce", {"steps": "100"}, engines="good").seconds()


def test_a_search_is_a_row_with_its_uncertainty():
    (row,) = swept({"restitution": 0.5}, quantities="softest").rows
    assert row["softest"] == 1e4
    assert "uncertainty_softest" in row
    assert "stiffness" not in row


def test_an_engine_of_all_may_be_missing_and_a_named_one_not():
    result = swept({"steps": "100"}, "all")
    assert result.missing == {"missing": "missing: no program"}
    with pytest.raises(EngineMissingError):
        swept({"steps": "100"}, "missing")


def test_all_engines_may_be_missing(monkeypatch, tmp_path):
    alone = {"missing": doubles.ENGINES["missing"]}
    monkeypatch.setattr("harness.engines.registry.ENGINES", alone)
    monkeypatch.setattr(doubles.BounceCase, "solvers", ())
    result = swept({"steps": "100"}, "all", output=str(tmp_path / "out"))
    assert (result.rows, [*result.missing]) == ([], ["missing"])
    assert not (tmp_path / "out" / "figure.svg").exists()


def test_a_file_has_tables_of_grids(tmp_path):
    file = tmp_path / "sweep.toml"
    file.write_text('case = "bounce"\nquantity = ["time_s"]\n[set]\nrestitution = 0.5\n'
                    '[[over]]\nsteps = [10, 20]\n[[over]]\nlaw.clipped = true\n')  # fmt: skip
    request = request_in(file)
    assert request.over == ({"steps": "10,20"}, {"law.clipped": "True"})
    assert (request.set, request.quantity) == ({"restitution": "0.5"}, "time_s")
    assert len(plan(str(file)).points) == 3
    file.write_text('case = "bounce"\n[[over]]\nsteps = [100, 200]\n[[over]]\nsteps = [200, 300]')
    assert [row["steps"] for row in plan(str(file)).rows] == [100, 200, 300]


def test_committed_sweeps_can_be_read(inputs):
    for file in (inputs / "sweeps").glob("*.toml"):
        assert request_in(file).swept


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("case = 3", "case = 3: must be a valid string"),
        ("[over]\nsteps = 1", "case: must be given"),
        ("colour = 'red'\ncase = 'bounce'", "colour: no such parameter"),
        ("case = 'bounce'\nover = 3", "over = 3: must be a table"),
        ("case = ", "is not TOML"),
        ("a = " + "[" * 2000, "nested too deep|is not TOML"),
    ],
)
def test_a_file_that_is_not_sound_is_named(tmp_path, text, words):
    file = tmp_path / "bad.toml"
    file.write_text(text)
    with pytest.raises(RequestError, match=f"bad.toml: .*({words})"):
        request_in(file)


def test_a_sweep_leaves_table_and_figure_in_a_folder_that_no_other_may_have(tmp_path):
    over, mine = {"steps": "100,200"}, tmp_path / "mine"
    swept(over, output=mine)
    assert {path.name for path in mine.iterdir()} == {
        "rows.csv", "figure.svg", "figure.png", "sweep.json"}  # fmt: skip
    with pytest.raises(RequestError, match="has another sweep"):
        swept(over, output=mine, quantities="time_s")
    (tmp_path / "letter.txt").touch()
    with pytest.raises(RequestError, match="holds files of no sweep"):
        swept(over, output=tmp_path)


def test_where_nothing_is_measured_the_figure_of_an_earlier_time_goes(tmp_path):
    swept({"steps": "100"}, "dying", output=tmp_path)
    (tmp_path / "figure.svg").touch()
    swept({"steps": "100"}, "dying", output=tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"sweep.json", "rows.csv"}


def test_a_folder_is_taken_from_the_first_run_on(tmp_path):
    def opened(name):
        with pytest.raises(RequestError, match="has another sweep"):
            swept({"steps": "300"}, output=tmp_path)
        return open_engine(name)

    swept({"steps": "100"}, output=tmp_path, open_engine=opened)
    assert pd.read_csv(tmp_path / "rows.csv")["steps"].tolist() == [100]


def test_the_figure_shows_the_first_quantity_and_the_users_points(tmp_path):
    file = tmp_path / "measured.csv"
    file.write_text("restitution,measured_restitution,uncertainty_restitution\n0.5,0.52,0.01\n")
    errors = ("uncertainty_1", "uncertainty_restitution")
    points = read_points(file, "restitution", "measured_restitution", errors)
    assert points.uncertainty == [0.01]
    result = swept({"restitution": "0.2,0.8", "steps": "100,200"})
    (axes,) = result.figure(points).axes
    assert axes.get_ylabel() == "measured_restitution"
    labels = axes.get_legend_handles_labels()[1]
    assert "measured.csv" in labels
    assert sum("steps" in label for label in labels) == 2
    assert swept({"steps": "100"}, "dying").figure() is None
    (axes,) = swept({"steps": "100,200"}, quantities="time_s").figure().axes
    assert "a clock" in axes.get_legend_handles_labels()[1]  # that gives the exact values


def test_the_figure_shows_runs_without_the_second_parameter():
    result = swept({"steps": "100,200", "restitution": "0.5,0.6"})
    for row in result.rows[::2]:
        row["restitution"] = None
    labels = [text.get_text() for text in result.draw().axes[0].get_legend().get_texts()]
    assert [label.partition(", ")[2] for label in labels[-2:]] == [
        "restitution = none", "restitution = 0.6"]  # fmt: skip


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"a,b\n1,2\n", "has no column 'x', but a, b"),
        (b"x,y\n1,two\n", "row 2: y = 'two': must be a number"),
        (b"x,y\n1,2\n1,inf\n", "row 3: y = 'inf': must be a number"),
        (b"x,y\n", "must have rows"),
        (b"x,y\n1,\xff\n", "is no CSV table"),
        (b"x,y,e\n1,2,-1\n", "whose errors are not negative"),
    ],
)
def test_bad_points_are_refused_with_file_and_row(tmp_path, content, words):
    file = tmp_path / "points.csv"
    file.write_bytes(content)
    with pytest.raises(RequestError, match=f"--reference .*points.csv.*{words}"):
        read_points(file, "x", "y", ["e"])
