"""Figures as files, and text of numbers."""

import doctest
import math
from xml.etree import ElementTree

import numpy as np
import pytest

from harness.report import content, figures
from harness.report.content import Drawing, value_text
from harness.report.figures import MARKERS, axis, label, legend_below, panels
from harness.report.page import draw


def convergence():
    figure = panels(1, 2)
    steps = np.logspace(-5, -2, 7)
    for axes in figure.axes:
        axes.loglog(steps, steps, MARKERS[0], label="LAMMPS")
        label(axes, axis("time step", "s"), axis("error", "1"), "first order")
    legend_below(figure)
    figure.text(0.5, 0.5, "theory: 10.20782 deg, 7.0 to 0.00012")
    return figure


@pytest.mark.parametrize("module", [content, figures])
def test_examples_of_docstrings_hold(module):
    assert doctest.testmod(module).failed == 0


@pytest.mark.parametrize(
    ("value", "uncertainty", "unit", "expected"),
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
def test_a_value_has_the_first_digit_of_its_uncertainty(value, uncertainty, unit, expected):
    assert value_text(value, uncertainty, unit) == expected


def test_a_figure_is_the_same_file_each_time_and_one_valid_svg_without_outside_addresses():
    drawing = Drawing("a", "A", "", convergence)
    first = draw(drawing, png=True)
    assert first.svg == draw(drawing).svg
    words = "".join(ElementTree.fromstring(first.svg).itertext())
    assert "theory: 10.20782 deg, 7.0 to 0.00012" in words  # numbers in text keep their digits
    assert words.count("LAMMPS") == 1  # one legend for both panels
    assert first.size == pytest.approx((2 * 4.2 * 72, 3.0 * 72))
    assert "http" not in first.svg.replace("http://www.w3.org/", "")
    assert first.png.startswith(b"\x89PNG")
