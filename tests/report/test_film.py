from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from harness.errors import RequestError
from harness.report.film import MOST_FRAMES, Film, check_film


def picture(frame):
    """A black square on white that goes right, in a picture of odd size."""
    image = np.full((41, 61, 3), 255, dtype=np.uint8)
    image[10:20, 4 * frame : 4 * frame + 10] = 0
    return image


FILM = Film("A square <goes>", 9, 8, picture)


def ffmpeg(tmp_path, monkeypatch, text):
    program = tmp_path / "bin" / "ffmpeg"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\n{text}\n")
    program.chmod(0o755)
    monkeypatch.setitem(mpl.rcParams, "animation.ffmpeg_path", str(program))


def test_a_png_is_the_picture_that_is_shown_where_nothing_moves(tmp_path):
    replace(FILM, poster=3).save(tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        assert image.format == "PNG"
        assert (np.asarray(image.convert("RGB")) == picture(3)).all()
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize(
    ("name", "frames", "words"),
    [
        ("a.avi", 9, ".gif, .mp4, .png"),
        ("a", 9, ".gif, .mp4, .png"),
        ("none/a.gif", 9, "there is no folder"),
        ("a.gif", 1, "from 2 to"),
        ("a.gif", MOST_FRAMES + 1, f"{MOST_FRAMES + 1} frames"),
        ("folder.gif", 9, "is no file"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, name, frames, words):
    (tmp_path / "folder.gif").mkdir()
    with pytest.raises(RequestError, match=words) as told:
        check_film(tmp_path / name, frames, "--film")
    assert str(told.value).startswith("--film")


def test_without_ffmpeg_a_gif_is_offered(tmp_path, monkeypatch):
    monkeypatch.setitem(mpl.rcParams, "animation.ffmpeg_path", str(tmp_path / "no-ffmpeg"))
    with pytest.raises(RequestError, match=r"ffmpeg.*not on the path.*\.gif"):
        FILM.save(tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


def test_an_ffmpeg_that_fails_leaves_nothing(tmp_path, monkeypatch):
    ffmpeg(tmp_path, monkeypatch, "echo no such codec >&2; exit 3")
    (tmp_path / "a.mp4").write_text("an older film")
    with pytest.raises(RequestError, match="failed with 3: no such codec"):
        FILM.save(tmp_path / "a.mp4")
    assert (tmp_path / "a.mp4").read_text() == "an older film"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mp4", "bin"]
