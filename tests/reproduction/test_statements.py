"""Statements of the source: what becomes of a printed value, and the numbers of the ledger."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.cases.incline.angle import CriticalAngle
from harness.cases.incline.system import Incline
from harness.errors import EngineError, RequestError, Unsupported
from harness.model.law import Contact
from harness.report.page import draw
from harness.reproduction import UNTESTED, Statement
from harness.reproduction import run as reproduction
from harness.reproduction.incline import mfix_scheme, on_engine
from harness.store.runs import read_rows
from harness.workflows import diff

COMMITTED = Path(__file__).parents[2] / "reports" / "reproduction"

# searches in MFiX's scheme and in LAMMPS; impulses of the source's six runs over all heights
LONG = {"mfix_scheme", "on_engine", "separation", "impulses_over_height", "angles_over_height",
        "energy_scaling", "window", "errata"}  # fmt: skip
OVER_HEIGHT = {"fig-10-ratio", "fig-11-angle", "fig-13-energy"}


@pytest.fixture(scope="module")
def run():
    """Return the rows of all statements but those of long runs."""
    parts = [part for part in reproduction.subjects(None) if part.__name__ not in LONG]
    return reproduction.recomputed(parts)


# ---- rows of a statement


@pytest.mark.parametrize(
    ("values", "verdicts"),
    [
        ((1.0 + 1e-13, 1.0), ["pass"]),
        ((1.0, 1.0, 3.0), ["pass"]),  # a correction that is not needed
        ((2.0, 1.0), ["finding"]),
        ((2.0, 1.0, 3.0), ["finding", "fail"]),
        ((math.nan, 1.0, 1.0), ["finding", "fail"]),
        (([1.0, math.nan], [1.0, 1.0], [1.0, 1.0]), ["finding", "fail"]),
        ((True,), ["pass"]),
        ((False, None, True), ["finding", "pass"]),
        ((False, None, False), ["finding", "fail"]),
        ((EngineError("lost atoms"), 1.0), ["fail"]),
        ((Unsupported("it has no springs"), 1.0), ["not tested"]),
    ],
)
def test_verdicts_of_a_statement(values, verdicts):
    assert [row.verdict for row in Statement("x", "eq. (0)", "x = 1", *values).rows] == verdicts


class Dead:
    """A bench whose engine has a name and a version, and nothing else."""

    name = "dead"
    engine = type("E", (), {"identify": lambda _: type("P", (), {"engine_version": "1"})})()


def test_statements_on_an_engine_are_rows_where_it_dies_or_is_not_there(monkeypatch):
    def dies(*_):
        raise EngineError("lost atoms")

    monkeypatch.setattr("harness.reproduction.incline.angle_on", dies)
    dead = [row for statement in on_engine(Dead()) for row in statement.rows]
    assert [(row.verdict, row.engine, row.version) for row in dead] == [("fail", "dead", "1")] * 3
    none = [row for statement in on_engine(None) for row in statement.rows]
    assert [(row.verdict, row.kind) for row in none] == [("not tested", "cross-code")] * 3


@pytest.mark.parametrize(
    ("refused", "untested", "error"),
    [
        ({"steps_per_contact": 50.0}, ["engine-angle", "engine-step"], Unsupported),
        ({"steps_per_contact": 100.0}, [], EngineError),  # is in a note alone
        ({"steps_per_contact": 400.0}, ["engine-step"], RequestError),
        ({"contact": Contact(restitution=0.1)}, ["engine-restitution"], EngineError),
    ],
)
def test_a_statement_on_an_engine_is_untested_only_where_its_own_run_failed(
    monkeypatch, refused, untested, error
):
    refused = Incline(**refused)

    def angle_on(_, case):
        if case == refused:
            raise error("not this one")
        return CriticalAngle(value=10.21, uncertainty=1e-4, method="passage", case=case,
                             mean_error=0.0, runs=(), steps=0, provenance=None)  # fmt: skip

    monkeypatch.setattr("harness.reproduction.incline.angle_on", angle_on)
    statements = list(on_engine(Dead()))
    assert [s.key for s in statements if s.status == UNTESTED] == untested
    if not untested:
        assert "10.2100 deg at 50, no angle at 100" in statements[1].note


# ---- the ledger


def test_values_and_verdicts_are_those_of_the_committed_ledger(run):
    words = "40 reproduced, 25 reproduced with a correction, 7 not reproduced"
    assert reproduction.headline(run) == words
    assert (run.rows[["setup", "reason"]] != "").all(axis=None)
    assert run.status == 0
    key = ["quantity", "check"]
    rows = run.rows.set_index(key)
    committed = read_rows(COMMITTED / "rows.csv").set_index(key).loc[rows.index]
    assert (rows["verdict"] == committed["verdict"]).all()
    np.testing.assert_allclose(rows["value"], committed["value"], rtol=1e-6, atol=1e-9)
    assert rows.loc[("critical-angle", ""), "value"] == pytest.approx(10.207819, abs=1e-6)


def test_a_stored_reproduction_has_its_pages_and_compares_with_itself(run, tmp_path, monkeypatch):
    parts = [replace(part, drawings=()) for part in reproduction.sections(run)]
    monkeypatch.setattr(reproduction, "sections", lambda _: parts)
    reproduction.write_reproduction(run, tmp_path / "out")
    assert "second term shock^(n-2)" in (tmp_path / "out" / "report.html").read_text()
    assert diff(tmp_path / "out", run).changes.empty
    moved = run.rows.copy()
    moved.loc[moved["quantity"] == "t-n", "value"] *= 1.1
    changes = diff(tmp_path / "out", replace(run, rows=moved)).changes
    assert changes["quantity"].tolist() == ["t-n"]


def test_figures_of_single_runs_are_drawn():
    drawings = {drawing.name: drawing for drawing in reproduction.drawings()}
    assert 10 <= len(drawings) <= 12
    assert drawings.keys() >= OVER_HEIGHT
    assert all(drawings[name].draw().axes for name in drawings.keys() - OVER_HEIGHT)


# ---- files of figures, with MFiX's scheme, and with LAMMPS


@pytest.mark.slow
def test_every_figure_is_written():
    assert {draw(drawing).error for drawing in reproduction.drawings()} == {""}


@pytest.mark.slow
def test_in_the_scheme_of_mfix_a_finer_step_is_further_from_the_closed_form():
    verdicts = [row.verdict for statement in mfix_scheme() for row in statement.rows]
    assert verdicts == ["pass", "finding"]


@pytest.mark.slow
@pytest.mark.live
def test_the_committed_reproduction_is_what_the_code_makes_now():
    run = reproduction.reproduce()
    assert diff(COMMITTED, run).changes.empty
    assert f"**{reproduction.headline(run)}**" in (COMMITTED / "report.md").read_text("utf-8")
