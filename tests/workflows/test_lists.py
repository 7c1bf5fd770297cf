"""Lists of verbs and scripts."""

import pytest

from harness import workflows
from harness.errors import RequestError
from harness.workflows import inputs, outdated_inputs
from harness.workflows.lists import input_texts
from tests.workflows import doubles

pytestmark = pytest.mark.usefixtures("registered")


def test_the_verbs_are_listed():
    assert set(workflows.__all__) <= set(dir(workflows))


def test_scripts_are_written_and_compared(tmp_path, monkeypatch):
    texts = {"a.in": "run 1\n", "b.in": "run 2\n"}
    monkeypatch.setattr(doubles.Usual, "inputs", classmethod(lambda *_: texts))
    monkeypatch.setattr(doubles.Good, "inputs", classmethod(lambda *_: {}))
    folder = tmp_path / "inputs"
    assert [path.name for path in inputs(folder)] == ["a.in", "b.in"]
    assert outdated_inputs(folder) == {}
    (folder / "a.in").write_text("run 3\n")
    (folder / "b.in").unlink()
    assert set(outdated_inputs(folder)) == {"a.in", "b.in"}
    with pytest.raises(RequestError, match="holds something already"):
        inputs(folder, "lammps")
    with pytest.raises(RequestError, match="'good': runs without scripts: must be one of lammps"):
        input_texts("good")
    with pytest.raises(RequestError, match="no such folder"):
        outdated_inputs(tmp_path / "nowhere")
