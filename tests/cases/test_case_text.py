import pytest

from harness.cases.text import Words, tolerances_in, tolerances_of
from harness.comparison.verdicts import Tolerance

TEXTS = """
[tolerances]
FORCE = { unit = "N", absolute = 1e-5, reason = "round-off" }

[tables.Both]
caption = "At {speed:g} m/s."
head = ["law", "force (N)"]
"""


def test_a_tolerance_has_the_values_of_the_file_and_an_unknown_word_is_an_error(tmp_path):
    (tmp_path / "case.toml").write_text(TEXTS, encoding="utf-8")
    module = str(tmp_path / "tolerances.py")
    assert tolerances_of(module) == {"FORCE": Tolerance("N", 1e-5, 0.0, "round-off")}
    with pytest.raises(TypeError, match="absolut"):
        tolerances_in({"FORCE": {"absolut": 1.0, "reason": "a word that is not known"}})


def test_a_text_that_is_missing_is_an_error(tmp_path):
    (tmp_path / "case.toml").write_text(TEXTS, encoding="utf-8")
    words = Words(str(tmp_path / "sections.py"))
    with pytest.raises(KeyError, match="nothing"):
        words.table("nothing", [])
    with pytest.raises(KeyError, match="speed"):
        words.table("Both", [])
    assert words.table("Both", [], speed=4.0).caption == "At 4 m/s."
