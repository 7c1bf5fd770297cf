"""Plots as SVG: points are where their values are, words are readable, nothing is not finite."""

import math
import re
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from harness.report.gallery import HEIGHT, LEFT, RIGHT, TOP, WIDTH, svg
from harness.report.sections import Line, Plot

X = np.linspace(0.0, 10.0, 11)


def plot(*lines, logarithmic=False):
    return Plot("Force", "over <time>", "time (s)", "force (N)", lines, logarithmic)


def places(text, number=0):
    return [
        tuple(map(float, pair.split(",")))
        for pair in re.findall(r'<polyline points="([^"]+)"', text)[number].split()
    ]


def test_a_straight_line_is_straight_and_fills_the_frame():
    found = places(svg(plot(Line("a", X, 3.0 * X - 7.0))))
    (x0, y0), (x1, y1) = found[0], found[-1]
    assert LEFT < x0 < x1 < WIDTH - RIGHT
    assert TOP < y1 < y0 < HEIGHT
    slopes = [(y - y0) / (x - x0) for x, y in found[1:]]
    assert slopes == pytest.approx([slopes[-1]] * 10, rel=0.02)


def test_powers_are_straight_on_logarithmic_axes_and_what_is_not_positive_is_left_out():
    h = np.array([1.0, 10.0, 100.0, 1000.0])
    found = svg(plot(Line("a", h, h**-2), Line("zero", h, 0.0 * h), logarithmic=True))
    (x0, y0), *others = places(found)
    slopes = [(y - y0) / (x - x0) for x, y in others]
    assert slopes == pytest.approx([slopes[0]] * 3, rel=0.02)
    assert found.count("<polyline") == 1
    assert ">1e-6<" in found
    assert "zero" not in found


def test_ticks_are_where_their_words_say():
    found = svg(plot(Line("a", X, X)))
    ticks = re.findall(r'<text x="([\d.]+)" y="[\d.]+" text-anchor="middle">([\d.]+)<', found)
    line = dict(zip(X, (x for x, _ in places(found)), strict=True))
    assert len(ticks) >= 4
    for place, word in ticks:
        assert float(place) == pytest.approx(line[float(word)], abs=0.1)


def test_a_gap_interrupts_a_line_and_a_constant_has_an_axis():
    y = np.where(X == 5.0, math.nan, 2.0)
    found = svg(plot(Line("a", X, y), Line("b", X, y, marked=True)))
    assert [len(places(found, n)) for n in (0, 1)] == [5, 5]
    assert found.count("<circle") == 10 + 1  # one in the legend
    assert "nan" not in found


def test_nothing_finite_is_no_picture_and_names_are_escaped():
    assert svg(plot(Line("a", X, X * math.nan))) == ""
    assert svg(plot()) == ""
    found = svg(plot(Line("<b>", X, X)))
    assert "<b>" not in found
    Xml.fromstring(f"<p>{found}</p>")
