import math
from dataclasses import replace

import pandas as pd
import pytest
from pydantic import Field, model_validator

from harness import __version__
from harness.cases.registry import all_cases
from harness.cli.sweep import PartialTable
from harness.engines.output import Output
from harness.errors import (
    EngineCrashError,
    EngineMissingError,
    EngineUndecidedError,
    RequestError,
)
from harness.observables.provenance import Observable
from harness.observables.reference import Points
from harness.store.cache import CachedEngine
from harness.store.entries import Entries
from harness.workflows import sweep
from harness.workflows.sweep_plan import (
    ROW,
    SweepRequest,
    column_of,
    drawn_columns,
    parameter_columns,
    plan,
    quantity_columns,
    request_in,
    values_of,
    with_options,
)
from harness.workflows.sweep_run import Runner, held_sweep, run_plan
from tests.workflows import fakes

pytestmark = pytest.mark.usefixtures("registered")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1,2,5", ["1", "2", "5"]),
        ("plastic, source", ["plastic", "source"]),
        ("9:11:5", ["9", "9.5", "10", "10.5", "11"]),
        ("0:0.3:4", ["0", "0.1", "0.2", "0.3"]),
        ("1e5:1e7:log3", ["100000", "1000000", "10000000"]),
        ("1,2:4:3,2", ["1", "2", "3", "4"]),
        ("4:2:3", ["4", "3", "2"]),
    ],
)
def test_values_are_lists_and_ranges(text, values):
    assert values_of("x", text) == values


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1:2", "must be values as"),
        ("a:2:3", "must be values as"),
        ("1:inf:3", "must be values as"),
        ("1:2:200000", "from 2 to 100000 values"),
        ("0:2:log3", "must be greater than 0"),
        ("1,,2", "a value is empty"),
    ],
)
def test_other_values_are_refused_in_a_line(text, said):
    with pytest.raises(RequestError, match=said) as caught:
        values_of("x", text)
    assert str(caught.value).startswith("--over x=")
    assert "\n" not in str(caught.value)


def test_every_combination_is_a_flat_row_in_every_engine():
    found = sweep("line", {"slope": [1, 2], "end.x": "3:5:2"}, engines="toy,pencil")
    frame = found.to_frame()
    assert isinstance(frame, pd.DataFrame)
    assert found.over == ("slope", "end.x_m")
    assert list(frame["engine"]) == ["toy"] * 4 + ["pencil"] * 4
    assert list(frame["slope"] * frame["end.x_m"]) == list(frame["y_m"])
    assert list(frame["engine_version"])[::4] == ["1", f"dem-harness {__version__}"]
    first = dict(found.rows[0])
    assert first.pop("wall_time_s") == 0.0
    assert first == {
        "engine": "toy",
        "engine_version": "1",
        "ranks": 1,
        "slope": 1.0,
        "count": 1,
        "end.x_m": 3.0,
        "end.limit_m": None,
        "y_m": 3.0,
        "twice_m": 6.0,
        "status": "done",
        "reason": "",
    }


def test_measured_points_stand_beside_what_was_swept():
    over = {"end.x": "3:5:2", "slope": "1,2"}
    assert drawn_columns(plan(SweepRequest("line", (over,), {}, "toy", "y"))) == (
        "end.x_m",
        "y_m",
        "uncertainty_m",
    )
    found = sweep("line", {"slope": [1, 2]}, engines="toy")
    figure = found.figure(points=Points("mine.csv", (1.5,), (4.0,), (0.25,)))
    runs, theory, *own = figure.axes[0].get_lines()
    assert runs.get_xydata().tolist() == [[1.0, 2.0], [2.0, 4.0]]
    x, y = theory.get_data()
    assert (len(x), x[0], x[-1]) == (81, 1.0, 2.0)
    assert list(y) == pytest.approx([2.0 * one for one in x])
    assert own[0].get_xydata().tolist() == [[1.5, 4.0]]
    (bars,) = figure.axes[0].containers[-1][2]
    assert bars.get_segments()[0].tolist() == [[1.5, 3.75], [1.5, 4.25]]


