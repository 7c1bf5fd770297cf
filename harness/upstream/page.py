"""The page of upstream's tests: what fails and why, all tests by release, what was not tested."""

from __future__ import annotations

import pandas as pd

from harness.report.content import Section, Table
from harness.results.rows import Verdict
from harness.store.runs import Run
from harness.upstream.judging import MOTION, RECORDED_MOTION, STEP_ERROR

TITLE = "LAMMPS's own granular tests"
INTRODUCTION = """\
LAMMPS's `unittest/granular` runs a contact at one step and holds it against its own record, and
against a closed form to a relative tolerance. Here the same commands run in each release, with
newton on and off, and are held against the reference, which takes the same steps under the same
law.

- **recorded motion**: the motion at the end of each segment is that of the record, to the test's
  epsilon.
- **motion**: motion, forces and torques at the end of each segment are those of the reference, to
  1e-9 of the radius, the largest speed and the largest force.
- **error of the step**: the distance of the test's step from the limit of small steps, over the
  largest speed.
- A motion that fails, and is that of the reference with the switches of known defects, has their
  names.
- A test with a word that is not understood is *not tested*, with that word.
"""
FAILING = (Verdict.FAIL, Verdict.KNOWN_DEFECT)


def sections(run: Run) -> tuple[Section, ...]:
    """Return the sections of the page of a run of upstream's tests."""
    rows = run.rows
    failing = rows[rows["verdict"].isin(FAILING)]
    return (
        Section(TITLE, INTRODUCTION, (Table("By release", _counts(rows)),)),
        Section("What fails, and why", "" if len(failing) else "Nothing fails.",
                (Table("What fails", _failures(rows, failing)),) if len(failing) else ()),
        Section("All tests, by release", "Recorded motion / motion, newton on and off.",
                (Table("All tests", _by_release(rows)),)),
        Section("Not tested, and why", "", (Table("Not tested", _untested(rows)),)),
    )  # fmt: skip


def _counts(rows: pd.DataFrame) -> pd.DataFrame:
    judged = rows[rows["quantity"].isin([RECORDED_MOTION, MOTION])]
    counts = pd.crosstab([judged["engine"], judged["quantity"]], judged["verdict"])
    return counts.reset_index().rename(columns={"engine": "release"})


def _failures(rows: pd.DataFrame, failing: pd.DataFrame) -> pd.DataFrame:
    steps = rows[rows["quantity"] == STEP_ERROR].set_index(["setup", "engine"])["value"]
    keys = pd.MultiIndex.from_frame(failing[["setup", "engine"]])
    columns = ["setup", "engine", "check", "quantity", "verdict", "value", "defect", "note"]
    table = failing[columns].assign(step=steps.reindex(keys).to_numpy())
    return table.rename(columns={"setup": "test", "engine": "release", "step": STEP_ERROR})


def _by_release(rows: pd.DataFrame) -> pd.DataFrame:
    order = [str(verdict) for verdict in Verdict]
    worst = rows.groupby(["setup", "engine", "quantity"])["verdict"].agg(
        lambda verdicts: min(verdicts, key=order.index)
    )
    both = worst.unstack().reindex(columns=[RECORDED_MOTION, MOTION]).fillna("-")
    cells = both[RECORDED_MOTION] + " / " + both[MOTION]
    return cells.unstack().fillna("-").reset_index().rename(columns={"setup": "test"})


def _untested(rows: pd.DataFrame) -> pd.DataFrame:
    untested = rows[rows["verdict"] == Verdict.NOT_TESTED].assign(
        reason=lambda frame: frame["note"].str.partition(" (src")[0]
    )
    counts = untested.groupby(["engine", "quantity", "reason"])["setup"].nunique()
    return counts.reset_index(name="tests").rename(columns={"engine": "release"})
