"""Verdicts of the tower's checks: right engines pass, each planted fault turns its rows."""

import numpy as np
import pandas as pd
import pytest

from harness.cases.bench import Bench
from harness.cases.checks import run_checks
from harness.cases.tower import case as checks
from harness.cases.tower.case import CASE
from harness.cases.tower.impulse import angle_figure, impulse_angles
from harness.engines.reference import Reference
from harness.report.page import draw
from harness.results.rows import Kind, Verdict
from tests.cases.common import rows_of, verdicts
from tests.cases.tower.standin import Euler, Standin


def failing(rows):
    return {(row.setup, row.quantity, row.check) for row in rows if row.verdict is Verdict.FAIL}


def test_an_engine_with_the_script_passes_all():
    rows = rows_of(CASE, Standin(), "default")
    assert verdicts(rows) == {Verdict.PASS}
    assert len(rows) == len({row.key for row in rows})
    assert {row.kind for row in rows} == {Kind.ANALYTIC, Kind.CROSS_CODE}


def test_an_engine_of_scenes_runs_the_overlap_law_and_one_row_says_what_it_lacks():
    rows = rows_of(CASE, Reference(), "default")
    lacking = [row for row in rows if row.verdict is Verdict.NOT_TESTED]
    assert [row.setup for row in lacking] == ["deformable law, n = 1"]
    assert "template" in lacking[0].note
    assert verdicts(rows) == {Verdict.PASS, Verdict.NOT_TESTED}


def test_a_scheme_of_first_order_with_few_digits_is_held_to_what_they_resolve():
    rows = rows_of(CASE, Euler(), only="tower/overlap law, n = [12]")
    assert failing(rows) == set()
    exact = next(row for row in rows if row.quantity == "impulse_Ns")
    assert exact.tolerance > checks.IMPULSE.width(exact.expected)


@pytest.mark.live
def test_both_laws_pass_in_lammps_with_the_numbers_of_the_readme(lammps):
    rows = {(row.setup, row.quantity, row.check): row for row in rows_of(CASE, lammps)}
    assert verdicts(rows.values()) == {Verdict.PASS}, rows
    overlap, deformable = (
        rows[f"{law} law, n = 2", "force_difference", ""].value for law in ("overlap", "deformable")
    )
    assert (overlap, deformable) == pytest.approx((5.2e-6, 4.8e-6), rel=0.01)
    ratio = rows["overlap law, n = 2", "impulse_ratio", "turnaround"].value
    assert ratio == pytest.approx(0.626299, abs=5e-7)


def late(table):
    """Return the table with velocities of the sample before."""
    return {**table, "vx_m_per_s": np.roll(table["vx_m_per_s"], 1, axis=0)}


def spike(table):
    force = table["fx_N"].copy()
    force[700, 0] *= 1 + 1e-6
    return {**table, "fx_N": force}


def weak(table):
    return {**table, "fx_N": 9.81 + (table["fx_N"] - 9.81) * (1.0 + 1e-4)}


def changed(**factors):
    return lambda case: case.replace(**{n: getattr(case, n) * f for n, f in factors.items()})


EQUAL = ("motion_difference", "equal steps")
FAULTS = {
    # fault: how it is planted, rows (quantity, check) of n = 2 that must turn
    "stiffness off by 1e-7": ({"change_case": changed(stiffness=1 + 1e-7)}, {EQUAL}),
    "mass off by 1e-7": ({"change_case": changed(mass=1 + 1e-7)}, {EQUAL}),
    "gravity off by 1e-6": ({"change_case": changed(gravity=1 + 1e-6)}, {EQUAL}),
    "diameter off by 1e-9": ({"change_case": changed(diameter=1 + 1e-9)}, {EQUAL}),
    "speed off by 1e-7": ({"change_case": changed(speed=1 + 1e-7)}, {EQUAL}),
    "step off by 1e-7": ({"step": 1 + 1e-7}, {EQUAL}),
    "speed off by 2e-4": (
        {"change_case": changed(speed=1 + 2e-4)},
        {EQUAL, ("force_difference", ""), ("impulse_Ns", "")},
    ),
    "velocities a sample late": ({"change_table": late}, {EQUAL, ("impulse_Ns", "")}),
    "a force off by 1e-6": ({"change_table": spike}, {EQUAL}),
    "a force of first order in the step": ({"change_table": weak}, {EQUAL}),
    "the other law": (
        {"change_case": lambda c: c.replace(law={"overlap": "deformable"}.get(c.law, "overlap"))},
        {EQUAL, ("force_difference", ""), ("impulse_Ns", ""), ("impulse_ratio", "turnaround")},
    ),
}


