"""``--known-defects`` stands beside the committed file."""

import tomllib
from pathlib import Path

import pytest

from harness.errors import RequestError
from harness.store import baseline as store
from harness.store.baseline import known_defects, with_further
from harness.workflows.verification import Selection, verify

COMMITTED = Path(__file__).parents[2] / "inputs" / "known-defects.toml"
ONLY = "oblique/old hooke/history/wall"


def split(tmp_path):
    """Write one of the committed defects to a file of its own, and the others to another."""
    text = COMMITTED.read_text("utf-8")
    start = text.index("[defect.old-wall-friction]")
    end = text.index("\n[defect.", start + 1)
    one, rest = tmp_path / "mine.toml", tmp_path / "rest.toml"
    one.write_text(text[start:end])
    rest.write_text(text[:start] + text[end:])
    assert len(tomllib.loads(one.read_text())["defect"]) == 1
    return one, rest


def test_a_file_is_read_beside_the_committed_one(tmp_path, monkeypatch):
    one, rest = split(tmp_path)
    every = {defect.name for defect in known_defects()}
    with pytest.raises(RequestError, match=f"--known-defects {one}.*is known already"):
        with_further(one)
    monkeypatch.setattr(store, "committed_file", lambda _: rest)
    assert {defect.name for defect in with_further(None)} == every - {"old-wall-friction"}
    assert {defect.name for defect in with_further(one)} == every


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
def test_a_defect_that_is_known_by_a_file_alone_is_no_failure(tmp_path, monkeypatch):
    one, rest = split(tmp_path)
    monkeypatch.setattr(store, "committed_file", lambda _: rest)
    verdicts = {}
    for path in (None, one):
        found = verify("quick", cases=Selection("oblique", ONLY, defects=path), baseline=False)
        verdicts[path] = {row.verdict for row in found.checks}, found.status
    assert "fail" in verdicts[None][0]
    assert verdicts[None][1] == 1
    assert "known defect" in verdicts[one][0]
    assert "fail" not in verdicts[one][0]
    assert verdicts[one][1] == 0