def test_what_is_expected_is_a_line_for_each_value_where_it_differs():
    found = sweep("line", {"slope": "1:1000:log3", "end.x": "1,2"}, engines="toy,pencil")
    figure = found.figure("y")
    dashed = [line for line in figure.axes[0].get_lines() if line.get_linestyle() == "--"]
    assert [line.get_ydata()[0] for line in dashed] == [1.0, 2.0]
    x = dashed[0].get_xdata()
    assert x[40] == pytest.approx(1000**0.5)  # evenly spaced in the logarithm
    # of whole numbers, and of words, at the points alone
    whole = sweep("line", {"count": "1,2,5"}, engines="toy").figure("y")
    assert whole.axes[0].get_lines()[1].get_xydata().tolist() == [[1, 6], [2, 6], [5, 6]]
    words = sweep("line", {"preset": "usual,steep"}, engines="toy").figure("y")
    assert list(words.axes[0].get_lines()[1].get_ydata()) == [6.0, 200.0]


def test_presets_are_swept_as_well():
    frame = sweep("line", {"preset": ["usual", "steep"]}, engines="toy").to_frame()
    assert list(frame["preset"]) == ["usual", "steep"]
    assert list(frame["slope"]) == [3.0, 100.0]


@pytest.mark.parametrize(
    ("over", "fixed", "engines", "said"),
    [
        ({}, {}, "toy", "--over: must be given"),
        ({"slop": "1,2"}, {}, "toy", "--over slop=1: slop: no such parameter"),
        ({"slope": "1,-2"}, {}, "toy", "--over slope=-2: slope = '-2': must be greater than 0"),
        ({"end.x": "1,2"}, {"slope": "-2"}, "toy", "^--set: slope = '-2': must be greater than 0"),
        ({"end.x": "1,2"}, {"preset": "flat"}, "toy", "^--set preset=flat: case 'line' has"),
        ({"slope": "1,2"}, {"slope": "3"}, "toy", "is set by --set slope=3 already"),
        ({"slope": "1,2"}, {}, "pen", "--engines 'pen' is not known: must be all, or"),
        ({"slope": "1,2"}, {}, ",", "names no engine"),
        ({"slope": "1:2:1000", "end.x": "1:2:1000"}, {}, "toy", "1000000 runs are asked for"),
    ],
)
def test_bad_requests_are_refused_before_anything_runs(over, fixed, engines, said, monkeypatch):
    monkeypatch.setattr(fakes.Toy, "run", lambda *_: pytest.fail("ran"))
    with pytest.raises(RequestError, match=said) as caught:
        sweep("line", over, fixed=fixed, engines=engines)
    assert "\n" not in str(caught.value)


def test_a_run_that_fails_is_a_row_with_the_reason(monkeypatch):
    def one(self, values):
        if values["slope"] == 2.0:
            return EngineCrashError("signal SIGSEGV")
        text = "many" if values["slope"] == 3.0 else "1"
        return Output((("y", text),), self.identify())

    refused = {4.0: "too steep"}
    monkeypatch.setattr(fakes.Toy, "_one", one)
    monkeypatch.setattr(fakes.Toy, "refuses", lambda _, job: refused.get(job.values["slope"], ""))
    found = sweep("line", {"slope": "1:4:4"}, engines="toy")
    rows = [(row["status"], row["reason"], row["y_m"]) for row in found.rows]
    assert rows[0] == ("done", "", 1.0)
    assert rows[1] == ("failed", "signal SIGSEGV", None)
    assert rows[2][0] == "failed"
    assert "y = 'many'" in rows[2][1]
    assert rows[3] == ("not tested", "too steep", None)
    assert (found.count("done"), found.count("failed"), found.count("not tested")) == (1, 2, 1)
    assert math.isnan(found.to_frame()["y_m"][1])


class Absent(fakes.Toy):
    name = "missing"

    def run(self, jobs):  # noqa: ARG002
        raise EngineMissingError("no such program")


def test_a_named_engine_that_is_missing_is_an_error_and_one_of_all_is_left_out(monkeypatch):
    monkeypatch.setattr(fakes.Missing, "run", Absent.run)
    with pytest.raises(EngineMissingError, match="no such program"):
        sweep("line", {"slope": "1,2"}, engines="missing")
    monkeypatch.setattr(fakes.Confused, "states", lambda _: False)
    found = sweep("line", {"slope": "1,2"}, engines="all")
    assert dict(found.missing) == {"missing": "no such program"}
    by_engine = {row["engine"]: row["status"] for row in found.rows}
    assert by_engine["toy"] == by_engine["pencil"] == "done"
    assert by_engine["dead"] == "failed"  # it is here, and died


class Keyed(fakes.Toy):
    """Counts its runs and their time, and can be told by its content."""

    def __init__(self):
        self.slopes, self.seconds = [], set()

    def fingerprint(self):
        return {"engine": "keyed"}

    def run(self, jobs):
        self.slopes += [job.values["slope"] for job in jobs]
        self.seconds |= {job.seconds for job in jobs}
        return super().run(jobs)


