"""Accepted runs and known defects: merged exactly, and damage is named."""

from pathlib import Path

import pytest

from harness import files
from harness.errors import RequestError
from harness.results.compare import Change
from harness.results.rows import Failure, failed, not_tested
from harness.store.committed import accept, accepted_rows, defect_script, known_defects
from harness.store.runs import Run
from tests.results.rows import row, rows
from tests.store.test_runs import META, run_of


def test_a_run_is_held_against_the_accepted_one(tmp_path):
    (file,) = accept(Run(rows(("flight", None)), META), tmp_path)
    assert file == tmp_path / "code" / "1" / "rows.csv"
    accepted = accepted_rows({"code": "1"}, tmp_path)
    assert len(accepted) == 6  # without the row that was not tested
    assert run_of(row()).against(accepted).status == 1  # it lacks the others
    lacking = Run(rows(("flight", None), ("shock", None)), META).against(accepted)
    assert list(lacking.regressions["quantity"]) == ["shock"]
    other = Run(rows(("flight", None), ("angle", row(inputs="b"))), META).against(accepted)
    assert list(other.regressions["change"]) == [Change.OTHER_INPUT]
    assert other.headline.startswith("Failed: 1 cross-code; Against the accepted run: 1 other")


def test_accepting_drops_missing_rows_of_the_scope_and_keeps_the_rest(tmp_path):
    accept(run_of(row("a"), row("b"), row("c", level="full"), row("d", case="tower"),
                  level="full", cases=("incline", "tower")), tmp_path)  # fmt: skip
    accept(run_of(row("b"), not_tested(row("a"), "no such contact")), tmp_path)
    assert sorted(accepted_rows({"code": "1"}, tmp_path)["quantity"]) == ["a", "b", "c", "d"]
    accept(run_of(row("a")), tmp_path)
    assert sorted(accepted_rows({"code": "1"}, tmp_path)["quantity"]) == ["a", "c", "d"]


def test_a_case_that_was_not_tested_keeps_its_accepted_rows(tmp_path):
    accept(run_of(row("a"), row("b")), tmp_path)
    whole = row("", setup="")
    for untested in (not_tested(whole, "not qualified"), failed(whole, Failure.HARNESS, "raised")):
        assert accept(run_of(untested), tmp_path) == []
    assert list(accepted_rows({"code": "1"}, tmp_path)["quantity"]) == ["a", "b"]


def test_nothing_is_accepted_of_a_run_in_which_an_engine_died(tmp_path):
    with pytest.raises(RequestError, match="an engine failed in 1 rows"):
        accept(Run(rows(), META), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_engine_that_tested_nothing_has_no_accepted_run(tmp_path):
    untested = not_tested(row("b", engine="other", version=""), "other is missing")
    assert accept(run_of(row("a"), untested), tmp_path) == [tmp_path / "code" / "1" / "rows.csv"]
    assert [path.name for path in tmp_path.iterdir()] == ["code"]


def test_an_engine_s_name_leads_out_of_no_folder(tmp_path):
    named = run_of(row(engine="../../up"))
    assert accept(named, tmp_path) == [tmp_path / "up" / "1" / "rows.csv"]
    assert len(accepted_rows({"../../up": "1"}, tmp_path)) == 1


def test_rows_of_the_same_release_are_taken_and_else_of_the_newest(tmp_path):
    versions = {"2 Aug 2023 - Update 3": 1.0, "22 Jul 2025 - Update 4": 2.0, "23 Jun 2022": 3.0}
    for version, value in versions.items():
        accept(run_of(row(value=value, version=version)), tmp_path)
    for version in (*versions, "10 Dec 2027"):
        accepted = accepted_rows({"code": version, "other": "1"}, tmp_path)
        assert list(accepted["value"]) == [versions.get(version, 2.0)]


# ---- known defects

ENTRY = """[defect.NAME]
engine = "code"
cause = "the dashpot has half of its mass"
upstream = "not reported"
error = "NaN"
"""


def test_every_committed_defect_has_a_short_script_with_its_expected_value():
    defects = known_defects()
    assert {"old-wall-friction", "tsuji-restitution"} <= {defect.name for defect in defects}
    for defect in defects:
        lines = defect_script(defect).splitlines()
        assert 0 < len(lines) <= 40, defect.name
        assert any("expected" in line and line.startswith("print") for line in lines), defect.name


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[defect.x]\nengine = 1\n", r"defect\.x: "),
        (ENTRY + "submodels = ['hertz']\n", r"defect\.NAME: .*submodels"),
        (ENTRY.replace("NAME", "tsuji-restitution"), "'tsuji-restitution' is the name of a comm"),
        ("[other.x]\n", "nothing else"),
        ("defect = 3", "nothing else"),
        ("defect = {x = 1}", "nothing else"),
        ("[defect", "cannot be read"),
        ("\udcff", "cannot be read"),
    ],
)
def test_damage_is_named(tmp_path, text, words):
    file = tmp_path / "known-defects.toml"
    file.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(RequestError, match=words) as error:
        known_defects(file)
    assert str(file) in str(error.value)


def test_an_installed_package_has_file_and_scripts_and_accepts_nothing(tmp_path, monkeypatch):
    defect = known_defects()[0]
    package = tmp_path / "site" / "harness"
    monkeypatch.setattr(files, "PACKAGE", package)
    assert defect_script(defect) == ""
    committed = package / "store" / "committed"
    script = committed / "defects" / Path(defect.script).relative_to("reports/defects")
    script.parent.mkdir(parents=True)
    script.write_text("run 0\n")
    (committed / "known-defects.toml").write_text(ENTRY)
    assert defect_script(defect) == "run 0\n"
    assert [defect.name for defect in known_defects()] == ["NAME"]
    with pytest.raises(RequestError, match="belongs to the installed package"):
        accept(run_of(row()))
