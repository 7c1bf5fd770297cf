"""Rigid spheres as a solver of the incline, beside the reference DEM and LAMMPS."""

import pytest

from harness.cases.incline.angle import critical_angle as critical_angle_in
from harness.cases.incline.case import CASE
from harness.cases.incline.checks import STIFFNESSES, rigid_section, solve_rigid
from harness.cases.incline.system import Incline
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.engines.lammps.engine import Lammps
from harness.engines.reference import Reference
from harness.parameters.law import Contact
from harness.solvers.hard_sphere import critical_angle
from harness.workflows import run, sweep


def stiff(e, k=1e8):
    return Incline(
        contact=Contact(name="e", restitution=e), stiffness=k, steps_per_contact=400.0, angle=10.5
    )


def test_it_is_a_solver_of_the_case_that_can_be_run_and_swept():
    found = run("incline", {"angle": "10.5", "contact": "plastic"}, "hard-sphere")
    margin = found.quantities["margin_over_mgd"]
    assert margin.note == "closed form"
    assert margin.difference == pytest.approx(0.0, abs=1e-5)  # the contact's own e is 0.009
    rows = sweep(
        "incline",
        {"contact.restitution": "0,0.3,0.5"},
        fixed={"angle": 10.5},
        engines="hard-sphere",
    ).to_frame()
    assert list(rows["moves_on"]) == [1.0, 1.0, 0.0]


@pytest.mark.parametrize("e", [0.1, 0.3])
def test_the_margin_of_a_stiff_dem_is_that_of_rigid_spheres(e):
    case = stiff(e)
    soft, hard = (
        CASE.measure(case.replace(stiffness=k), Reference()).values["margin_over_mgd"]
        for k in (1e6, 1e8)
    )
    rigid = solve_rigid(case).values["margin_over_mgd"]
    # 0.009 in m g d is a degree
    assert hard == pytest.approx(rigid, abs=1e-4)
    assert abs(hard - rigid) < abs(soft - rigid)


@pytest.mark.slow  # the reference DEM, whose runs LAMMPS repeats, is held against them above
@pytest.mark.live
def test_lammps_tends_to_rigid_spheres_as_it_stiffens(lammps_here):  # noqa: ARG001
    with Lammps() as engine:
        off = [
            critical_angle_in(stiff(0.1, k), engine=engine, phases=2).value_deg
            - critical_angle(0.1)
            for k in (1e6, 1e7, 1e8)
        ]
    assert off[0] > 2.0 * off[1] > 4.0 * off[2] > 0.0
    assert off[2] < 0.005


@pytest.mark.slow
def test_the_full_level_extrapolates_the_reference_to_rigid_spheres():
    found = CASE.verification.run_solvers(Study("full"))
    rows = {check.name: check for check in found.checks if "rigid spheres by events" in check.name}
    assert len(rows) == len(STIFFNESSES)
    for name, check in rows.items():
        print(name, check.value, check.expected, check.uncertainty)
        assert check.verdict is Verdict.PASS
        assert abs(check.value - check.expected) < 0.01
    section = rigid_section(found.evidence)
    assert "reference DEM" in section.drawings[0].caption
    measured = [row[2] for row in section.tables[0].rows]
    assert measured[0] == "-"
    assert "-" not in measured[1:]
