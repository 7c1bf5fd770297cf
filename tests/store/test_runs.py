"""A run's folder: exact, whole or not at all, and refused with its name where it is damaged."""

import json
import os
from dataclasses import replace
from xml.etree import ElementTree as Xml

import pytest
from hypothesis import given, settings

from harness.errors import RequestError
from harness.results.compare import Change
from harness.results.rows import Failure, Verdict, failed, finding, not_tested, rows_of, table
from harness.store.runs import Meta, Run, junit, parsed_rows, read_run, rows_text, write_run
from tests.results.rows import SEVERAL, row, rows

META = Meta(level="quick", cases=("incline",), engines={"code": "1"}, named=("incline",),
            started="2026-01-01T00:00:00+00:00", seconds=1.25, platform="Linux",
            harness_version="2.0")  # fmt: skip


def run_of(*several, **meta):
    return Run(table(several), META.replace(**meta))


# ---- exact


@settings(max_examples=30)
@given(SEVERAL)
def test_rows_are_read_as_they_were_written(several):
    text = rows_text(table(several))
    again = parsed_rows(text)
    assert sorted(map(repr, rows_of(again))) == sorted(map(repr, several))
    assert rows_text(again) == text


def test_a_run_is_read_as_it_was_written(tmp_path):
    run = Run(rows(), META, scripts={"code/in.a b": "run 1"}, logs={"code/in.a b": "done"})
    write_run(run, tmp_path / "run", {"report.md": "# Report", "figures/a.png": b"\x89PNG"})
    again = read_run(tmp_path / "run")
    assert again.meta == run.meta
    assert (again.changes_from(run)["change"] == Change.SAME).all()
    assert sorted(map(repr, rows_of(again.rows))) == sorted(map(repr, rows_of(run.rows)))
    assert again.scripts == {"code/in.a-b": "run 1"}
    assert list(again.logs.values()) == ["done"]
    assert {path.name for path in (tmp_path / "run").iterdir()} == {
        "rows.csv", "run.json", "junit.xml", "logs", "scripts", "report.md", "figures"}  # fmt: skip


def test_accepted_rows_that_were_not_requested_are_no_change():
    run = Run(rows(("steady", None), ("angle", None)), META)  # steady is of level full
    changes = run.against(rows()).changes.set_index("quantity")["change"]
    assert changes["angle"] == Change.WORSE
    assert set(changes.drop("angle")) == {Change.SAME}
    assert "steady" in set(run.changes_from(Run(rows(), META))["quantity"])  # of two runs


@pytest.mark.parametrize("name", ["../../in", "/etc/in", ".hidden"])
def test_no_name_of_a_script_leaves_the_folder(tmp_path, name):
    write_run(Run(rows(), META, scripts={name: "x"}), tmp_path / "a" / "run")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    (text,) = read_run(tmp_path / "a" / "run").scripts.values()
    assert text == "x"


