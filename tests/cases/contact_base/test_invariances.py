"""Invariances in LAMMPS: what holds, what its defects break, and that a fault of each is seen."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from harness.cases.contact import invariance, transformations
from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.invariance import invariances
from harness.cases.contact.motion import motion_of
from harness.cases.contact.submodels import Trial
from harness.cases.contact.transformations import EQUAL, chosen
from harness.cases.registry import all_cases, get_case
from harness.cases.verification import Study
from harness.comparison.known_defects import mark_known_defects
from harness.comparison.verdicts import Kind, Verdict
from harness.engines.lammps.engine import DEFAULTS, SORTED, Lammps, variations
from harness.engines.output import SERIES
from harness.errors import EngineMissingError
from harness.observables.provenance import release_of
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


class Single(OneRank):
    """LAMMPS as a code that writes single precision and no forces."""

    traits: ClassVar = replace(Lammps.traits, digits=7)

    def run(self, jobs):
        outputs = super().run(jobs)
        for output in outputs:
            series = output.tables[SERIES]
            output.tables[SERIES] = {
                name: column.astype(np.float32).astype(float)
                for name, column in series.items()
                if name[:2] not in ("fx", "fy", "fz", "tx", "ty", "tz")
            }
        return outputs


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


@pytest.mark.parametrize("system", [EQUAL, "unequal spheres"])
def test_lammps_s_default_sort_alone_exchanges_a_carried_pair_while_it_rolls(lammps, system):
    """One sort in 1000 steps: which takes more steps than the other invariances have."""
    case = few("prescribed-motion", ["rolling sds, linear_history"], [system])
    (trial,) = [t for t in chosen(case, "full") if t.system == system]
    one = transformations.first_runs(case, trial, "full")
    invariance._run([one], lammps)
    carried, motion = one.runs[transformations.CARRIED], one.motion(transformations.CARRIED)
    assert carried.scene.steps == transformations.MANY > 4000
    ends = motion.position[[0, -1]].mean(axis=1)
    (told,) = (v.values for v in variations(carried.job, ends.tolist()) if v.name == SORTED)
    jobs = [
        replace(carried.job, values={**carried.job.values, **told, "sort": sort})
        for sort in ("0 0", "1000 0")
    ]
    never, by_default = (motion_of(output, carried.scene) for output in lammps.run(jobs))
    apart = np.abs(by_default.torque - never.torque).max()
    assert apart > 5e-3 * np.abs(never.torque).max()
    assert np.abs(by_default.force - never.force).max() < 1e-9 * np.abs(never.force).max()


def test_the_shortest_level_takes_a_few(lammps):
    found = rows(lammps, few("oblique", ["linear_history"], ["wall", "unequal spheres"]), "quick")
    assert found.keys() == {"turned", "restarted"}
    found = rows(lammps, few("oblique", ["mindlin_rescale/force"], ["wall"]), "quick")
    assert found.keys() == {"turned", "continued with a setup", "restarted"}


def test_every_variation_that_changes_a_law_fails(lammps, monkeypatch):
    monkeypatch.setattr(OneRank, "besides", {"friction": 0.3 * (1.0 + 1e-9)})
    found = rows(lammps, few("oblique", ["mindlin_rescale/force"], ["wall"]))
    # both the run again and the restarted one slide by the other friction
    assert failed(found) == OF_LAMMPS - {"restarted"}


def test_a_code_that_writes_few_digits_and_no_forces_is_held_to_those(monkeypatch):
    case = few("oblique", ["mindlin_rescale/force"], ["wall"])
    with Single(workers=1) as engine:
        found = rows(engine, case)
        # the digits do not show what LAMMPS's defect "continued with a setup" makes of 20 steps
        assert failed(found) <= {"continued with a setup"}
        assert found["turned"].value > 0.0
        assert all(1e-6 < row.tolerance < 1e-3 for row in found.values() if row.tolerance)
        monkeypatch.setattr(OneRank, "besides", {"friction": 0.3 * 1.01})
        assert "newton on" in failed(rows(engine, case))


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


class Forceless(OneRank):
    """LAMMPS whose bodies pass through one another, as mixed types did by 23 Jun 2022."""

    def run(self, jobs):
        outputs = super().run(jobs)
        for output in outputs:
            series = output.tables[SERIES]
            for name in series:
                if name[:2] in ("fx", "fy", "fz", "tx", "ty", "tz"):
                    series[name] = np.zeros_like(series[name])
        return outputs


def test_a_run_without_any_force_is_not_tested_and_costs_no_other_row():
    """Differences would be measured in an overlap of nothing."""
    case = few("head-on", ["hertz"], ["two spheres"])
    with Forceless(workers=1) as engine:
        found = rows(engine, case)
    judged = {name: row.verdict for name, row in found.items()}
    assert {*judged.values()} == {Verdict.NOT_TESTED}
    assert len(judged) > 10
    assert "no sample of the run as it stands has a force" in found["moved"].note


def test_what_an_engine_refuses_is_not_tested_for_the_same_reason_as_its_values(
    lammps, monkeypatch
):
    monkeypatch.setattr(lammps, "refuses", lambda _: "LAMMPS 1 has no mdr: LAMMPS 2 has it")
    (row,) = rows(lammps, few("head-on", ["mdr"], ["wall"])).values()
    assert (row.verdict, row.cell.invariance) == (Verdict.NOT_TESTED, "all")
    assert row.note == "LAMMPS 1 has no mdr: LAMMPS 2 has it"


ROUNDED = BOTH | {"axes exchanged", "over a periodic boundary"}


def at(speed, names=("mdr",), systems=("wall",)):
    """Return head-on impacts of a speed [m/s]."""
    case = few("head-on", names, systems)
    case.sets = {"usual": {"speed": speed}}
    return case


@pytest.mark.parametrize("speed", [0.01, 0.1, 1.0, 3.0])
def test_mdr_stays_within_the_width_of_its_lost_digits_at_every_scale(lammps, speed):
    found = rows(lammps, at(speed))
    if found["continued without setup"].verdict is Verdict.NOT_TESTED:
        pytest.skip("this release has no mdr")
    assert (
        found["continued without setup"].verdict,
        found["continued without setup"].tolerance,
    ) == (Verdict.PASS, 0.0)
    for name in ROUNDED:
        assert found[name].verdict is Verdict.PASS
        assert 0.0 < found[name].tolerance < 1e-7
        assert "loses digits" in found[name].why
    assert found["turned"].value > 1e-3 * found["turned"].tolerance
    assert found["newton on"].note == "its mdr takes newton = off, not on"
    assert "reversed in time" not in found


def test_where_the_digits_of_mdr_are_lost_it_is_not_judged_and_says_by_how_much(lammps):
    found = rows(lammps, at(1e-4))
    if found["continued without setup"].verdict is Verdict.NOT_TESTED:
        pytest.skip("this release has no mdr")
    for name in ROUNDED:
        assert found[name].verdict is Verdict.NOT_TESTED
        assert "that may move it by " in found[name].note
        assert "more than 1e-06" in found[name].note
    assert found["continued without setup"].verdict is Verdict.PASS


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


@pytest.mark.parametrize(("level", "expected"), [("quick", {"wall"}), ("default", {"wall", EQUAL})])
def test_a_law_of_equal_spheres_goes_through_these_in_place_of_unequal_ones(level, expected):
    trials = chosen(get_case("head-on"), level)
    assert {one.system for one in trials if one.submodel == "mdr, yield"} == expected


def test_the_shortest_level_carries_one_pair_with_friction_and_one_that_rolls(lammps):
    """The second has a known defect there; a spring of shear that was turned round would fail."""
    versions = {"lammps": lammps.identify().engine_version}
    found = invariances(get_case("prescribed-motion"), lammps, Study("quick"))
    carried = {row.cell.submodel: row for row in found if row.cell.invariance == DEFAULTS}
    assert set(carried) == {"mindlin", "rolling sds, mindlin"}
    assert carried["mindlin"].verdict is Verdict.PASS
    rolling = carried["rolling sds, mindlin"]
    (told,) = mark_known_defects([rolling], known_defects(), versions)
    assert told.verdict is Verdict.KNOWN_DEFECT
    assert told.cell.defect == "rolling-turned-round-by-defaults"
    # twice the force of friction, of the normal force
    turned = replace(rolling, value=2.0 * 0.2)
    assert mark_known_defects([turned], known_defects(), versions)[0].verdict is Verdict.FAIL


def test_a_spring_of_shear_that_an_order_turns_round_is_seen_at_the_shortest_level(lammps):
    case = get_case("prescribed-motion")
    (trial,) = [t for t in chosen(case, "quick") if (t.submodel, t.system) == ("mindlin", EQUAL)]
    one = transformations.first_runs(case, trial, "quick")
    invariance._run([one], lammps)
    later = {way.name: way for way in transformations.later_runs(one, lammps, "quick")}
    one.runs |= {DEFAULTS: later[DEFAULTS]}
    invariance._run([one], lammps)
    (held,) = invariance._rows(one, lammps, lambda way: way.name == DEFAULTS)
    assert held.verdict is Verdict.PASS
    motion = one.motions[DEFAULTS]
    force = motion.force.copy()
    along = motion.position[:, :1] - motion.position[:, 1:]
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    normal = (force * along).sum(axis=2, keepdims=True) * along
    force[-1] = (2.0 * normal - force)[-1]
    one.motions[DEFAULTS] = replace(motion, force=force)
    (broken,) = invariance._rows(one, lammps, lambda way: way.name == DEFAULTS)
    assert broken.verdict is Verdict.FAIL


def test_what_an_engine_cannot_be_told_is_not_tested(lammps, monkeypatch):
    monkeypatch.setattr(OneRank, "besides", {"no_such": 1})
    found = rows(lammps, few("oblique", ["mindlin"], ["wall"]))
    assert {n for n, r in found.items() if r.verdict is Verdict.NOT_TESTED} == OF_LAMMPS
    assert "has no variable 'no_such'" in found["newton on"].note


@pytest.mark.parametrize(
    ("submodel", "level", "most"),
    [("hooke", "default", 1), ("jkr", "default", 2), ("hooke", "full", 4), ("jkr", "full", 4)],
)
def test_level_full_takes_every_submodel_over_four_ranks(submodel, level, most):
    case = get_case("head-on")
    assert invariance._most_ranks(case, Trial(submodel, "wall", case.default), level) == most


def test_the_force_at_touch_is_left_out_where_a_motion_begins_there(lammps):
    case = few("prescribed-motion", ["twisting sds, mindlin"], ["unequal spheres"])
    (trial,) = [t for t in chosen(case, "full") if t.system == "unequal spheres"]
    one = transformations.first_runs(case, trial, "full")
    invariance._run([one], lammps)
    motion = one.motion(transformations.PLAIN)
    first = (np.arange(len(motion.force)) == 0)[:, None, None]
    moved = replace(motion, force=motion.force + 1.0 * first)
    sizes = dict.fromkeys(("position", "velocity", "omega", "force", "torque"), 1.0)
    assert invariance.difference(motion, moved, sizes)["force"] == 1.0
    assert invariance.difference(motion, moved, sizes, 1)["force"] == 0.0


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


CONTACTS = tuple(case for case in all_cases().values() if isinstance(case, ContactCase))


def one_each(key):
    """Return trials of level full by case: of those of one submodel and key the next in turn."""
    alike, wanted = {}, {}
    for case in CONTACTS:
        for trial in chosen(case, "full"):
            alike.setdefault((trial.submodel, key(trial.system)), []).append((case.name, trial))
    for number, trials in enumerate(alike.values()):
        name, trial = trials[number % len(trials)]
        wanted.setdefault(name, []).append(trial)
    return wanted


def found_at_full(monkeypatch, engine, wanted, invariances):
    """Return what is found of some trials in LAMMPS; skip where other defects may be in it."""
    version = engine.identify().engine_version
    if not release_of("29 Aug 2024") <= release_of(version) <= release_of("22 Jul 2025 - 9"):
        pytest.skip(f"LAMMPS {version} may have other defects")
    monkeypatch.setattr(invariance, "chosen", lambda case, _: wanted.get(case.name, []))
    told = mark_known_defects(invariances(Study("full")), known_defects(), {"lammps": version})
    unexpected = (Verdict.FAIL, Verdict.FIXED)
    assert [(row.name, row.verdict) for row in told if row.verdict in unexpected] == []
    return told


@pytest.mark.slow
def test_every_submodel_and_system_is_invariant_but_for_known_defects(monkeypatch):
    wanted = one_each(lambda system: system)
    with OneRank(workers=2) as engine:
        told = found_at_full(
            monkeypatch, engine, wanted,
            lambda study: [row for case in CONTACTS for row in invariances(case, engine, study)],
        )  # fmt: skip
    passed = sum(row.verdict is Verdict.PASS for row in told)
    assert passed > 4 * sum(map(len, wanted.values()))


@pytest.mark.slow
@pytest.mark.timeout(1200)  # four ranks that poll on two cores
def test_ranks_change_no_bit_of_any_submodel_but_for_known_defects(lmp, monkeypatch):  # noqa: ARG001
    """What ranks exchange are a submodel's values of pairs and of walls, whatever the motion."""
    wanted = one_each(lambda system: next(w for w in ("plates", "wall", "") if w in system))
    with Lammps() as engine:
        told = found_at_full(
            monkeypatch, engine, wanted,
            lambda study: invariance._all_over_ranks(CONTACTS, engine, study),
        )  # fmt: skip
    for ranks in ("2 ranks", "4 ranks"):
        seen = [row for row in told if row.cell.invariance == ranks]
        passed = sum(row.verdict is Verdict.PASS for row in seen)
        assert passed > 0.5 * sum(map(len, wanted.values()))
