import pytest

from harness.errors import RequestError
from harness.observables.reference import (
    PEYNEAU_ROUX,
    parse_points,
    parse_reference,
)

HEAD = "h_over_d,theta_deg\n"


def test_points():
    found = parse_reference(HEAD + "2,10.5\n\n 18 , 6e0\n", "mine.csv")
    assert found.heights == (2.0, 18.0)
    assert found.angles_deg == (10.5, 6.0)
    assert found.name == "mine.csv"


def test_other_columns_order_quotes_and_line_ends_do_not_matter():
    found = parse_reference('"theta_deg",who,h_over_d\r\n7,"one, two",3\r\n', "mine.csv")
    assert (found.heights, found.angles_deg) == ((3.0,), (7.0,))


def test_the_published_angle():
    assert (PEYNEAU_ROUX.value, PEYNEAU_ROUX.uncertainty) == (5.76, 0.22)
    assert "2008" in PEYNEAU_ROUX.who


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "x.csv: is empty; a header h_over_d,theta_deg is expected"),
        ("\n \n", "x.csv: is empty; a header h_over_d,theta_deg is expected"),
        (HEAD, "x.csv: holds a header, but no points"),
        ("h_over_d,angle\n1,2\n", "x.csv, row 1: no column theta_deg; found h_over_d, angle"),
        ("1,2\n3,4\n", "x.csv, row 1: no column h_over_d and theta_deg; found 1, 2"),
        (
            "h_over_d;theta_deg\n1;2\n",
            "x.csv, row 1: columns are separated by semicolons, commas are expected",
        ),
        (
            "h_over_d\ttheta_deg\n1\t2\n",
            "x.csv, row 1: columns are separated by tabs, commas are expected",
        ),
        ("h_over_d,theta_deg,h_over_d\n1,2,3\n", "x.csv, row 1: 2 columns h_over_d, must be one"),
        (HEAD + "1,2\n3,abc\n", "x.csv, row 3: theta_deg = 'abc' is not a number"),
        (HEAD + "1,\n", "x.csv, row 2: theta_deg = '' is not a number"),
        (HEAD + "nan,2\n", "x.csv, row 2: h_over_d = nan must be finite and greater than 0"),
        (HEAD + "inf,2\n", "x.csv, row 2: h_over_d = inf must be finite and greater than 0"),
        (HEAD + "1,nan\n", "x.csv, row 2: theta_deg = nan must be at most 90 and greater than 0"),
        (HEAD + "-1,2\n", "x.csv, row 2: h_over_d = -1 must be finite and greater than 0"),
        (HEAD + "1,90.1\n", "x.csv, row 2: theta_deg = 90.1 must be at most 90 and greater than 0"),
        (HEAD + "\n1,-2\n", "x.csv, row 3: theta_deg = -2 must be at most 90 and greater than 0"),
        (HEAD + "1,5,3\n", "x.csv, row 2: 3 values, the header has 2"),
        (HEAD + "1\n", "x.csv, row 2: 1 values, the header has 2"),
        (HEAD + '"1,2\n', "x.csv, row 2: unexpected end of data"),
    ],
)
def test_bad_tables_are_one_line_with_file_and_row(text, said):
    with pytest.raises(RequestError) as refused:
        parse_reference(text, "x.csv")
    assert str(refused.value) == said


def test_points_of_any_two_columns_may_have_either_sign():
    found = parse_points("spin_ratio,who,angle_deg\n-0.5,one,5\n0.25,two,-1e1\n", "mine.csv",
                         "angle_deg", "spin_ratio")  # fmt: skip
    assert (found.name, found.x, found.y) == ("mine.csv", (5.0, -10.0), (-0.5, 0.25))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "x.csv: is empty; a header angle_deg,spin_ratio is expected"),
        ("angle,spin_ratio\n", "x.csv, row 1: no column angle_deg; found angle, spin_ratio"),
        ("angle_deg,spin_ratio\n5,inf\n", "x.csv, row 2: spin_ratio = inf must be finite"),
        ("angle_deg,spin_ratio\n5,\n", "x.csv, row 2: spin_ratio = '' is not a number"),
    ],
)
def test_points_that_cannot_be_read_are_one_line(text, said):
    with pytest.raises(RequestError) as refused:
        parse_points(text, "x.csv", "angle_deg", "spin_ratio")
    assert str(refused.value) == said


def test_a_third_column_gives_errors_of_0_or_more():
    text = "angle_deg,y_m,uncertainty_m\n1,2,0\n2,3,0.5\n"
    assert parse_points(text, "a.csv", "angle_deg", "y_m", "uncertainty_m").errors == (0.0, 0.5)
    assert parse_points(text, "a.csv", "angle_deg", "y_m").errors is None
    assert parse_points("x,y\n1,2\n", "a.csv", "x", "y", "uncertainty").errors is None
    with pytest.raises(RequestError, match="row 2: uncertainty_m = -1 must be finite and 0 or"):
        parse_points("a,b,uncertainty_m\n1,2,-1\n", "a.csv", "a", "b", "uncertainty_m")
