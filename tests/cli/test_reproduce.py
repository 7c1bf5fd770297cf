import csv
import io
import json
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from harness.observables.provenance import Provenance
from harness.reproduction.claims import SOURCES, Ledger, compare, ledger_differences

REPORT = Path(__file__).parents[2] / "reports" / "reproduction"


class NoEngine:
    """Options that open nothing: what is computed is planted."""

    @contextmanager
    def run(self):
        yield None


@pytest.fixture
def run_here(monkeypatch, tmp_path, capsys):
    """Run the command in this process and in an empty folder, with a ledger of one row."""
    from harness.cli.publish import ReproduceOptions, reproduce

    monkeypatch.chdir(tmp_path)
    asked = {}

    def run(found=10.2078, **options):
        row = compare(SOURCES["text-critical-angle"], printed=10.21, found=found, computed="10.21")
        made = SimpleNamespace(
            ledger=Ledger((row,)), provenance=Provenance("lammps", "test", how="in-process")
        )
        monkeypatch.setattr(
            "harness.reproduction.run.reproduce", lambda **given: asked.update(given) or made
        )
        monkeypatch.setattr("harness.reproduction.page._fill", _fill)
        status = reproduce(ReproduceOptions(**options), NoEngine(), json=True)
        return status, json.loads(capsys.readouterr().out)

    run.asked = asked
    return run


def _fill(found, folder, _root):
    found.ledger.to_frame().to_csv(folder / "ledger.csv", index=False)


def test_a_run_goes_below_runs_unless_told_otherwise(run_here, tmp_path):
    status, record = run_here()
    assert status == 0
    assert Path(record["folder"]).parent == Path("reports/runs")
    assert (tmp_path / record["folder"] / "ledger.csv").is_file()


def test_check_reads_the_committed_ledger_and_writes_nothing(run_here, tmp_path):
    run_here(output=Path("reports/reproduction"))
    before = sorted(tmp_path.rglob("*"))
    assert run_here(check=True)[1]["differences"] == []
    # round-off of another machine
    assert run_here(10.2078 * (1 + 4e-16), check=True)[0] == 0
    status, record = run_here(10.2178, check=True)
    assert status == 1
    assert record["differences"] == [
        "text-critical-angle: was reproduced, is not reproduced",
        "text-critical-angle: found was 10.2078, is 10.2178",
    ]
    assert sorted(tmp_path.rglob("*")) == before


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
    said = harness("reproduce", "--check", status=2).stderr
    assert "reports/reproduction: no ledger.csv in it" in said


def test_the_committed_report_is_whole():
    text = (REPORT / "ledger.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert {row["key"] for row in rows} == set(SOURCES)
    page = (REPORT / "report.md").read_text(encoding="utf-8")
    for row in rows:
        for path in row["evidence"].split():
            there = REPORT / path if path.startswith("figures/") else REPORT.parents[1] / path
            assert there.is_file(), row["key"]
    for path in (REPORT / "figures").iterdir():
        assert f"(figures/{path.name})" in page


@pytest.mark.live
@pytest.mark.slow
def test_the_committed_report_is_what_the_command_makes(harness, tmp_path):
    """The ledger up to round-off; the files themselves may differ in last digits elsewhere."""
    harness("reproduce", "--output", "made", timeout=600)
    made = tmp_path / "made"
    ledgers = [pd.read_csv(folder / "ledger.csv") for folder in (REPORT, made)]
    assert ledger_differences(*ledgers) == []
    names = [{p.relative_to(folder) for p in folder.rglob("*")} for folder in (REPORT, made)]
    assert names[0] == names[1]