def test_a_run_is_written_whole_or_not_at_all_and_into_no_other_folder(tmp_path):
    with pytest.raises(AttributeError):
        write_run(run_of(row()), tmp_path / "run", {"report.md": None})
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "mine").write_text("x")
    with pytest.raises(RequestError, match="holds something"):
        write_run(run_of(row()), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


# ---- damaged


@pytest.fixture
def folder(tmp_path):
    write_run(Run(rows(), META), tmp_path / "run")
    return tmp_path / "run"


@pytest.mark.parametrize("name", ["rows.csv", "run.json"])
def test_a_file_that_is_cut_anywhere_is_refused_with_its_name(folder, name):
    whole = (folder / name).read_bytes()
    for end in range(0, len(whole), 7):
        (folder / name).write_bytes(whole[:end])
        with pytest.raises(RequestError, match=name):
            read_run(folder)


def second_line(text):
    return text.split("\n")[1]


DAMAGE = {
    "line missing": ("rows.csv", lambda t: t.replace(second_line(t) + "\n", ""), "7 of 8 rows"),
    "two of one key": (
        "rows.csv", lambda t: t + second_line(t) + "\n", "two rows of one key"),
    "other columns": ("rows.csv", lambda t: t.replace("quantity", "name", 1), "the columns must"),
    "no number": (
        "rows.csv", lambda t: t.replace("10.1", "ten"), "value: could not.*float: 'ten"),
    "other verdict": (
        "rows.csv", lambda t: t.replace("known defect", "good"), "verdict = 'good': must be fail"),
    "other version": (
        "run.json", lambda t: t.replace('"format": 3', '"format": 2'), "has format 2"),
    "other key": (
        "run.json", lambda t: t.replace('"strict"', '"tight"'), "tight: no such parameter"),
    "key missing": (
        "run.json", lambda t: t.replace(' "level": "quick",\n', ""), "level: must be given"),
    "other type": ("run.json", lambda t: t.replace("1.25", '"long"'), "seconds = 'long'"),
    "not a run": ("run.json", lambda _: "[1]", "is not the file of a run"),
    "nested": ("run.json", lambda _: "[" * 100_000, "is cut or damaged"),
    "not text": ("run.json", lambda _: "\udcff", "is not UTF-8"),
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_named(folder, name):
    file, change, words = DAMAGE[name]
    path = folder / file
    changed = change(path.read_text(encoding="utf-8"))
    assert changed != path.read_text(encoding="utf-8")
    path.write_bytes(changed.encode("utf-8", "surrogateescape"))
    with pytest.raises(RequestError, match=words) as error:
        read_run(folder)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("name", ["rows.csv", "logs/pipe"])
def test_a_pipe_in_a_run_is_refused(folder, name):
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)
    with pytest.raises(RequestError, match=rf"{name}: must be a file"):
        read_run(folder)


# ---- status and headline

DEFECT = replace(row(value=9.0), verdict=Verdict.KNOWN_DEFECT, failure=Failure.NONE)


@pytest.mark.parametrize(
    ("several", "meta", "status", "words"),
    [
        ([row()], {}, 0, "All verdicts hold"),
        ([row(value=11.0)], {}, 1, "Failed: 1 cross-code"),
        ([DEFECT, row("b")], {}, 0, "All verdicts hold; 1 known defect"),
        ([row("b"), not_tested(row(), "why")], {"strict": True}, 1, "Not all was tested; 1 not"),
        ([failed(row(), Failure.TIMEOUT, "late")], {}, 3, "Failed: 1 cross-code"),
        ([failed(row(), Failure.HARNESS, "KeyError: x")], {}, 1, "Failed: 1 cross-code"),
        ([not_tested(row(), "why")], {}, 3, "Nothing was tested in incline"),
        ([not_tested(row(), "why")], {"named": ()}, 3, "Nothing was tested in code; 1 not tested"),
        ([finding(row())], {"named": ()}, 0, "Nothing was judged"),
        ([row()], {"named": ("incline", "other")}, 3, "Nothing was tested in other"),
        ([row()], {"engines": {"code": "1", "other": ""}}, 3, "All verdicts hold"),
    ],
)
def test_status_and_headline(several, meta, status, words):
    run = run_of(*several, **meta)
    assert run.status == status
    assert words in run.headline
    assert words in run.summary()["outcome"]


def failures_in(run, folder):
    """Return the messages of the failures and errors of a written run's junit.xml."""
    write_run(run, folder)
    root = Xml.parse(folder / "junit.xml").getroot()
    return [case.get("message") for tag in ("failure", "error") for case in root.iter(tag)]


def test_junit_fails_where_the_run_does(tmp_path):
    untested = run_of(row("b"), not_tested(row(), "why"))
    moved = run_of(row(value=10.0 + 9e-10)).against(table([row(value=10.0 - 9e-10)]))
    runs = {
        "good": (untested, 0),
        "strict": (run_of(row("b"), not_tested(row(), "why"), strict=True), 1),
        "missing": (run_of(row(), engines={"code": "1", "other": ""}), 3),
        "moved": (moved, 1),
        "failed": (run_of(row(value=11.0)), 1),
    }
    for name, (run, status) in runs.items():
        assert run.status == status, name
        assert len(failures_in(run, tmp_path / name)) == bool(status), name
    assert failures_in(moved, tmp_path / "again") == ["Against the accepted run: 1 moved"]


def test_json_is_strict_and_has_the_columns_of_the_rows():
    record = json.loads(json.dumps(Run(rows(), META).to_json(), allow_nan=False))
    assert {"status", "headline", "rows"} <= record.keys()
    assert list(record["rows"][0]) == list(rows().columns)
    assert record["rows"][2]["value"] is None


# ---- CI


def test_junit_has_a_case_of_each_row():
    root = Xml.fromstring(junit(rows()))
    found = {name: sum(int(suite.get(name)) for suite in root) for name in
             ("tests", "failures", "errors", "skipped")}  # fmt: skip
    assert found == {"tests": 8, "failures": 1, "errors": 1, "skipped": 3}
    assert len(root.findall(".//testcase")) == 8
    assert "last words" in root.find(".//error").text
    assert len(Xml.fromstring(junit(table([failed(row(), Failure.ENGINE, "\x00\x1b", "\ud800")]))))
