"""Checks of the contact cases: one row of each, planted faults that turn rows; their pages."""

from dataclasses import replace

import numpy as np
import pytest

from harness.cases.bench import OWN, Bench
from harness.cases.checks import equal_steps_checks, run_checks, selected
from harness.cases.contacts import report
from harness.cases.contacts.contact_case import MOTION, STEPS
from harness.engines.lammps.engine import Lammps
from harness.errors import EngineLostAtomsError, Unsupported
from harness.model.conventions import Rules
from harness.results.rows import Failure, Kind, Verdict
from tests.cases.common import rows_of, verdicts
from tests.cases.contacts.common import CASES, case_named, one_of_each, twin
from tests.cases.scene_faults import grain, scaled
from tests.engine_doubles import FewDigits, Twin, lost, single


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_reference_itself_passes_and_each_trial_of_quick_has_rows(case):
    trials = [trial for trial in case.trials if trial.level == "quick"]
    assert len({trial.setup for trial in case.trials}) == len(case.trials)
    assert {trial.parameters.steps_per_contact for trial in trials} == {STEPS}
    rows = rows_of(case, twin())
    assert verdicts(rows) == {Verdict.PASS}
    assert {row.kind for row in rows} == {Kind.CROSS_CODE}
    assert all(row.difference == 0.0 and row.reason for row in rows)
    assert {row.setup for row in rows} == {trial.setup for trial in trials}
    for trial in trials:
        names = [row.quantity for row in rows if row.setup == trial.setup]
        assert names == [*case.names(trial.parameters), MOTION]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_scales_are_sizes_that_quantities_have(case):
    """No scale exceeds three times the largest value of its case, but of what must be zero."""
    zero = {"momentum_change_ratio", "heat_change_ratio", "surface_momentum_ratio"}
    unseen = {quantity.name for quantity in case.quantities} - zero
    for trial in (*one_of_each(case), *case.trials):
        p = trial.parameters
        values = case.reference(p, Bench(None)).items() if unseen else ()
        unseen -= {n for n, value in values if 3.0 * abs(value) >= case.quantity(n).size(p)}
    assert not unseen


# ---- planted faults


def not_a_number(_, motion):
    motion.velocity[-1, 0, 2] = np.nan
    return motion


def never_written(_, motion):
    """Return a motion without a component that no quantity of the case reads."""
    motion.torque[:, :, 2] = np.nan
    return motion


def swapped(_, motion):
    return replace(motion, velocity=np.roll(motion.velocity, 1, axis=2))


def shifted(_, motion):
    return replace(motion, velocity=np.roll(motion.velocity, 1, axis=0))


def flown_by(_, motion):
    """Return a motion without a contact."""
    still = np.zeros_like(motion.force)
    return replace(motion, force=still, velocity=np.tile(motion.velocity[0], (len(motion), 1, 1)))


def steeper(scene):
    first, *rest = scene.bodies
    x, y, z = first.velocity
    return scene.replace(bodies=(first.replace(velocity=(x * (1.0 + 1e-6), y, z)), *rest))


