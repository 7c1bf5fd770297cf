import csv

import pytest

from harness.store.baseline import committed


def committed_rows(engine):
    """Return the rows of the committed table of an engine."""
    text = (committed() / f"{engine}.csv").read_text(encoding="utf-8")
    return csv.DictReader(text.splitlines())


@pytest.mark.slow
@pytest.mark.live
def test_accept_shows_writes_only_when_told_to_and_then_compares_clean(harness, answer, tmp_path):
    shown = harness("baseline", "accept", "--level", "quick", "--baseline", "base", timeout=300)
    assert "new: lammps/incline-path-source-10.2-deg" in shown.stdout
    assert "nothing written; --yes writes it" in shown.stdout
    assert list(tmp_path.iterdir()) == []
    accepted = ("baseline", "accept", "--level", "quick", "--yes", "--baseline", "base")
    record = answer(*accepted, timeout=300)
    assert record["written"]
    # the same LAMMPS: what was accepted is what is committed; what is fitted to it is rounded by
    # the linear algebra of the processor
    path = tmp_path / "base" / "lammps.csv"
    rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    known = {r["record"] + r["quantity"]: r["value"] for r in committed_rows("lammps")}
    assert {row["value"] for row in rows if row["quantity"] == "step_s"} != set()
    committed_values = [float(known[row["record"] + row["quantity"]]) for row in rows]
    assert [float(row["value"]) for row in rows] == pytest.approx(committed_values, rel=1e-14)
    (changed,) = [
        row
        for row in rows
        if row["record"] == "lammps/incline-path-plastic-10.2-deg"
        and row["quantity"] == "margin_over_mgd"
    ]
    moved = repr(float(changed["value"]) * (1 + 1e-3))
    path.write_text(path.read_text(encoding="utf-8").replace(changed["value"], moved))
    found = answer(
        "baseline", "compare", "--level", "quick", "--baseline", "base", status=1, timeout=300
    )
    failed = [check for check in found["checks"] if check["verdict"] == "fail"]
    assert [check["name"] for check in failed] == [
        "baseline: lammps/incline-path-plastic-10.2-deg: margin_over_mgd"
    ]
    assert failed[0]["triage"] == "out of tolerance"
    (change,) = found["changes"]
    assert change["kind"] == "changed"


def test_bad_requests(harness, tmp_path):
    said = harness("baseline", "compare", "--baseline", "x", status=2).stderr
    assert "--baseline x: No such file or directory" in said
    (tmp_path / "file").write_text("")
    said = harness("baseline", "accept", "--baseline", "file", status=2).stderr
    assert "--baseline file: is a file" in said
    said = harness("verify", "--baseline", "x", "--no-baseline", status=2).stderr
    assert "give one of them only" in said
    said = harness("baseline", "compare", "--baseline", "x" * 300, status=2).stderr
    assert "File name too long" in said
    assert {path.name for path in tmp_path.iterdir()} == {"file"}


def test_damaged_file_is_named_before_anything_runs(harness, tmp_path):
    (tmp_path / "base").mkdir()
    (tmp_path / "base" / "lammps.csv").write_text("{")
    said = harness("verify", "--quick", "--baseline", "base", "--output", "run", status=2).stderr
    assert "base/lammps.csv" in said
    assert "damaged" in said
    assert not (tmp_path / "run").exists()


def test_there_is_a_committed_baseline():
    assert committed() is not None
