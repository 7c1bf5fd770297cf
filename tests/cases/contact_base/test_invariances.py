"""Invariances in LAMMPS: what holds, what its defects break, and that a fault of each is seen."""

from dataclasses import replace
from typing import ClassVar

import pytest

from harness.cases.contact import transformations
from harness.cases.contact.invariance import invariances
from harness.cases.contact.transformations import EQUAL
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import mark_known_defects
from harness.comparison.verdicts import Kind, Verdict
from harness.engines.lammps.engine import DEFAULTS, SORTED, Lammps
from harness.errors import EngineMissingError
from harness.store.baseline import known_defects

pytestmark = [pytest.mark.live, pytest.mark.usefixtures("lammps_here")]

BOTH = {"turned", "mirrored", "moved", "in other units"}
OF_LAMMPS = {
    "stiffnesses as input",
    "newton on",
    "thin neighbour skin",
    "neighbours at every step",
    "neighbours from bins",
    "continued without setup",
    "continued with a setup",
    "restarted",
    "over a periodic boundary",
    DEFAULTS,
}


class OneRank(Lammps):
    """LAMMPS whose variations are told something else besides, on one rank."""

    besides: ClassVar = {}

    def variations(self, job, ends):
        return [
            replace(told, values={**told.values, **self.besides})
            for told in super().variations(job, ends)
            if told.ranks == 1
        ]


@pytest.fixture(scope="module")
def lammps():
    with OneRank(workers=1) as engine:
        yield engine


def few(name, submodels, systems):
    """Return a case with some of its submodels, whose invariances are all looked at."""
    case = type(get_case(name))()
    case.submodels = [one for one in case.submodels if one.name in submodels]
    case.systems = {system: case.systems[system] for system in systems}
    case.invariant = case.submodels
    return case


def rows(engine, case, level="full"):
    return {row.cell.invariance: row for row in invariances(case, engine, Study(level))}


def failed(found):
    return {name for name, row in found.items() if row.verdict is Verdict.FAIL}


def test_a_sphere_on_a_wall_goes_through_all_that_concerns_it(lammps):
    found = rows(lammps, few("oblique", ["mindlin_rescale/force"], ["wall"]))
    assert found.keys() == BOTH | OF_LAMMPS | {"axes exchanged"}
    assert failed(found) == {"continued with a setup"}  # its dashpot: the manual says so
    assert {row.kind for row in found.values()} == {Kind.INVARIANCE}
    # derived widths stay far below what a fault makes, and bits are bits
    assert all(row.tolerance < 1e-9 for row in found.values())
    for exact in ("newton on", "restarted", "continued without setup"):
        assert found[exact].tolerance == found[exact].value == 0.0
    assert found["mirrored"].value == 0.0  # LAMMPS rounds signs alike
    assert found["restarted"].note.startswith("against 'continued with a setup'")


def test_two_spheres_are_renumbered_and_elastic_ones_go_back_in_time(lammps):
    found = rows(lammps, few("head-on", ["hertz"], ["unequal spheres"]))
    assert found.keys() == BOTH | OF_LAMMPS | {SORTED, "renumbered", "reversed in time"}
    assert failed(found) == set()


def test_prescribed_motion_is_restarted_between_two_pieces(lammps):
    found = rows(lammps, few("prescribed-motion", ["mindlin"], ["unequal spheres"]))
    assert found.keys() == (BOTH | OF_LAMMPS | {SORTED, "renumbered"}) - {
        "continued without setup",
        "continued with a setup",
    }
    assert failed(found) == set()


@pytest.mark.parametrize("submodel", ["rolling sds, mindlin", "twisting sds, linear_history"])
def test_springs_that_turn_round_are_found_on_one_rank_with_defaults_and_by_a_sort(
    lammps, monkeypatch, submodel
):
    case = few("prescribed-motion", [submodel], ["unequal spheres"])
    found = rows(lammps, case)
    assert failed(found) == {DEFAULTS, SORTED}
    versions = {"lammps": lammps.identify().engine_version}
    both = [found[name] for name in (DEFAULTS, SORTED)]
    for told in mark_known_defects(both, known_defects(), versions):
        assert (told.verdict, told.cell.defect) == (
            Verdict.KNOWN_DEFECT,
            "rolling-turned-round-by-defaults",
        )
        assert told.value > 1e4 * told.tolerance
        assert "largest difference: torque" in told.note
    # what breaks it is the exchange: carried along as far, never sorted, nothing changes
    monkeypatch.setattr(OneRank, "besides", {"sort": "0 0", "defaults": "no"})
    assert failed(rows(lammps, case)) == set()
    # of another size, it is no known defect
    wrong = replace(found[SORTED], value=1.0)
    (told,) = mark_known_defects([wrong], known_defects(), versions)
    assert told.verdict is Verdict.FAIL


def test_every_variation_that_changes_a_law_fails(lammps, monkeypatch):
    monkeypatch.setattr(OneRank, "besides", {"friction": 0.3 * (1.0 + 1e-9)})
    found = rows(lammps, few("oblique", ["mindlin_rescale/force"], ["wall"]))
    # both the run again and the restarted one slide by the other friction
    assert failed(found) == OF_LAMMPS - {"restarted"}


def test_a_restart_that_forgets_springs_fails(lammps):
    """The old pair styles do, in a session that had others."""
    found = rows(lammps, few("oblique", ["old hooke/history"], ["unequal spheres"]))
    assert "restarted" in failed(found)
    assert found["restarted"].value > 0.1


