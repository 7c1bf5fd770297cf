"""``run --film``: what it writes, and what it refuses before anything is run."""

import json

import pytest
from PIL import Image

from harness.engines import registry
from tests import engine_doubles as doubles


class WithoutPaths(doubles.Twin):
    """An engine that runs the incline and writes no path."""

    def refuses(self, job):
        return "its script writes no path" if job.sampled else super().refuses(job)

    def run(self, jobs):
        raise AssertionError(jobs)


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (("incline", "--engine", "reference", "--set", "contact.restitution=0.3"), "a.gif"),
        pytest.param(("tower", "--set", "height=3"), "a.png", marks=pytest.mark.live),
    ],
)
def test_the_film_is_written_beside_the_answer(command, tmp_path, words, name):
    path = tmp_path / name
    said = command("run", *words, "--json", "--film", str(path), "--frames", "5")
    assert f"--film: {path} is written" in said.err
    assert json.loads(said.out)["case"] == words[0]
    with Image.open(path) as image:
        assert getattr(image, "n_frames", 1) == (5 if name == "a.gif" else 1)
        assert image.size[0] == 880
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("tower", "--film", "a.avi"), "--film a.avi: must end in .gif, .mp4, .png"),
        (("silo", "--film", "no/a.gif"), "--film no/a.gif: there is no folder no"),
        (("tower", "--frames", "5"), "--frames 5: goes with --film only"),
        (("tower", "--film", "a.gif", "--frames", "1000"), "1000 frames: must be from 2 to 600"),
        (("oblique", "--film", "a.gif"), "--film a.gif: case 'oblique' has no film"),
        (("tower", "--film", "a.gif", "--engine", "exact"), "'exact' is a solver"),
    ],
)
def test_what_cannot_be_is_refused_at_once(command, tmp_path, words, told):
    out, err = command("run", *words, status=2)
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
