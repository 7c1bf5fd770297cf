from datetime import UTC, datetime, timedelta
from math import nan

import numpy as np
import pandas as pd
import pytest

from harness.comparison.verdicts import Kind, Tolerance, judge
from harness.errors import RequestError
from harness.observables.row import Row
from harness.store.history import History, RunEnd, RunStart
from harness.workflows import history

OLD, NEW = "2 Aug 2023 - Update 3", "22 Jul 2025 - Update 4"


def _angle(value, verdict):
    width = Tolerance("deg", 3e-4, 0.0, "that of a test")
    check = judge("incline: angle", Kind.ANALYTIC, value, 10.2, width, uncertainty=1e-4)
    assert check.verdict == verdict
    return check


@pytest.fixture
def file(tmp_path):
    """Three finished runs and one that was killed."""
    path = tmp_path / "history.sqlite"
    with History(path) as opened:

        def run(command, end, *quantities):
            number = opened.begin(RunStart(command, ["--x", "a b"], "0.1.0", "", "Linux"))
            if end is not None:
                opened.finish(number, end, quantities)

        run("verify", RunEnd(0, 9.0, "lammps", OLD, "in-process"), _angle(10.2, "pass"))
        run("tower", RunEnd(0, 0.1, "rk4", "0.1.0", "solver"), Row("ratio", 0.6, nan, ""))
        run("verify", RunEnd(1, 9.5, "lammps", NEW, "executable"), _angle(10.3, "fail"))
        run("verify", None)
    return path


@pytest.mark.parametrize(
    ("question", "runs"),
    [
        ({}, [4, 3, 2, 1]),
        ({"limit": 2}, [4, 3]),
        ({"command": "verify"}, [4, 3, 1]),
        ({"engine": "rk4"}, [2]),
        ({"engine_version": "22 Jul"}, [3]),
        ({"engine_version": "2"}, [3, 1]),
        ({"status": "unfinished"}, [4]),
        ({"status": 1}, [3]),
        ({"verdict": "fail"}, [3]),
        ({"verdict": "pass", "command": "verify"}, [1]),
        ({"since": "2001-01-01"}, [4, 3, 2, 1]),
        ({"since": datetime.now(UTC) + timedelta(days=1)}, []),
    ],
)
def test_what_is_looked_for_is_found_newest_first(file, question, runs):
    assert [row["run"] for row in history(file=file, **question).runs] == runs


@pytest.mark.parametrize(
    ("question", "values"),
    [
        ({"quantity": "incline*"}, [10.3, 10.2]),
        ({"quantity": "*"}, [10.3, 0.6, 10.2]),
        ({"quantity": "*", "verdict": "pass"}, [10.2]),
        ({"quantity": "ratio", "command": "verify"}, []),
    ],
)
def test_quantities_that_fit_a_pattern(file, question, values):
    found = history(file=file, **question)
    assert [row["value"] for row in found.rows] == values
    assert found.rows == found.quantities


def test_a_quantity_that_was_never_recorded_names_those_near_it(file):
    with pytest.raises(
        RequestError, match=r"no such quantity was recorded; near it: 'incline: ang"
    ):
        history(file=file, quantity="angle")
    with pytest.raises(RequestError, match=r"near it: 'ratio'"):
        history(file=file, quantity="ratoi")


@pytest.mark.parametrize(
    ("question", "said"),
    [
        ({"since": "yesterday"}, "--since 'yesterday': must be a date or time"),
        ({"verdict": "good"}, "--verdict 'good': must be one of pass, fail"),
        ({"status": "killed"}, "--status 'killed': must be an exit status"),
        ({"status": -1}, "--status -1: must be"),
        ({"limit": 0}, "--limit 0: must be at least 1"),
    ],
)
def test_bad_requests(file, question, said):
    with pytest.raises(RequestError, match=said):
        history(file=file, **question)


def test_without_a_history_the_answer_is_empty_and_none_is_made(tmp_path):
    path = tmp_path / "none.sqlite"
    assert history(file=path).runs == ()
    assert history(file=path, quantity="*").quantities == ()
    assert history(file=path).to_frame().empty
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    path = tmp_path / "history.sqlite"
    path.write_text("no database" * 100)
    with pytest.raises(RequestError, match=r"history\.sqlite: is not a database"):
        history(file=path)


@pytest.mark.parametrize("quantity", [None, "*"])
def test_every_column_of_the_frame_has_one_type(file, quantity):
    frame = history(file=file, quantity=quantity).to_frame()
    assert not any(kind == np.dtype(object) for kind in frame.dtypes)
    assert isinstance(frame["started"].dtype, pd.DatetimeTZDtype)
    assert str(frame["status"].dtype) == "Int64"
    assert frame["options"].iloc[0] == "--x 'a b'"
    empty = history(file=file, quantity=quantity, command="impulse").to_frame()
    assert list(empty.dtypes) == list(frame.dtypes)


def test_what_a_run_or_a_quantity_does_not_have_is_missing(file):
    runs = history(file=file).to_frame().set_index("run")
    assert pd.isna(runs.loc[4, "status"])
    assert pd.isna(runs.loc[4, "finished"])
    ratio = history(file=file, quantity="ratio").to_frame().iloc[0]
    assert np.isnan(ratio["uncertainty"])
    assert ratio["value"] == 0.6