def test_what_was_run_before_and_the_same_twice_is_not_run_again(tmp_path):
    inner = Keyed()
    engine = CachedEngine(inner, Entries(tmp_path))
    runner = Runner(lambda _: engine, Entries(tmp_path))
    sweep("line", {"slope": "1,2"}, engines="toy", runner=runner)
    again = sweep("line", {"slope": "1:3:3", "count": "1,2"}, engines="toy", runner=runner)
    # the job does not depend on the count
    assert inner.slopes == [1.0, 2.0, 3.0]
    assert inner.seconds == {2.0}  # what the case expects: a long run has more time
    assert list(again.to_frame()["y_m"]) == [2.0, 2.0, 4.0, 4.0, 6.0, 6.0]


def test_solvers_are_asked_once(tmp_path, monkeypatch):
    runner = Runner(entries=Entries(tmp_path))
    first = sweep("line", {"slope": "1,2"}, engines="pencil", runner=runner)
    monkeypatch.setattr(fakes.Line, "solve", lambda *_: pytest.fail("solved again"))
    again = sweep("line", {"slope": "1,2"}, engines="pencil", runner=runner)
    assert first.rows == again.rows


def test_a_file_says_what_is_swept_and_options_change_it(tmp_path):
    file = tmp_path / "s.toml"
    file.write_text(
        'case = "line"\nengines = ["toy", "other"]\n[set]\ncount = 2\n'
        '[over]\nslope = [1, 2]\nend.x = "1:2:2"\n',
        encoding="utf-8",
    )
    asked = request_in(file)
    grid = {"slope": "1,2", "end.x": "1:2:2"}
    assert asked == SweepRequest("line", (grid,), {"count": "2"}, "toy,other")
    changed = with_options(asked, {"slope": "5"}, {}, "", "y")
    assert changed.grids == ({"slope": "5", "end.x": "1:2:2"},)
    assert (changed.fixed, changed.engines, changed.quantity) == ({"count": "2"}, "toy,other", "y")


def test_grids_of_a_file_are_run_together_and_what_they_share_once(tmp_path):
    file = tmp_path / "s.toml"
    file.write_text(
        'case = "line"\nengines = "toy"\nover = [{slope = [1, 2], count = [1, 2]},\n'
        "{slope = [2, 3], count = 2}, {slope = 2, end.x = 5}]\n",
        encoding="utf-8",
    )
    asked = request_in(file)
    assert asked.over == ("slope", "count", "end.x")
    found = run_plan(plan(asked))
    rows = [(row["slope"], row["count"], row["end.x_m"], row["y_m"]) for row in found.rows]
    assert rows[:4] == [(1, 1, 2, 2), (1, 2, 2, 2), (2, 1, 2, 4), (2, 2, 2, 4)]
    assert rows[4:] == [(3, 2, 2, 6), (2, 1, 5, 10)]
    # of each slope and count the first is drawn
    lines = found.figure("y").axes[0].get_lines()
    assert [line.get_xydata().tolist() for line in lines if len(line.get_xdata()) < 81] == [
        [[1, 2], [2, 4]],
        [[1, 2], [2, 4], [3, 6]],
    ]
    whole = with_options(asked, {"slope": "4"}, {}, "", "")
    assert len(plan(whole).points) == 3
    # values that are not the same in all that is drawn stand in no title
    steep = {"preset": "steep", "count": "1"}
    mixed = run_plan(plan(replace(asked, grids=(*asked.grids, steep)))).figure("y")
    assert mixed.axes[0].get_title(loc="left") == "line, end.x = 2 m, TOY"
    file.write_text('case = "line"\nover = [{slope = 1}, {}]\n', encoding="utf-8")
    with pytest.raises(RequestError, match="--over: must be given"):
        plan(request_in(file))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("case = ", "is not TOML"),
        ("[over]\nslope = 1\n", "case: must be given"),
        ('case = "line"\nover = 3\n', r"over: must be a table \[over\]"),
        ('case = "line"\nover = [{slope = 1}, 3]\n', r"over: must be a table \[over\]"),
        ('case = "line"\nstiffness = 3\n', "'stiffness' is not known: must be one of case"),
        ("case = " + "[" * 100_000, "is nested too deep"),
        ("#" * 1_000_001, "is longer than 1000000 bytes"),
    ],
    ids=["no TOML", "no case", "no table", "no tables", "unknown", "deep", "long"],
)
def test_a_bad_file_is_named(tmp_path, text, said):
    file = tmp_path / "s.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(RequestError, match=said) as caught:
        request_in(file)
    assert str(file) in str(caught.value)


