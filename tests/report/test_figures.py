"""Figures as files, text of numbers; films: their discs, and what is refused beforehand."""

import doctest
import math
from dataclasses import replace
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from harness.errors import RequestError
from harness.report import content, figures
from harness.report.content import Discs, Drawing, value_text
from harness.report.page import draw
from tests.report.conftest import convergence


def test_examples_of_docstrings_hold():
    assert [doctest.testmod(module).failed for module in (content, figures)] == [0, 0]


@pytest.mark.parametrize(
    ("value", "uncertainty", "unit", "expected"),
    [
        (10.2069, 0.0013, "deg", "10.2069 ± 0.0013 deg"),  # two digits after a 1
        (1234.5, 20.0, "N", "1234 ± 20 N"),
        (2.0, 1e-20, "s", "2 s"),  # round-off
        (0.5, math.nan, "1", "0.5"),
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
    assert words.count("LAMMPS") == 1  # one legend below
    assert "http" not in first.svg.replace("http://www.w3.org/", "")
    assert first.png.startswith(b"\x89PNG")


# ---- films

TIME = np.linspace(0.0, 0.02, 40)
FALL = Discs(
    "a grain falls", TIME,
    x=np.tile([0.0, 0.03], (40, 1)),
    y=0.05 - 0.5 * 9.81 * TIME[:, None] ** 2 * np.ones(2),
    radius=np.array([0.005, 0.004]),
    fixed=np.array([[0.0, 0.0, 0.01]]),
    lines=np.array([[[-0.02, -0.01], [0.05, -0.01]]]),
)  # fmt: skip


def test_samples_are_nearest_to_equal_times_and_none_is_invented():
    time = np.array([0.0, 0.1, 0.2, 0.9, 1.0])
    assert figures.film_samples(time, 3).tolist() == [0, 2, 4]
    assert figures.film_samples(time, 100).tolist() == [0, 2, 3, 4]
    assert figures.film_samples(time[:1], 100).tolist() == [0]


def test_discs_have_places_radii_and_colours_of_the_sample():
    radius = np.tile(FALL.radius, (40, 1)) * np.linspace(1.0, 0.5, 40)[:, None]
    film = replace(FALL, radius=radius, value=FALL.y, value_label="height (m)")
    figure, show = figures.disc_figure(film)
    (moving,) = figure.axes[0].collections
    first = moving.to_rgba(moving.get_array())
    show(20)
    np.testing.assert_allclose(moving.get_offsets()[1:, 1], FALL.y[20])
    np.testing.assert_allclose(moving.get_widths()[1:], 2.0 * radius[20])
    assert (moving.to_rgba(moving.get_array()) != first).any()


def test_a_gif_has_the_frames_and_nothing_else_is_left(tmp_path):
    figures.write_film(FALL, tmp_path / "a.gif", frames=2)
    with Image.open(tmp_path / "a.gif") as gif:
        assert gif.n_frames == 2
    assert [path.name for path in tmp_path.iterdir()] == ["a.gif"]


@pytest.mark.parametrize(
    ("name", "frames", "reason"),
    [
        ("none/a.gif", 9, "there is no folder"),
        ("a.gif", 1, "from 2 to"),
        ("a.gif", figures.MOST_FRAMES + 1, f"{figures.MOST_FRAMES + 1} frames"),
        ("folder.gif", 9, "is not a file"),
        ("a.mp4", 9, r"ffmpeg, which is not on the path.*\.gif"),
    ],
)
def test_a_film_that_cannot_be_written_is_refused(tmp_path, monkeypatch, name, frames, reason):
    (tmp_path / "folder.gif").mkdir()
    monkeypatch.setitem(mpl.rcParams, "animation.ffmpeg_path", str(tmp_path / "no-ffmpeg"))
    with pytest.raises(RequestError, match=reason) as error:
        figures.check_film(tmp_path / name, frames)
    assert str(error.value).startswith(f"--film {tmp_path / name}: ")


def test_an_ffmpeg_that_fails_leaves_the_older_film(tmp_path, monkeypatch, script_file):
    program = script_file("cat > /dev/null\necho no such codec >&2\nexit 3\n", "ffmpeg")
    monkeypatch.setitem(mpl.rcParams, "animation.ffmpeg_path", program)
    (tmp_path / "a.mp4").write_text("an older film")
    with pytest.raises(RequestError, match="ffmpeg failed with 3 no such codec"):
        figures.write_film(FALL, tmp_path / "a.mp4", frames=2)
    assert (tmp_path / "a.mp4").read_text() == "an older film"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mp4", "ffmpeg"]
