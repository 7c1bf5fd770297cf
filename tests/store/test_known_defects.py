"""The file of known defects is read, and what is wrong with it is named."""

from itertools import takewhile
from pathlib import Path

import pytest

import harness
from harness.cases.registry import all_cases
from harness.errors import RequestError
from harness.store.baseline import known_defects, script_of

ROOT = Path(harness.__file__).parent.parent


def test_every_committed_defect_has_its_script_and_names_cells_that_there_are():
    found = known_defects()
    assert {"old-wall-friction", "tsuji-restitution"} <= {one.name for one in found}
    for one in found:
        script = ROOT / one.script
        assert script.is_file(), one.name
        assert script_of(one) == script.read_text(encoding="utf-8")
        lines = script_of(one).splitlines()
        assert len(lines) <= 40, one.name
        assert any("expected" in line and line.startswith("print") for line in lines), one.name
        head = " ".join(takewhile(lambda line: line.startswith("#"), lines))
        assert "Expected" in head, one.name
        assert "Found" in head, one.name
        for case in one.cases:
            assert case == "*" or case in all_cases(), one.name


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[defect.x]\nengine = 1\n", "defect.x"),
        ("[other.x]\n", "nothing else"),
        ("[defect", "cannot be read"),
        ("defect = {x = 1}", "nothing else"),
    ],
)
def test_a_file_that_is_none_is_named_with_what_is_wrong(tmp_path, text, words):
    path = tmp_path / "known-defects.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RequestError, match=words) as told:
        known_defects(path)
    assert str(path) in str(told.value)


def test_a_script_lies_in_a_wheel_as_well_and_a_defect_may_have_none(tmp_path, monkeypatch):
    defect = known_defects()[0]
    package = tmp_path / "site" / "harness"
    monkeypatch.setattr(harness, "__file__", str(package / "__init__.py"))
    assert script_of(defect) == ""
    name = Path(defect.script).relative_to("reports/defects")
    file = package / "store" / "committed" / "defects" / name
    file.parent.mkdir(parents=True)
    file.write_text("run 0\n", encoding="utf-8")
    assert script_of(defect) == "run 0\n"
    assert script_of(defect.model_copy(update={"script": ""})) == ""
