import csv
import filecmp
import io
from pathlib import Path

import pytest

REPORT = Path(__file__).parents[2] / "reports" / "reproduction"


def test_requests_that_cannot_be_met(harness, tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").touch()
    assert "not a reproduction" in harness("reproduce", "--output", "thesis", status=2).stderr
    said = harness("reproduce", "--check", "--output", "thesis", status=2).stderr
    assert "--output thesis: no ledger.csv in it" in said
    (tmp_path / "thesis" / "ledger.csv").write_text("key,says\neq-1,k/n\n")
    said = harness("reproduce", "--check", "--output", "thesis", status=2).stderr
    assert "is not a ledger as dem-harness reproduce writes it" in said
    assert [path.name for path in tmp_path.iterdir()] == ["thesis"]


def test_the_committed_report_is_whole():
    text = (REPORT / "ledger.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) > 150
    assert {"eq-1", "eq-18", "eq-a11", "fig-1", "fig-16", "erratum-13"} <= {r["key"] for r in rows}
    page = (REPORT / "report.md").read_text(encoding="utf-8")
    for row in rows:
        for path in row["evidence"].split():
            there = REPORT / path if path.startswith("figures/") else REPORT.parents[1] / path
            assert there.is_file(), row["key"]
    for folder in ("figures", "movies", "dumps"):
        for path in (REPORT / folder).iterdir():
            assert f"({folder}/{path.name})" in page
    images = [p for f in ("figures", "movies") for p in (REPORT / f).iterdir()]
    assert sum(path.stat().st_size for path in images) < 10e6


@pytest.mark.live
@pytest.mark.slow
def test_the_committed_report_is_what_the_command_makes(harness, answer, tmp_path):
    """The ledger up to round-off; the files themselves may differ in last digits elsewhere."""
    found = answer("reproduce", "--check", "--output", str(REPORT), timeout=600)
    assert found["differences"] == []
    harness("reproduce", "--output", "twice", timeout=600)
    harness("reproduce", "--output", "again", timeout=600)
    names = [p.relative_to(tmp_path / "twice") for p in (tmp_path / "twice").rglob("*.*")]
    same, other, missing = filecmp.cmpfiles(
        tmp_path / "twice", tmp_path / "again", [str(name) for name in names], shallow=False
    )
    assert (len(same), other, missing) == (len(names), [], [])
