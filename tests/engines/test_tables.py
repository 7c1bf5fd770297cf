"""Tables of scripts: CSV by its header, dumps of LAMMPS and LIGGGHTS by their columns."""

from pathlib import Path

import numpy as np
import pytest

from harness.engines.output import read_csv, read_dump
from harness.errors import EngineNaNError, EngineOutputError

RECORDED = Path(__file__).parent / "liggghts" / "recorded"


def dump(*frames, columns="id x vx fx"):
    """Return a dump of frames of rows, at steps 0, 5, ..."""
    text = ""
    for number, rows in enumerate(frames):
        text += f"ITEM: TIMESTEP\n{5 * number}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n"
        text += f"ITEM: BOX BOUNDS ss pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS {columns} \n"
        text += "".join(" ".join(map(repr, row)) + " \n" for row in rows)
    return text


def test_columns_of_a_csv_have_the_names_of_its_header():
    table = read_csv("time_s,x_m\n0,1.5\n0.1,1e-300\n", "it")
    assert list(table) == ["time_s", "x_m"]
    assert table["x_m"].tolist() == [1.5, 1e-300]
    assert read_csv('# "time_s", x_m\n0,2\n', "it")["x_m"].tolist() == [2.0]


def test_columns_of_particles_are_one_in_the_order_of_their_numbers():
    table = read_csv("time_s,x_m[2],x_m[1],x_m[10]\n0,2,1,10\n".replace("[10]", "[3]"), "it")
    assert table["x_m"].tolist() == [[1.0, 2.0, 10.0]]
    with pytest.raises(EngineOutputError, match="it left a series that lacks columns of x_m"):
        read_csv("time_s,x_m[1],x_m[3]\n0,1,2\n", "it")


@pytest.mark.parametrize(
    "text", ["", "a,b\n", "a,b\n1,2", "a,b\n1,2\n3\n", "a,b\n1,2\n3,x\n", "a,b\n1,2,3\n"]
)
def test_a_csv_that_is_cut_or_damaged_is_bad_output(text):
    with pytest.raises(EngineOutputError, match=r"^it left"):
        read_csv(text, "it")


def test_a_frame_that_comes_again_where_a_run_was_taken_up_is_left_out():
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
        [[(1, 0.0, 0.0, 0.0)], [(1, 0.0, 0.0, 0.0), (2, 0.0, 0.0, 0.0)]],
        [[(1, 0.0, 0.0, "x")]],
        [[(1, 0.0, 0.0)]],
    ],
)
def test_a_dump_whose_particles_change_or_that_is_damaged_is_bad_output(frames):
    with pytest.raises(EngineOutputError, match=r"^it wrote a dump that cannot be read"):
        read_dump(dump(*frames), "it")


def test_any_cut_of_a_recorded_dump_is_seen():
    text = (RECORDED / "struck.dump").read_text(encoding="utf-8")
    whole = read_dump(text, "it")
    samples = len(whole["step"])
    assert whole["x_m"].shape == (samples, 2)
    block = len(text.splitlines()) // samples
    ends = np.cumsum([len(line) + 1 for line in text.splitlines()])
    whole_frames = {int(end) for end in ends[block - 1 :: block]}
    for cut in range(0, len(text), 29):
        if cut not in whole_frames:
            with pytest.raises(EngineOutputError, match="dump"):
                read_dump(text[:cut], "it")


ROWS = "time_s,x_m\n0,1\n0.1,2\n0.1,2\n0.2,3\n"


def test_a_row_that_comes_again_is_one_and_another_of_its_time_is_an_error():
    table = read_csv(ROWS, "it", rising=True)
    assert table["time_s"].tolist() == [0.0, 0.1, 0.2]
    with pytest.raises(EngineOutputError, match=r"row 3 is of time_s = 0.1, .* and differs"):
        read_csv(ROWS.replace("2\n0.2", "2.1\n0.2"), "it", rising=True)
    with pytest.raises(EngineOutputError, match=r"row 4 is of time_s = 0.05, the row before of"):
        read_csv(ROWS.replace("0.2", "0.05"), "it", rising=True)
    with pytest.raises(EngineNaNError, match="not numbers"):
        read_csv(ROWS.replace("0.2", "nan"), "it", rising=True)
