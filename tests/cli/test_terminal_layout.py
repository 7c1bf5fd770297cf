"""What verify, diff and sweep look like on 80 and on 160 columns, with the rows of a real run."""

import json
import math
from pathlib import Path

import pytest

from harness.cli.baseline import _print as print_diff
from harness.cli.sweep import _print as print_sweep
from harness.cli.verify import WIDEST, print_verification
from harness.comparison.run_diff import RowChange, diff_runs
from harness.comparison.verification import read_published
from harness.workflows.sweep_run import Sweep

EXAMPLE = Path(__file__).parents[2] / "reports" / "example" / "results.json"
WIDTHS = (80, 160)

MADE_UP = [
    ("pass", "analytic", "restitution, head-on, at a stiffness of 1e6 N/m", 0.5, 0.5),
    ("fail", "analytic", "critical angle at k = 1e6 N/m and 50 steps per contact time, in the "
     "plastic contact, the passage route", 10.25, 10.2078),
    ("not tested", "cross-code", "tower of 19 particles", math.nan, math.nan),
    ("finding", "finding", "clipped tail", 10.217, 10.2053),
    ("pass", "regression", "a-record: critical_angle_deg", 10.2, 10.2),
]  # fmt: skip

ON_80_COLUMNS = """\
fail: critical angle at k = 1e6 N/m and 50 steps per contact time, in the
  plastic contact, the passage route (analytic)
    10.25 against 10.2078 deg, 0.042 apart, 0.001 allowed
    wrong from the first step
not tested: tower of 19 particles (cross-code)
    the engine is not here
finding: clipped tail
    10.217 against 10.2053 deg, 0.012 apart, 0.001 allowed
    a finding
analytic: 1 of 2 hold
cross-code: 1 not tested
finding: 1 reported
regression: 1 of 1 hold
critical angle of the frictionless incline: expected 10.2078 deg; LAMMPS 10.2070
  +- 0.0004 deg (plastic contact)
report: runs/x/report.html
FAILED: 1 analytic
"""

ON_160_COLUMNS = ON_80_COLUMNS.replace(
    "in the\n  plastic contact,",
    "in the plastic contact,",
).replace("10.2070\n  +-", "10.2070 +-")


def made_up():
    notes = {"fail": "wrong from the first step", "not tested": "the engine is not here",
             "finding": "a finding"}  # fmt: skip
    checks = [
        {
            "verdict": verdict, "kind": kind, "name": name, "value": value, "expected": expected,
            "unit": "deg", "difference": value - expected, "tolerance": 1e-3, "triage": "",
            "note": notes.get(verdict, ""), "log": "",
        }
        for verdict, kind, name, value, expected in MADE_UP
    ]  # fmt: skip
    headline = {
        "name": "critical angle of the frictionless incline", "unit": "deg", "expected": 10.20782,
        "value": 10.206981, "uncertainty": 0.00042, "who": "LAMMPS", "note": "plastic contact",
    }  # fmt: skip
    return {"checks": checks, "headlines": [headline], "cached": False, "engine_errors": []}


@pytest.mark.parametrize(("columns", "shown"), [(80, ON_80_COLUMNS), (160, ON_160_COLUMNS)])
def test_the_layout_of_verify(monkeypatch, capsys, columns, shown):
    monkeypatch.setenv("COLUMNS", str(columns))
    print_verification(made_up(), Path("runs/x"))
    assert capsys.readouterr().out == shown


def real():
    """Return the record of the committed example with failures planted."""
    record = json.loads(EXAMPLE.read_text())
    for number, check in enumerate(record["checks"]):
        for key, value in check.items():
            check[key] = math.nan if value is None else value
        if number % 40 == 0:
            check["verdict"] = "fail"
    return {**record, "cached": False}


@pytest.mark.parametrize("columns", WIDTHS)
@pytest.mark.parametrize("verbose", [False, True])
def test_a_real_run_fits_and_no_name_is_cut(monkeypatch, capsys, columns, verbose):
    monkeypatch.setenv("COLUMNS", str(columns))
    record = real()
    print_verification(record, Path("runs/x"), verbose=verbose)
    out = capsys.readouterr().out
    lines = out.splitlines()
    assert max(map(len, lines)) <= min(columns, WIDEST)
    # a wrapped name is whole when its lines are joined again
    joined = " ".join(out.split())
    shown = record["checks"] if verbose else [c for c in record["checks"] if c["verdict"] == "fail"]
    for check in shown:
        name = " ".join(check["name"].split())
        assert name in joined or name.replace(" ", "") in joined.replace(" ", "")
    failed = sum(check["verdict"] == "fail" for check in record["checks"])
    assert failed > 5
    assert lines[-1].startswith("FAILED: ")
    assert lines[-2] == "report: runs/x/report.html"
    assert "critical angle of the frictionless incline: expected" in " ".join(lines[-6:-2])
    counts = [i for i, line in enumerate(lines) if line.startswith("regression: ")]
    assert counts[-1] > max(i for i, line in enumerate(lines) if line.startswith("fail: "))
    if not verbose:
        assert len(lines) < 120


@pytest.mark.parametrize("columns", WIDTHS)
def test_a_diff_fits_and_no_name_is_cut(monkeypatch, capsys, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    before = json.loads(EXAMPLE.read_text())
    after = json.loads(EXAMPLE.read_text())
    after["baseline_sha256"] = "f" * 64
    for number, check in enumerate(after["checks"]):
        if number % 40 == 0 and check["value"] is not None:
            # a move that overflows in units of an uncertainty next to nothing
            check.update(value=check["value"] + 6.6e-15, uncertainty=5e-324)
            before["checks"][number]["uncertainty"] = 5e-324
    after["checks"][0]["verdict"] = "fail"
    found = diff_runs(read_published(before), read_published(after))
    print_diff(found)
    out = capsys.readouterr().out
    lines = out.splitlines()
    assert max(map(len, lines)) <= min(columns, WIDEST)
    assert "inf" not in out.replace("infinity", "")
    assert "…" not in out
    assert any(line.startswith("baseline sha256: ") and "ffffffffffff" in line for line in lines)
    cells = [line.split("│")[1].strip() for line in lines if line.startswith("│")]
    joined = "".join("".join(cells).split())
    moved = [row.row.name for row in found.rows if row.change != "same"]
    assert len(moved) > 5
    for name in moved:
        assert "".join(name.split()) in joined
    assert lines[-1] == ", ".join(f"{found.count(change)} {change}" for change in RowChange)


@pytest.mark.parametrize("columns", WIDTHS)
def test_a_sweep_fits_a_terminal_and_a_pipe_gets_whole_lines(monkeypatch, capsys, columns):
    names = ("peak_force_N", "final_velocity_m_per_s", "largest_overlap_m", "energy_drift")
    rows = [
        {"engine": "lammps", "height_contacts": n, **dict.fromkeys(names, n / 7e5),
         "status": "done", "reason": ""} for n in range(3)
    ]  # fmt: skip
    swept = Sweep("tower", tuple(rows), ("height_contacts",), names)
    monkeypatch.setenv("COLUMNS", str(columns))
    print_sweep(swept, [])
    piped = capsys.readouterr().out
    assert len(piped.splitlines()) == 4
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    print_sweep(swept, [])
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= columns
    assert {*shown.replace("\\", " ").split()} == {*piped.split()}
