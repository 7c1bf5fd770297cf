import math

import pytest

from harness.errors import EngineError, RequestError
from harness.store.acceptance import ChangeKind
from harness.store.baseline import read_baseline
from harness.workflows import accept_baseline, compare_with_baseline
from tests.workflows import fakes

pytestmark = pytest.mark.usefixtures("registered")


def compared(folder, engine=None):
    return compare_with_baseline(
        "quick", cases="kept", engine=engine or fakes.Toy(), baseline=folder
    )


@pytest.fixture
def folder(tmp_path):
    target = tmp_path / "own"
    accept_baseline(compared(target), target)
    return target


def test_an_engine_of_any_name_gets_its_own_tables(folder):
    assert {path.name for path in folder.iterdir()} == {"toy.csv", "pencil.csv"}
    again = compared(folder)
    assert again.changes == ()
    assert {check.verdict for check in again.checks} == {"pass"}
    assert again.status == 0


def test_another_engine_is_added_and_the_first_stays(folder):
    accept_baseline(compared(folder, fakes.Other()), folder)
    assert {path.stem for path in folder.iterdir()} == {"toy", "pencil", "other"}
    assert set(read_baseline(folder).records) == {"toy/line", "pencil/line", "other/line"}


def test_round_off_is_no_change(folder, monkeypatch):
    monkeypatch.setattr(fakes.Toy, "factor", 1.0 + 1e-15)
    (change,) = compared(folder).changes
    assert change.kind is ChangeKind.ROUND_OFF
    monkeypatch.setattr(fakes.Toy, "factor", 1.1)
    (change,) = compared(folder).changes
    assert change.kind is ChangeKind.CHANGED
    assert compared(folder).status == 1


def test_a_value_that_is_no_number_is_not_accepted(tmp_path, monkeypatch):
    made = fakes.record
    monkeypatch.setattr(fakes, "record", lambda _, who: made(math.nan, who))
    with pytest.raises(EngineError, match="line: y = nan is not accepted"):
        accept_baseline(compared(tmp_path / "own"), tmp_path / "own")
    assert not (tmp_path / "own").exists()


def test_nothing_is_accepted_from_a_run_that_died(tmp_path):
    found = compared(tmp_path / "own", fakes.Missing())
    assert found.status == 3
    with pytest.raises(EngineError, match="nothing is accepted from a run that died"):
        accept_baseline(found, tmp_path / "own")
    assert not (tmp_path / "own").exists()


def test_a_damaged_baseline_and_a_file_in_its_place_are_refused(folder, tmp_path):
    (folder / "toy.csv").write_text("x\n")
    with pytest.raises(RequestError, match=r"toy\.csv is damaged: line 1"):
        compared(folder)
    (tmp_path / "file").write_text("")
    with pytest.raises(RequestError, match="no such folder"):
        compared(tmp_path / "file")