def test_two_sweeps_in_one_folder_are_refused(tmp_path):
    asked, other = (
        SweepRequest("line", ({"slope": "1"},), {}),
        SweepRequest("line", ({"slope": "2"},), {}),
    )
    with (
        held_sweep(tmp_path / "a", asked),
        pytest.raises(RequestError, match="another sweep runs in it"),
        held_sweep(tmp_path / "a", asked),
    ):
        pytest.fail("held twice")
    with held_sweep(tmp_path / "a", asked):  # the same goes on
        pass
    with (
        pytest.raises(RequestError, match="holds another sweep"),
        held_sweep(tmp_path / "a", other),
    ):
        pytest.fail("held for another")
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "thesis.tex").touch()
    with pytest.raises(RequestError, match="no sweep"), held_sweep(tmp_path / "b", asked):
        pytest.fail("held over a thesis")


@pytest.mark.parametrize(
    ("name", "unit", "key"),
    [
        ("stiffness", "N/m", "stiffness_N_per_m"),
        ("time_s", "s", "time_s"),
        ("impulse_Ns", "N s", "impulse_Ns"),
        ("gravity", "m/s2", "gravity_m_per_s2"),
        ("ratio", "1", "ratio"),
        ("discharge_rate_per_s", "1/s", "discharge_rate_per_s"),
        ("rate", "1/s", "rate_per_s"),
        ("wells", "", "wells"),
    ],
)
def test_keys_carry_their_units_once(name, unit, key):
    assert column_of(name, unit) == key


class Asking(fakes.LineParameters):
    """Has parameters of the names and columns of quantities."""

    twice: float = Field(0.5, description="[-] no ordinate")
    y_m: float = Field(7.0, description="[-] no ordinate either")


@pytest.fixture
def asking(monkeypatch):
    monkeypatch.setattr(fakes.Line, "parameters", Asking)
    monkeypatch.setattr(fakes.Line, "presets", {"usual": Asking()})
    more = (Observable("status", "1", "", "a number"), Observable("measured_twice", "m", "", ""))
    monkeypatch.setattr(fakes.Line, "quantities", (*fakes.Line.quantities, *more))
    kept = fakes.Line.read
    monkeypatch.setattr(
        fakes.Line,
        "read",
        lambda *words: {**kept(*words), "status": 1.5, "measured_twice": 2.5},
    )


@pytest.mark.usefixtures("asking")
def test_what_is_asked_for_and_what_is_measured_never_share_a_column():
    found = sweep("line", {"twice": [1, 2]}, engines="toy", quantities="twice")
    first = found.rows[0]
    assert (first["twice"], first["y_m"], first["status"]) == (1.0, 7.0, "done")
    measured = {name: first[name] for name in found.quantities}
    assert measured == {
        "measured_y_m": 6.0,
        "measured_measured_twice_m": 12.0,
        "measured_status": 1.5,
        "measured_twice_m": 2.5,
    }
    assert found.selected == ("measured_measured_twice_m",)
    assert list(found.to_frame()["twice"]) == [1.0, 2.0]
    (runs, *_) = found.figure().axes[0].get_lines()
    assert runs.get_xydata().tolist() == [[1.0, 12.0], [2.0, 12.0]]
    (runs, theory) = found.figure("y").axes[0].get_lines()
    assert set(runs.get_ydata()) == set(theory.get_ydata()) == {6.0}
    assert drawn_columns(plan(SweepRequest("line", ({"twice": "1"},), {}, "toy", "y"))) == (
        "twice",
        "measured_y_m",
        "uncertainty_m",
    )


def test_a_parameter_with_the_name_of_a_column_of_every_row_is_refused(monkeypatch):
    class Engined(fakes.LineParameters):
        engine: float = Field(1.0, description="[-] power")

    monkeypatch.setattr(fakes.Line, "parameters", Engined)
    with pytest.raises(RequestError, match="case 'line': parameter 'engine': is a column"):
        sweep("line", {"slope": "1"}, engines="toy")


@pytest.mark.parametrize("case", all_cases().values(), ids=lambda case: case.name)
def test_no_column_of_a_case_holds_two_things(case):
    for measuring in (case, *case.derived()):
        columns = list(quantity_columns(measuring).values())
        assert len(columns) == len(set(columns))
        for parameters in measuring.presets.values():
            assert not set(columns) & {*parameter_columns(parameters), *ROW}


