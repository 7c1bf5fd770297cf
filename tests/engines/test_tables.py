"""Outputs of runs, and their tables: CSV by its header, dumps by their columns."""

from pathlib import Path

import numpy as np
import pytest

from harness.cases.drop import TEMPLATE
from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output, Provenance, finished, read_csv, read_dump, results_in
from harness.errors import EngineNaNError, EngineOutputError

RECORDED = Path(__file__).parent / "liggghts" / "recorded"
LOG = "RESULT a = 1\nRESULT b = x\nRESULT c = nan\nRESULT d = 1\nRESULT d = 2\nRESULT row = 1 2\n"
SERIES = {"time_s": np.array([0.0, 1.0]), "x_m": np.array([1.0, np.nan]), "back": np.ones(2)}
OUTPUT = Output(results_in(LOG), Provenance("it", "1"), {"series": SERIES})


def test_results_by_name():
    assert OUTPUT.number("a") == 1.0
    assert OUTPUT.rows("row", 2).tolist() == [[1.0, 2.0]]
    OUTPUT.check_numbers({"a": 1.0 + 1e-13, "missing": 3.0})


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: OUTPUT.text("e"), EngineOutputError, r"incomplete result \('e'\)"),
        (lambda: OUTPUT.text("d"), EngineOutputError, "two results 'd': 1 and 2"),
        (lambda: OUTPUT.number("b"), EngineOutputError, "incomplete result"),
        (lambda: OUTPUT.number("c"), EngineNaNError, "c = nan"),
        (lambda: OUTPUT.rows("row", 3), EngineOutputError, "incomplete result"),
        (lambda: OUTPUT.check_numbers({"a": 1.1}), EngineOutputError, "a = 1, where 1.1"),
        (lambda: OUTPUT.table(["y_m"]), EngineOutputError, "no table with y_m: .* has time_s, x_m"),
        (lambda: OUTPUT.table(["time_s"], 3), EngineOutputError, "2 rows of a series of 3"),
        (lambda: OUTPUT.table(["x_m"]), EngineNaNError, "not numbers"),
    ],
)
def test_what_is_missing_or_no_number_is_an_error(call, error, words):
    with pytest.raises(error, match=words):
        call()


def test_an_echo_of_the_last_line_is_no_end():
    assert finished("x\nRESULT verdict = finished\n")
    assert not finished(Lammps.script(TEMPLATE).text)


def dump(*frames, columns="id x vx fx"):
    """Return a dump of frames of rows, at steps 0, 5, ..."""
    text = ""
    for number, rows in enumerate(frames):
        text += f"ITEM: TIMESTEP\n{5 * number}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n"
        text += f"ITEM: BOX BOUNDS ss pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS {columns} \n"
        text += "".join(" ".join(map(repr, row)) + " \n" for row in rows)
    return text


def test_columns_of_a_csv_have_the_names_of_its_header():
    table = read_csv('# "time_s", x_m\n0,1.5\n0.1,1e-300\n', "it")
    assert {name: column.tolist() for name, column in table.items()} == {
        "time_s": [0.0, 0.1], "x_m": [1.5, 1e-300]
    }  # fmt: skip


def test_columns_of_particles_are_one_in_the_order_of_their_numbers():
    table = read_csv("time_s,x_m[2],x_m[1],x_m[3]\n0,2,1,10\n", "it")
    assert table["x_m"].tolist() == [[1.0, 2.0, 10.0]]
    with pytest.raises(EngineOutputError, match="it left a series that lacks columns of x_m"):
        read_csv("time_s,x_m[1],x_m[3]\n0,1,2\n", "it")


@pytest.mark.parametrize(
    "text", ["a,b\n", "a,b\n1,2", "a,b\n1,2\n3\n", "a,b\n1,2\n3,x\n", "a,b\n1,2,3\n"]
)
def test_a_csv_that_is_cut_or_damaged_is_bad_output(text):
    with pytest.raises(EngineOutputError, match=r"^it left"):
        read_csv(text, "it")


ROWS = "time_s,x_m\n0,1\n0.1,2\n0.1,2\n0.2,3\n"


def test_a_row_that_comes_again_is_one_and_another_of_its_time_is_an_error():
    assert read_csv(ROWS, "it")["time_s"].tolist() == [0.0, 0.1, 0.2]
    with pytest.raises(EngineOutputError, match=r"row 3 is of time_s = 0.1, .* and differs"):
        read_csv(ROWS.replace("2\n0.2", "2.1\n0.2"), "it")
    with pytest.raises(EngineOutputError, match=r"row 4 is of time_s = 0.05, the row before of"):
        read_csv(ROWS.replace("0.2", "0.05"), "it")
    with pytest.raises(EngineNaNError, match="not numbers"):
        read_csv(ROWS.replace("0.2", "nan"), "it")


def test_a_frame_that_comes_again_is_left_out_unless_it_differs():
    text = dump([(1, 10.0, 0.1, -1.0)], [(1, 11.0, 0.1, -1.0)])
    again = dump([], [(1, 12.0, 0.1, -2.0)], [(1, 13.0, 0.2, -2.0)]).partition("\n5\n")
    table = read_dump(text + "ITEM: TIMESTEP" + again[1] + again[2], "it")
    assert table["step"].tolist() == [0.0, 5.0, 10.0]
    assert table["x_m"].tolist() == [[10.0], [11.0], [13.0]]
    other = again[2].replace("12.0 0.1", "12.0 0.2")
    with pytest.raises(EngineOutputError, match=r"row 3 is of step = 5, .* and differs"):
        read_dump(text + "ITEM: TIMESTEP" + again[1] + other, "it")


def test_a_dump_is_one_table_sorted_by_id_with_units_in_its_names():
    first = [(2, 20.0, 0.2, -2.0), (1, 10.0, 0.1, -1.0), (3, 30.0, 0.3, -3.0)]
    second = [(1, 11.0, 0.1, -1.0), (3, 33.0, 0.3, -3.0), (2, 22.0, 0.2, -2.0)]
    table = read_dump(dump(first, second), "it")
    assert list(table) == ["step", "x_m", "vx_m_per_s", "fx_N"]
    assert table["step"].tolist() == [0.0, 5.0]
    assert table["x_m"].tolist() == [[10.0, 20.0, 30.0], [11.0, 22.0, 33.0]]
    assert table["fx_N"].tolist() == [[-1.0, -2.0, -3.0]] * 2


@pytest.mark.parametrize(
    "frames",
    [
        [[(1, 0.0, 0.0, 0.0)], [(2, 0.0, 0.0, 0.0)]],
        [[(1, 0.0, 0.0, "x")]],
        [[(1, 0.0, 0.0)]],
    ],
)
def test_a_dump_whose_particles_change_or_that_is_damaged_is_bad_output(frames):
    with pytest.raises(EngineOutputError, match=r"^it wrote a dump that cannot be read"):
        read_dump(dump(*frames), "it")


def test_any_cut_of_a_recorded_dump_is_seen():
    text = (RECORDED / "struck.dump").read_text(encoding="utf-8")
    samples = len(read_dump(text, "it")["step"])
    ends = np.cumsum([len(line) + 1 for line in text.splitlines()])
    block = len(ends) // samples
    for cut in {*range(0, len(text), 29)} - set(ends[block - 1 :: block].tolist()):
        with pytest.raises(EngineOutputError, match="dump"):
            read_dump(text[:cut], "it")
