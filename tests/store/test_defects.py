"""The file of known defects is read, and what is wrong with it is named."""

from itertools import takewhile
from pathlib import Path

import pytest

import harness
from harness.errors import RequestError
from harness.store.defects import defect_script, known_defects, read_defects

ENTRY = """[defect.NAME]
engine = "code"
cause = "the dashpot has half of its mass"
upstream = "not reported"
error = "NaN"
"""


def test_every_committed_defect_has_a_short_script_that_says_what_is_expected_and_found():
    found = known_defects()
    assert {"old-wall-friction", "tsuji-restitution"} <= {defect.name for defect in found}
    for defect in found:
        lines = defect_script(defect).splitlines()
        assert 0 < len(lines) <= 40, defect.name
        assert any("expected" in line and line.startswith("print") for line in lines), defect.name
        head = " ".join(takewhile(lambda line: line.startswith("#"), lines))
        assert "Expected" in head, defect.name
        assert "Found" in head, defect.name


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[defect.x]\nengine = 1\n", r"defect\.x: "),
        (ENTRY + "submodels = ['hertz']\n", r"defect\.NAME: .*submodels"),
        (ENTRY + "name = 3\n", r"defect\.NAME: "),
        ("[other.x]\n", "nothing else"),
        ("[defect", "cannot be read"),
        ("defect = {x = 1}", "nothing else"),
        ("\udcff", "cannot be read"),
    ],
)
def test_damage_is_named(tmp_path, text, words):
    file = tmp_path / "known-defects.toml"
    file.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(RequestError, match=words) as error:
        read_defects(file)
    assert str(file) in str(error.value)


def test_further_defects_stand_beside_the_committed_ones(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(ENTRY.replace("NAME", "weak"))
    assert known_defects(file)[-1].name == "weak"
    file.write_text(ENTRY.replace("NAME", "tsuji-restitution"))
    with pytest.raises(RequestError, match="'tsuji-restitution' is the name of a committed one"):
        known_defects(file)


def test_an_installed_package_has_file_and_scripts(tmp_path, monkeypatch):
    defect = known_defects()[0]
    package = tmp_path / "site" / "harness"
    monkeypatch.setattr(harness, "__file__", str(package / "__init__.py"))
    assert defect_script(defect) == ""
    committed = package / "store" / "committed"
    script = committed / "defects" / Path(defect.script).relative_to("reports/defects")
    script.parent.mkdir(parents=True)
    script.write_text("run 0\n")
    (committed / "known-defects.toml").write_text(ENTRY)
    assert defect_script(defect) == "run 0\n"
    assert [one.name for one in known_defects()] == ["NAME"]
    assert defect_script(defect.replace(script="")) == ""