def test_nothing_is_drawn_where_nothing_was_measured(monkeypatch):
    monkeypatch.setattr(fakes.Toy, "_one", lambda *_: EngineCrashError("dead"))
    assert sweep("line", {"slope": "1,2"}, engines="toy").figure() is None


class Strict(fakes.LineParameters):
    """Refuses some slopes beside some counts."""

    @model_validator(mode="after")
    def _together(self):
        if self.slope * self.count > 5.0:
            raise ValueError(f"slope = {self.slope:g}: is too steep for count = {self.count}")
        return self


@pytest.fixture
def strict(monkeypatch):
    monkeypatch.setattr(fakes.Line, "parameters", Strict)
    monkeypatch.setattr(fakes.Line, "presets", {"usual": Strict()})


@pytest.mark.usefixtures("strict")
def test_a_corner_that_is_refused_is_a_row_and_the_others_run():
    found = sweep("line", {"slope": "1,3", "count": "1,2"}, fixed={"end.x": "4"}, engines="toy")
    rows = [(row["slope"], row["count"], row["status"], row["y_m"]) for row in found.rows]
    assert rows == [
        (1, 1, "done", 4),
        (1, 2, "done", 4),
        (3, 1, "done", 12),
        (3, 2, "refused", None),
    ]
    last = found.rows[-1]
    assert last["reason"] == "slope = 3: is too steep for count = 2"
    assert last["end.x_m"] == 4
    assert list(last) == list(found.rows[0])
    assert found.to_json()["refused"] == 1
    assert "1 refused" in found.summary()["runs"]


@pytest.mark.usefixtures("strict")
def test_what_is_refused_in_a_second_grid_has_the_parameters_of_that_grid():
    grids = ({"slope": "1", "end.x": "4"}, {"slope": "3", "count": "1,2"}, {"slope": "9"})
    found = run_plan(plan(SweepRequest("line", grids, {}, "toy")))
    rows = [(row["slope"], row["count"], row["end.x_m"], row["status"]) for row in found.rows]
    assert rows[:3] == [(1, 1, 4, "done"), (3, 1, 2, "done"), (3, 2, 2, "refused")]
    assert rows[3] == (9, None, None, "refused")


@pytest.mark.usefixtures("strict")
def test_where_every_corner_is_refused_the_request_is():
    said = (
        r"^--over slope=6, count=1: slope = 6: is too steep for count = 1 \(so are all 2 points\)"
    )
    with pytest.raises(RequestError, match=said):
        sweep("line", {"slope": "6", "count": "1,2"}, engines="toy")
    # a value that is not allowed by itself is a slip of the pen
    with pytest.raises(RequestError, match=r"^--over slope=-2"):
        sweep("line", {"slope": "1,-2", "count": "1,2"}, engines="toy")


def test_a_run_that_is_undecided_keeps_what_it_measured(monkeypatch):
    def read(self, parameters, output, traits):  # noqa: ARG001
        y = output.number("y")
        if parameters.slope == 2.0:
            raise EngineUndecidedError("undecided: it never turned", {"y": y})
        return {"y": y, "twice": 2.0 * y}

    monkeypatch.setattr(fakes.Line, "read", read)
    found = sweep("line", {"slope": "1,2"}, engines="toy")
    one = found.rows[1]
    assert (one["status"], one["reason"]) == ("undecided", "undecided: it never turned")
    assert (one["y_m"], one["twice_m"], one["engine_version"], one["ranks"]) == (4.0, None, "1", 1)
    assert (found.count("done"), found.count("undecided"), found.count("failed")) == (1, 1, 0)


def test_a_sweep_that_runs_has_its_table_with_what_is_pending(tmp_path):
    file, seen = tmp_path / "rows.csv", []
    table = PartialTable(file, pause=0.0, share=1.0)

    def partial(rows):
        table.due = 0.0
        table(rows)
        seen.append(list(pd.read_csv(file)["status"]))

    chosen = plan(SweepRequest("line", ({"slope": "1:3:3"},), {}, "toy,pencil"))
    run_plan(chosen, Runner(), partial=partial)
    assert seen[0].count("pending") == 5
    assert seen[-1] == ["done"] * 6
    assert [one.count("pending") for one in seen] == sorted(
        (one.count("pending") for one in seen), reverse=True
    )
    assert [path.name for path in tmp_path.iterdir() if path.name[0] != "."] == ["rows.csv"]
