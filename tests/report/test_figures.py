"""Figures as files, their helpers, and text of numbers."""

import doctest
import math
from xml.etree import ElementTree

import numpy as np
import pytest

from harness.report import style, text
from harness.report.content import Drawing
from harness.report.figures import draw
from harness.report.style import MARKERS, axis, label, legend_below, panels
from harness.report.text import value_text


def convergence():
    figure = panels(1, 2)
    steps = np.logspace(-5, -2, 7)
    for axes in figure.axes:
        axes.loglog(steps, steps, MARKERS[0], label="LAMMPS")
        label(axes, axis("time step", "s"), axis("error", "1"), "first order")
    legend_below(figure)
    return figure


def drawing(name="convergence", draw=convergence):
    return Drawing(name, "Convergence", "First order.", draw)


@pytest.mark.parametrize("module", [style, text])
def test_examples_of_docstrings_hold(module):
    assert doctest.testmod(module).failed == 0


@pytest.mark.parametrize(
    ("value", "uncertainty", "unit", "shown"),
    [
        (10.2069, 0.00042, "deg", "10.2069 ± 0.0004 deg"),
        (10.2069, 0.0013, "deg", "10.2069 ± 0.0013 deg"),  # two digits after a 1
        (1234.5, 20.0, "N", "1234 ± 20 N"),
        (2.0, 1e-20, "s", "2 s"),  # round-off
        (0.5, math.nan, "1", "0.5"),
        (math.nan, 0.1, "m", "-"),
        (math.inf, 0.1, "m", "inf m"),
    ],
)
def test_a_value_is_written_to_the_first_digit_of_its_uncertainty(value, uncertainty, unit, shown):
    assert value_text(value, uncertainty, unit) == shown


def test_a_figure_is_the_same_file_each_time_and_one_valid_svg_without_outside_addresses():
    first, second = draw(drawing()), draw(drawing())
    assert first.svg == second.svg
    root = ElementTree.fromstring(first.svg)
    assert root.tag.endswith("svg")
    words = "".join(root.itertext())
    assert "10⁻³" in words
    assert words.count("LAMMPS") == 1  # one legend for both panels
    assert first.size == pytest.approx((2 * 4.2 * 72, 3.0 * 72))
    plain = first.svg.replace("http://www.w3.org/", "")
    assert "http" not in plain


def test_an_error_of_a_function_is_the_picture_s():
    def broken():
        raise ZeroDivisionError("no\nrows")

    assert draw(drawing(), png=True).png.startswith(b"\x89PNG")
    bad = draw(drawing("bad", broken))
    assert (bad.error, bad.svg) == ("ZeroDivisionError: no rows", "")


def test_text_in_a_compact_figure_keeps_its_digits():
    figure = panels(1, 1)
    figure.text(0.5, 0.5, "theory 10.20782 deg, 7.0 to 0.00012")
    assert "theory 10.20782 deg, 7.0 to 0.00012" in draw(drawing(draw=lambda: figure)).svg
