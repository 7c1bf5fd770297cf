"""``--film`` of the commands: what it writes, and what it refuses before anything is run."""

import json
import sys

import pytest
from PIL import Image

from harness.cases.incline.report import InclineDisplay
from harness.cli import main


def run(monkeypatch, capsys, *words):
    monkeypatch.setattr(sys, "argv", ["dem-harness", *words])
    with pytest.raises(SystemExit) as left:
        main()
    printed = capsys.readouterr()
    return left.value.code or 0, printed.out, printed.err


@pytest.mark.parametrize(
    "words",
    [
        ("tower", "--height", "3", "--law", "overlap"),
        ("critical-angle", "--engine", "reference", "--stiffness", "1e5"),
        ("critical-angle", "--engine", "reference", "--film-angles", "9,12,13"),
    ],
)
def test_the_film_is_written_beside_the_answer(monkeypatch, capsys, tmp_path, words):
    path = tmp_path / "a.gif"
    more = ("--json", "--film", str(path), "--frames", "12")
    status, out, err = run(monkeypatch, capsys, *words, *more)
    assert status == 0
    assert f"--film: {path} is written" in err
    assert json.loads(out)
    with Image.open(path) as image:
        assert image.n_frames > 6
        assert image.size[0] == 880
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("tower", "--film", "a.avi"), "--film a.avi: must end in .gif, .mp4"),
        (("tower", "--film", "no/a.gif"), "--film no/a.gif: there is no folder no"),
        (("tower", "--frames", "5"), "--frames 5: goes with --film only"),
        (("tower", "--film", "a.gif", "--frames", "1000"), "1000 frames: must be from 2 to 600"),
        (("critical-angle", "--film-angles", "9"), "--film-angles 9: goes with --film only"),
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
def test_what_cannot_be_is_refused_at_once(monkeypatch, capsys, tmp_path, words, told):
    monkeypatch.chdir(tmp_path)
    status, out, err = run(monkeypatch, capsys, *words)
    assert (status, out) == (2, "")
    assert told in err
    assert len(err.splitlines()) <= 2
    assert list(tmp_path.iterdir()) == []


def test_verify_shows_films_in_its_page(monkeypatch, capsys, tmp_path):
    folder, film = tmp_path / "report", InclineDisplay.film
    monkeypatch.setattr(InclineDisplay, "film", lambda self, engine: film(self, engine, frames=8))
    words = ("--only", "*no loss*", "--cases", "incline", "--engine", "reference")
    status, _, err = run(
        monkeypatch, capsys, "verify", "--quick", "--no-baseline", "--film", "--output",
        str(folder), *words,
    )  # fmt: skip
    assert status == 3, err  # a row of theory tests nothing in the engine
    assert [path.name for path in sorted((folder / "movies").iterdir())] == [
        "incline-film.gif",
        "incline-film.png",
    ]
    assert "data:image/gif;base64," in (folder / "report.html").read_text()