@pytest.mark.parametrize("law", ["overlap", "deformable"])
@pytest.mark.parametrize("fault", FAULTS)
def test_planted_faults(fault, law):
    planted, rows = FAULTS[fault]
    setup = f"{law} law, n = 2"
    found = failing(rows_of(CASE, Standin(**planted), only=f"tower/{setup}"))
    assert {(setup, *row) for row in rows} <= found


def not_a_force(table):
    force = table["fx_N"].copy()
    force[700, 1] = np.nan  # of a particle below the grain
    return {**table, "fx_N": force}


TABLES = {
    "a sample lost": lambda t: {name: column[:-1] for name, column in t.items()},
    "a column lost": lambda t: {name: t[name] for name in ("step", "x_m", "vx_m_per_s")},
    "a particle lost": lambda t: {n: c if c.ndim == 1 else c[:, :-1] for n, c in t.items()},
    "NaN": lambda t: {**t, "x_m": np.where(t["x_m"] > 0.0, t["x_m"], np.nan)},
    "NaN in a force": not_a_force,
    "other steps": lambda t: {**t, "step": 2.0 * t["step"]},
    "other times": lambda t: {**t, "time_s": np.linspace(0.0, 1.0, len(t["step"]))},
    "columns swapped": lambda t: {**t, "x_m": t["vx_m_per_s"], "vx_m_per_s": t["x_m"]},
    "no force": lambda t: {**t, "fx_N": np.full_like(t["fx_N"], 9.81)},
}


@pytest.mark.parametrize("fault", TABLES)
def test_a_bad_output_fails_every_row(fault):
    rows = rows_of(CASE, Standin(change_table=TABLES[fault]), only="tower/overlap law, n = 2")
    failed = [row for row in rows if row.verdict is Verdict.FAIL]
    assert len(failed) >= len(rows) - ("swapped" in fault)


def test_a_code_that_writes_no_forces_is_not_tested():
    mute = Standin(change_table=lambda t: {**t, "fx_N": np.full_like(t["fx_N"], np.nan)})
    rows = rows_of(CASE, mute, only="tower/overlap law, n = 2")
    assert {row.verdict for row in rows} == {Verdict.NOT_TESTED}
    assert all(row.note.endswith("writes no forces") for row in rows)


def test_solvers_of_the_package():
    rows = run_checks("tower", list(CASE.own_checks()), Bench(None))
    assert {row.verdict for row in rows} == {Verdict.PASS, Verdict.FINDING}
    values = {(row.setup, row.quantity, row.check): row for row in rows}
    rk4 = [values[f"{law} law, n = 2", "force_difference", "RK4"].value
           for law in ("overlap", "deformable")]  # fmt: skip
    assert rk4 == pytest.approx([6.6e-9, 4.9e-8], rel=0.01)
    tall = values["tall tower", "impulse_ratio", "exact propagator"]
    assert tall.value == pytest.approx(0.5661397, abs=5e-8)
    angle = values["deformable against overlap law, n = 19", "critical_angle_deg", "velocity lost"]
    assert (angle.value, angle.expected) == pytest.approx((4.7398, 5.0139), abs=1e-4)


def test_sections_and_figures_of_measured_angles():
    (section,) = CASE.sections({})
    assert draw(section.opening.figure).error == ""
    assert "10.21" in section.opening.steps[-1]
    assert "4.74" in section.opening.steps[-1]
    frame = impulse_angles(heights=(1, 2), stiffnesses=(1e6,), speeds=(2.0,), laws=("overlap",))
    measured = pd.DataFrame({"h_over_d": [1.0, 2.0], "theta_deg": [10.0, 8.0]})
    figure = angle_figure(frame, measured=measured)
    assert "measured" in {text.get_text() for text in figure.legends[0].get_texts()}
