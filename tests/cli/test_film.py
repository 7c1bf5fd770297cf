"""``--film`` of the commands: what it writes, and what it refuses before anything is run."""

import json

import pytest
from PIL import Image

from harness.cases.incline.report import InclineDisplay
from harness.engines import registry
from tests import engine_doubles as doubles


class WithoutPaths(doubles.Twin):
    """An engine that runs the incline and writes no path."""

    def refuses(self, job):
        return "its script writes no path" if job.sampled else super().refuses(job)

    def run(self, jobs):
        raise AssertionError(jobs)


@pytest.mark.parametrize(
    "words",
    [
        ("tower", "--height", "3", "--law", "overlap"),
        ("critical-angle", "--engine", "reference", "--stiffness", "1e5"),
        ("critical-angle", "--engine", "reference", "--film-angles", "9,12,13"),
    ],
)
def test_the_film_is_written_beside_the_answer(command, tmp_path, words):
    path = tmp_path / "a.gif"
    more = ("--json", "--film", str(path), "--frames", "12")
    said = command(*words, *more)
    assert f"--film: {path} is written" in said.err
    assert json.loads(said.out)
    with Image.open(path) as image:
        assert image.n_frames > 6
        assert image.size[0] == 880
    assert list(tmp_path.iterdir()) == [path]


def test_one_picture_is_written_where_a_png_is_named(command, tmp_path):
    path = tmp_path / "a.png"
    words = ("--height", "3", "--law", "overlap", "--frames", "12", "--film", str(path))
    assert f"--film: {path} is written" in command("tower", *words).err
    with Image.open(path) as image:
        assert (image.format, image.size[0]) == ("PNG", 880)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("tower", "--film", "a.avi"), "--film a.avi: must end in .gif, .mp4, .png"),
        (("tower", "--film", "no/a.gif"), "--film no/a.gif: there is no folder no"),
        (("tower", "--frames", "5"), "--frames 5: goes with --film only"),
        (("tower", "--film", "a.gif", "--frames", "1000"), "1000 frames: must be from 2 to 600"),
        (("critical-angle", "--film-angles", "9"), "--film-angles 9: goes with --film only"),
        (("run", "oblique", "--film", "a.gif"), "--film a.gif: case 'oblique' has no film"),
        (("run", "oblique", "--film", "a.png"), "--film a.png: case 'oblique' has no film"),
        (("run", "silo", "--film", "no/a.png"), "--film no/a.png: there is no folder no"),
        (("run", "tower", "--film", "a.gif", "--engine", "exact"), "'exact' is a solver"),
        (
            ("critical-angle", "--film", "a.gif", "--film-angles", "9,x"),
            "--film-angles 9,x: must be one to 3 numbers",
        ),
        (
            ("critical-angle", "--film", "a.gif", "--film-angles", "nan"),
            "--film-angles nan: must be one to 3 numbers",
        ),
    ],
)
def test_what_cannot_be_is_refused_at_once(command, tmp_path, words, told):
    out, err = command(*words, status=2)
    assert out == ""
    assert told in err
    assert len(err.splitlines()) <= 2
    assert list(tmp_path.iterdir()) == []


def test_an_engine_that_runs_a_case_without_its_film_is_refused_at_once(
    command, monkeypatch, tmp_path
):
    monkeypatch.setitem(registry.ENGINES, "yade", f"{__name__}:WithoutPaths")
    _, err = command("run", "incline", "--film", "a.gif", "--engine", "yade", status=2)
    assert "film: Twin cannot run it: its script writes no path" in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_verify_shows_films_in_its_page(command, monkeypatch, tmp_path):
    folder, film = tmp_path / "report", InclineDisplay.film
    monkeypatch.setattr(InclineDisplay, "film", lambda self, engine: film(self, engine, frames=8))
    words = ("--only", "*no loss*", "--cases", "incline", "--engine", "reference")
    # a row of theory tests nothing in the engine
    command(
        *("verify", "--quick", "--no-baseline", "--film", "--output", str(folder)), *words, status=3
    )
    assert [path.name for path in sorted((folder / "movies").iterdir())] == [
        "incline-film.gif",
        "incline-film.png",
    ]
    assert "data:image/gif;base64," in (folder / "report.html").read_text()