OUTSIDE = Failure.OUT_OF_TOLERANCE
FAULTS = {  # fault: case, the engine with it, the class of its failure
    "a sample lost": ("oblique", twin(change_motion=lost), Failure.ENGINE),
    "a NaN": ("oblique", twin(change_motion=not_a_number), Failure.NOT_A_NUMBER),
    "a column never written": ("oblique", twin(change_motion=never_written), Failure.NOT_A_NUMBER),
    "columns swapped": ("oblique", twin(change_motion=swapped), OUTSIDE),
    "samples shifted": ("slip-to-roll", twin(change_motion=shifted), OUTSIDE),
    "no contact": ("pull-off", twin(change_motion=flown_by), Failure.ENGINE),
    "a longer step": ("head-on", twin(scaled("step", 1.0 + 1e-6)), OUTSIDE),
    "a heavier body": ("stacked", twin(grain("mass", 1.0 + 1e-6)), OUTSIDE),
    "another angle": ("oblique", twin(steeper), OUTSIDE),
    "another lever": ("spin", twin(followed=Rules(wall_lever="height")), OUTSIDE),
    "another scheme": ("drag", twin(followed=Rules(scheme="mfix_euler")), OUTSIDE),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_turns_a_row(fault):
    name, engine, failure = FAULTS[fault]
    failures = {row.failure for row in rows_of(case_named(name), engine)}
    assert failure in failures
    assert Failure.HARNESS not in failures


def late(_, motion):
    """Return a motion whose samples are one late; one that is frozen differs by more."""
    chosen = np.maximum(np.arange(len(motion)) - 1, 0)
    arrays = {n: a[chosen] for n, a in vars(motion).items() if n != "time" and a is not None}
    return replace(motion, **arrays)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_run_of_quick_shows_samples_that_are_late(case):
    rows = rows_of(case, twin(change_motion=late))
    failing = {row.setup for row in rows if row.verdict is Verdict.FAIL}
    assert failing == {row.setup for row in rows}
    assert not any(row.failure is Failure.HARNESS for row in rows)


@pytest.mark.parametrize(
    "name", ["head-on", "slip-to-roll", "collision", "curved-wall", "pull-off"]
)
def test_a_code_with_few_digits_is_held_to_what_they_resolve(name):
    rows = rows_of(case_named(name), FewDigits(declared=Rules()))
    assert verdicts(rows) == {Verdict.PASS}
    assert all("7 digits" in row.reason for row in rows)


@pytest.mark.parametrize("engine", [
    FewDigits(scaled("step", 0.999), single, declared=Rules()), twin(change_motion=single),
], ids=["a longer step", "it does not say so"])  # fmt: skip
def test_a_fault_of_a_code_with_few_digits_turns_a_row(engine):
    for name in ("curved-wall", "pull-off"):
        assert Verdict.FAIL in verdicts(rows_of(case_named(name), engine))


def test_a_plug_in_case_is_held_to_what_few_digits_resolve():
    case, engine = case_named("curved-wall"), FewDigits(declared=Rules())
    setups = {trial.setup: trial.parameters for trial in one_of_each(case)}
    rows = run_checks(case.name, [*equal_steps_checks(case, engine, setups)], Bench(engine))
    judged = {row.verdict for row in rows} - {Verdict.NOT_TESTED}
    assert judged == {Verdict.PASS}
    assert all("7 digits" in row.reason for row in rows if row.verdict is Verdict.PASS)


def test_a_rounding_of_the_start_turns_the_rows_of_bodies_that_just_touch_alone():
    def rounded(scene):
        (x, y, z), (first, *others) = scene.bodies[0].position, scene.bodies
        return scene.replace(bodies=(first.replace(position=(x, y, z * (1.0 - 1e-15))), *others))

    for name in ("prescribed-motion", "pull-off", "oblique"):
        rows = rows_of(case_named(name), twin(rounded))
        failing = {row.setup for row in rows if row.verdict is Verdict.FAIL}
        assert failing == {row.setup for row in rows if row.setup.endswith("wall, at touch")}


def forgetting(*parts):
    """Return an engine that does not write some parts of a motion."""
    return twin(change_motion=lambda _, motion: replace(
        motion, **{name: np.full_like(motion.force, np.nan) for name in parts}))  # fmt: skip


@pytest.mark.parametrize("parts", [("force",), ("torque",), ("force", "torque")], ids="-".join)
def test_what_needs_forces_is_not_tested_in_a_code_that_writes_none(parts):
    reason = f"Twin writes no {' and no '.join(parts)}"
    rows = rows_of(case_named("oblique"), forgetting(*parts))
    assert verdicts(rows) == {Verdict.PASS}  # by velocities
    assert {row.note for row in rows if row.quantity == MOTION} == {reason}
    rows = rows_of(case_named("prescribed-motion"), forgetting(*parts))
    of_both = {Verdict.PASS, Verdict.NOT_TESTED} if len(parts) == 1 else {Verdict.NOT_TESTED}
    assert verdicts(rows) == of_both
    assert {row.note for row in rows if row.verdict is Verdict.NOT_TESTED} == {reason}


def test_a_wrong_motion_fails_in_a_code_that_writes_no_forces():
    def wrong(_, motion):
        unknown = np.full_like(motion.force, np.nan)
        return replace(swapped(_, motion), force=unknown, torque=unknown)

    rows = rows_of(case_named("oblique"), twin(change_motion=wrong))
    assert {row.verdict for row in rows if row.quantity == MOTION} == {Verdict.FAIL}


def test_a_run_that_dies_fails_its_own_rows_and_others_go_on():
    case = case_named("head-on")
    first = case.trials[0]
    rows = rows_of(case, twin(change_motion=lambda scene, motion: (
        EngineLostAtomsError("lost one") if scene == first.scene else motion)))  # fmt: skip
    assert {row.setup for row in rows if row.verdict is Verdict.FAIL} == {first.setup}
    assert {row.verdict for row in rows if row.setup == first.setup} == {Verdict.FAIL}


def test_a_scene_that_an_engine_refuses_is_one_row_with_the_reason():
    class Refuses(Twin):
        def rules(self, _):
            raise Unsupported("its walls mix no materials")

    case = case_named("prescribed-motion")
    rows = rows_of(case, Refuses())
    assert verdicts(rows) == {Verdict.NOT_TESTED}
    assert {row.note for row in rows} == {"its walls mix no materials"}
    assert len(rows) == len({row.setup for row in rows})
    varied = {trial.setup for trial in case.trials if trial.varied == "quick"}
    assert varied - {trial.setup for trial in case.trials if trial.level == "quick"}
    assert varied <= {row.setup for row in rows}  # of variations as well


# ---- LAMMPS


@pytest.fixture(scope="module")
def lammps(lmp_binary):
    with Lammps(lmp=lmp_binary, workers=1) as engine:
        yield engine


@pytest.mark.live
@pytest.mark.parametrize("name", ["drag", "heat", "moving-wall", "curved-wall", "lj-units"])
def test_cases_without_known_defects_hold_in_lammps(lammps, name):
    rows = rows_of(case_named(name), lammps)
    failing = {row.setup for row in rows if row.verdict is Verdict.FAIL}
    assert failing <= {t.setup for t in case_named(name).trials if t.law == "mindlin, jkr"}


@pytest.mark.live
def test_variations_of_lammps_hold_and_a_list_thinner_than_the_neck_is_among_them(lammps):
    case = case_named("head-on")
    rows = rows_of(case, lammps, "default", only="head-on/jkr, two spheres/*")
    assert {"thin skin", "newton on", "restarted", ""} <= {row.check for row in rows}
    assert {row.verdict for row in rows if row.check != "restarted"} == {Verdict.PASS}


# ---- pages: what stands in matrices, codes by laws, conventions


def slower(_, motion):
    """Return a motion with velocities off by 1e-3: a code that is wrong everywhere."""
    motion.velocity[1:] *= 1.0 - 1e-3
    return motion


def ran(engine, case, level="quick"):
    """Return a bench in which an engine has run the checks of a case."""
    bench = Bench(engine)
    checks = selected(case.name, case.checks_up_to(engine, level), level)
    run_checks(case.name, checks, bench)
    return bench


@pytest.fixture(scope="module")
def benches():
    case = case_named("slip-to-roll")
    right, wrong = twin(declared=Rules(wall_lever="height")), twin(change_motion=slower)
    right.traits = wrong.traits
    return {"right": ran(right, case), "wrong": ran(wrong, case), OWN: Bench(None)}


def test_a_matrix_has_the_laws_that_were_run_and_how_far_each_is_from_the_reference(benches):
    case = case_named("slip-to-roll")
    section = report.case_section(case, {"right": benches["right"]})
    (table,) = section.tables
    quick = [trial.law for trial in case.trials if trial.level == "quick"]
    assert list(table.frame["law"]) == quick
    assert all(float(cell) <= 1e-9 for cell in table.frame["wall"])
    assert not report.case_section(case_named("drag"), {"right": benches["right"]}).tables


def test_codes_by_laws_count_rows_within_and_beyond_the_tolerance(benches):
    case = case_named("slip-to-roll")
    codes = {name: bench for name, bench in benches.items() if name != OWN}
    table = report.codes_by_laws([case], codes).set_index("law")
    total = sum(len(sizes) for _, sizes in report.differences([case], benches["right"]))
    assert table.loc["all laws", "right"].startswith(f"{total} rows, ")
    assert table.loc["all laws", "wrong"].endswith("beyond")


def test_a_convention_stands_with_its_formula_and_what_it_moves(benches):
    case, bench = case_named("slip-to-roll"), benches["right"]
    bench.notes[case.name] = case.notes(bench)
    table = report.conventions([case], {"right": bench})
    assert list(table["convention"]) == ["wall_lever"]
    assert float(table["moves"][0]) > 1e-4
    assert table["formula"][0]
