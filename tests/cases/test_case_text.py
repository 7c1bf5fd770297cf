import re
from pathlib import Path

import matplotlib.figure
import pytest

import harness.cases
from harness.cases.text import Words, tolerances_of
from harness.comparison.verdicts import Tolerance

TOLD = """
[figures]
"force-{law}" = ["Force, {law} law", "At {speed:g} m/s."]

[sections.laws]
title = "The laws"
paragraphs = ["They differ."]

[tolerances]
FORCE = { unit = "N", absolute = 1e-5, reason = "round-off" }

[regression]
force_N = { relative = 1e-9, reason = "round-off, too" }
wrong = { absolut = 1.0, reason = "a word that is not known" }

[tables.Both]
caption = "At {speed:g} m/s."
head = ["law", "force (N)"]
"""


@pytest.fixture
def words(tmp_path):
    (tmp_path / "case.toml").write_text(TOLD, encoding="utf-8")
    return Words(str(tmp_path / "sections.py"))


def test_values_stand_in_name_title_and_caption_of_a_figure(words):
    figure = matplotlib.figure.Figure()
    drawn = words.drawing("force-{law}", lambda: figure, law="overlap", speed=2.0)
    assert (drawn.name, drawn.title) == ("force-overlap", "Force, overlap law")
    assert drawn.caption == "At 2 m/s."
    assert drawn.draw() is figure


def test_a_section_and_a_table_have_the_words_and_the_parts_that_are_given(words):
    table = words.table("Both", [("overlap", "1")], speed=4.0)
    assert (table.label, table.caption) == ("Both", "At 4 m/s.")
    assert (table.head, table.rows) == (("law", "force (N)"), (("overlap", "1"),))
    section = words.section("laws", paragraphs=["By a half."], tables=(table,))
    assert section.title == "The laws"
    assert section.paragraphs == ("They differ.", "By a half.")
    assert section.tables == (table,)


def test_a_tolerance_that_is_not_told_is_none_at_all(tmp_path, words):  # noqa: ARG001
    module = str(tmp_path / "tolerances.py")
    assert tolerances_of(module) == {"FORCE": Tolerance("N", 1e-5, 0.0, "round-off")}
    with pytest.raises(TypeError, match="absolut"):
        tolerances_of(module, "regression")


def test_what_the_file_does_not_tell_is_an_error(words):
    for ask in (words.section, lambda name: words.drawing(name, matplotlib.figure.Figure)):
        with pytest.raises(KeyError, match="nothing"):
            ask("nothing")
    with pytest.raises(KeyError, match="speed"):
        words.table("Both", [])


@pytest.mark.parametrize("case", ["incline", "tower", "columns", "drop"])
def test_every_figure_section_and_table_that_is_told_is_used_and_none_is_missing(case):
    folder = Path(harness.cases.__path__[0]) / case
    code = "".join(path.read_text(encoding="utf-8") for path in folder.rglob("*.py"))
    told = Words(str(folder / "case.py"))._texts
    for sort, method in (("figures", "drawing"), ("sections", "section"), ("tables", "table")):
        used = re.findall(rf'WORDS\.{method}\(\s*"([^"]+)"', code)
        assert sorted(used) == sorted(told.get(sort, {})), sort
