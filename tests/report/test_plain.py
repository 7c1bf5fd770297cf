"""Text of others in errors and tables: cut where it is long, no formula in a spreadsheet."""

import pandas as pd
import pytest

from harness.report.plain import csv_cell, shortened, write_csv


@pytest.mark.parametrize("text", ["=1+1", "+cmd", "-@SUM(A1)", "@x", "\t=1", "\r=1"])
def test_a_text_that_begins_as_a_formula_is_quoted(text):
    assert csv_cell(text) == f"'{text}"


@pytest.mark.parametrize("value", ["-1.5e-3", "+4", "-inf", "a=1", "22 Jul 2025", "", -2.0, None])
def test_numbers_and_other_texts_stay(value):
    assert csv_cell(value) is value


def test_a_table_keeps_its_numbers_and_quotes_a_version(tmp_path):
    frame = pd.DataFrame({"engine_version": ["=cmd()", "1"], "x_m": [-1.5, 2.0], "n": [-3, 4]})
    write_csv(frame, tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "engine_version,x_m,n\n'=cmd(),-1.5,-3\n1,2.0,4\n"
    assert frame["engine_version"][0] == "=cmd()"


def test_a_long_value_is_cut_and_what_is_allowed_stays():
    for value in ("x" * 100_000, "x " * 50_000):
        text = shortened(f"--case {value}: must be one of incline, tower")
        assert len(text) < 700
        assert text.endswith("must be one of incline, tower")
    path = f"--output /{'folder/' * 20}: is a file"
    assert shortened(path) == path