def test_a_view_that_leaves_something_behind_fails(lammps, monkeypatch):
    rolling = few("incline-roll", ["linear_history"], ["wall, slides"])
    assert "turned" not in failed(rows(lammps, rolling))
    with monkeypatch.context() as fault:
        fault.setattr(transformations.View, "_plane", lambda _, plane: plane)
        assert failed(rows(lammps, rolling)) >= {"turned", "axes exchanged"}
    spinning = few("spin", ["mindlin"], ["unequal spheres"])
    with monkeypatch.context() as fault:
        fault.setattr(transformations.View, "_axial", transformations.View._polar)
        assert failed(rows(lammps, spinning)) >= {"mirrored"}
    with monkeypatch.context() as fault:
        fault.setitem(transformations.DIMENSIONS, "youngs_modulus", (0, 1, -2))
        assert failed(rows(lammps, spinning)) >= {"in other units"}
    with monkeypatch.context() as fault:
        fault.setattr(transformations.Renumbered, "back", lambda _, motion: motion)
        assert failed(rows(lammps, spinning)) >= {"renumbered"}
    with monkeypatch.context() as fault:
        fault.setattr(
            transformations.View,
            "_seen",
            lambda view, v: transformations.scaled(view._polar(v), 1.0),
        )
        assert failed(rows(lammps, spinning)) >= {"moved"}
    with monkeypatch.context() as fault:
        fault.setattr(transformations, "_reversible", lambda law, scene: True)  # noqa: ARG005
        assert failed(rows(lammps, few("head-on", ["hertz, viscoelastic"], ["wall"]))) >= {
            "reversed in time"
        }


def test_a_run_that_leaves_no_numbers_is_not_tested(lammps):
    (row,) = rows(lammps, few("head-on", ["old hooke, no damping"], ["wall"])).values()
    if row.verdict is Verdict.PASS:
        pytest.skip("this release has the wall right")
    assert row.verdict is Verdict.NOT_TESTED
    assert row.note.startswith("the run as it stands is missing: LAMMPS wrote a series")


def test_what_an_engine_refuses_is_not_tested_for_the_same_reason_as_its_values(
    lammps, monkeypatch
):
    monkeypatch.setattr(lammps, "refuses", lambda _: "LAMMPS 1 has no mdr: LAMMPS 2 has it")
    (row,) = rows(lammps, few("head-on", ["mdr"], ["wall"])).values()
    assert (row.verdict, row.cell.invariance) == (Verdict.NOT_TESTED, "all")
    assert row.note == "LAMMPS 1 has no mdr: LAMMPS 2 has it"


@pytest.mark.parametrize("submodel", ["mdr", "mdr, yield", "mdr, bulk"])
def test_a_change_of_ten_widths_in_a_run_of_mdr_is_found(lammps, monkeypatch, submodel):
    case = few("head-on", [submodel], ["wall"])
    found = rows(lammps, case)
    if found["continued without setup"].verdict is Verdict.NOT_TESTED:
        pytest.skip("this release has no mdr")
    name = "over a periodic boundary"
    assert found[name].verdict is Verdict.PASS
    young = 1e8 * (1.0 + 10.0 * found[name].tolerance)
    monkeypatch.setattr(OneRank, "besides", {"youngs_modulus": young})
    assert name in failed(rows(lammps, case))


def test_a_radius_that_grows_is_late_over_a_periodic_boundary_which_is_known(lammps):
    found = rows(lammps, few("head-on", ["mdr, yield"], [EQUAL]))
    if found["continued without setup"].verdict is Verdict.NOT_TESTED:
        pytest.skip("this release has no mdr")
    assert failed(found) == {"over a periodic boundary", "restarted"}
    late = found["over a periodic boundary"]
    assert late.value > 100.0 * late.tolerance
    versions = {"lammps": lammps.identify().engine_version}
    (told,) = mark_known_defects([late], known_defects(), versions)
    assert "mdr-radius-late-on-ghosts" in told.note


def test_what_an_engine_cannot_be_told_is_not_tested(lammps, monkeypatch):
    monkeypatch.setattr(OneRank, "besides", {"no_such": 1})
    found = rows(lammps, few("oblique", ["mindlin"], ["wall"]))
    assert {n for n, r in found.items() if r.verdict is Verdict.NOT_TESTED} == OF_LAMMPS
    assert "has no variable 'no_such'" in found["newton on"].note


def test_ranks_need_a_launcher_of_their_own(lmp):
    with (
        Lammps(lmp=lmp, launcher="mpirun -n 1") as engine,
        pytest.raises(EngineMissingError, match="has ranks of its own"),
    ):
        engine.on_ranks(2)


@pytest.mark.slow
def test_ranks_change_no_bit_and_a_fault_on_them_is_seen(lmp, monkeypatch):  # noqa: ARG001
    case = few("oblique", ["mindlin_rescale/force"], ["unequal spheres"])
    with Lammps(workers=1) as engine:
        found = rows(engine, case)
        assert {found[f"{ranks} ranks"].verdict for ranks in (2, 4)} == {Verdict.PASS}
        assert {found[f"{ranks} ranks"].tolerance for ranks in (2, 4)} == {0.0}
        true = Lammps.variations

        def wrong(self, job, ends):
            found = (told for told in true(self, job, ends) if told.ranks == 2)
            return [replace(told, values={**told.values, "friction": 0.31}) for told in found]

        monkeypatch.setattr(Lammps, "variations", wrong)
        assert failed(rows(engine, case)) == {"2 ranks"}
