"""Contact cases at equal steps: what turns a row, in a stand-in for an engine and in LAMMPS."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.contact.contact_case import STEPS, ContactCase
from harness.cases.contact.verification import TrialRun, judged, verify_trials
from harness.cases.registry import built_in, get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Kind, Verdict
from harness.engines.lammps.engine import Lammps
from harness.engines.reference import Reference
from harness.errors import EngineError, EngineLostAtomsError, EngineNaNError, EngineOutputError
from harness.model.law import COEFFICIENTS
from harness.solvers import reference

CASES = [case for case in map(get_case, built_in()) if isinstance(case, ContactCase)]


class Stepped(Reference):
    """The reference with a change of each scene, or of each motion, in the place of an engine."""

    name = "stepped"

    def __init__(self, scenes=lambda scene: scene, samples=lambda motion: motion):
        super().__init__(workers=1)
        self.scenes, self.samples = scenes, samples

    def motions(self, jobs):
        return [self.samples(reference.run(self.scenes(job.scene))) for job in jobs]


def verdicts(engine, case, trials):
    """Return the judged rows of trials in an engine."""
    rows = verify_trials(case, engine, Study("quick"), trials).checks
    return [row for row in rows if row.kind is not Kind.FINDING]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_reference_itself_passes_and_each_trial_leaves_rows(case):
    trials = list(case.trials("quick"))
    assert {trial.parameters.steps_per_contact for trial in trials} == {STEPS}
    rows = verdicts(Stepped(), case, trials)
    assert {row.verdict for row in rows} == {Verdict.PASS}
    assert {(row.cell.submodel, row.cell.system) for row in rows} == {
        (trial.submodel, trial.system) for trial in trials
    }
    assert all(row.difference == 0.0 for row in rows)


def changes(scene):
    """Yield scenes with one coefficient, radius, mass or velocity off by 1e-6, by its name."""
    for name in sorted(COEFFICIENTS):
        value = getattr(scene.law, name)
        if value:
            yield name, scene.replace(law=scene.law.replace(**{name: value * (1 + 1e-6)}))
    body, *rest = scene.bodies
    for name in ("radius", "mass"):
        other = body.replace(**{name: getattr(body, name) * (1 + 1e-6)})
        yield name, scene.replace(bodies=(other, *rest))


UNSEEN = {  # by case: nothing slides there, or overlaps and masses have no part in it
    "bounce": {"friction"},
    "curved-wall": {"friction", "tangential_stiffness"},
    "drag": {"normal_stiffness", "radius"},
    "head-on": {"friction"},
    "heat": {"normal_stiffness", "poisson_ratio", "youngs_modulus"},
    "incline-rest": {"friction"},
    "incline-roll": {"normal_stiffness"},
    "moving-wall": {"tangential_stiffness"},
    "pull-off": {"mass"},
    "rolling-resistance": {"friction"},
}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_is_off_by_a_millionth_turns_a_row(case):
    turned, moved = set(), set()
    for trial in case.trials("quick"):
        scene = case.setup(trial.parameters)
        run = TrialRun(case, trial, "stepped", "", scene, reference.Rules(), reference.run(scene))
        for name, changed in changes(scene):
            moved.add(name)
            try:
                outcome = reference.run(changed)
            except EngineError as error:
                outcome = error
            if Verdict.FAIL in {row.verdict for row in judged(replace(run, outcome=outcome))}:
                turned.add(name)
    assert moved - turned <= UNSEEN.get(case.name, set())


def lost(motion):
    return replace(
        motion, **{n: getattr(motion, n)[:-1] for n in ("time", "position", "velocity")},
        angular_velocity=motion.angular_velocity[:-1], force=motion.force[:-1],
        torque=motion.torque[:-1],
    )  # fmt: skip


def not_a_number(motion):
    velocity = motion.velocity.copy()
    velocity[-1, 0, 2] = math.nan
    return replace(motion, velocity=velocity)


def swapped(motion):
    return replace(motion, velocity=np.roll(motion.velocity, 1, axis=2))


@pytest.mark.parametrize(
    ("fault", "note"), [(lost, "samples"), (not_a_number, "NaN"), (swapped, "")]
)
def test_samples_that_are_lost_swapped_or_no_numbers_fail(fault, note):
    case = get_case("oblique")
    trial = next(iter(case.trials("quick")))
    rows = verdicts(Stepped(samples=fault), case, [trial])
    assert Verdict.FAIL in {row.verdict for row in rows}
    assert any(note in row.note for row in rows)


def test_a_run_that_dies_is_a_row_and_others_go_on():
    case = get_case("head-on")
    trials = list(case.trials("quick"))[:3]

    class Dies(Stepped):
        def motions(self, jobs):
            _, *rest = super().motions(jobs)
            return [EngineLostAtomsError("lost one"), *rest]

    dead, *others = verdicts(Dies(), case, trials)
    assert (dead.verdict, dead.engine_died) == (Verdict.FAIL, True)
    assert {row.verdict for row in others} == {Verdict.PASS}


def test_what_an_engine_does_not_state_is_not_tested_with_its_reason():
    case = get_case("head-on")
    engine = Stepped()
    engine.traits = replace(engine.traits, conventions=None)
    rows = verdicts(engine, case, list(case.trials("quick"))[:2])
    assert {row.verdict for row in rows} == {Verdict.NOT_TESTED}


def test_a_failure_names_the_convention_under_which_it_holds():
    case = get_case("oblique")
    trials = [t for t in case.trials("quick") if t.submodel == "linear_history"]

    class Other(Stepped):
        def motions(self, jobs):
            rules = reference.Rules(wall_lever="height", velocity_lever="contact_point")
            return [reference.run(job.scene, rules) for job in jobs]

    rows = verdicts(Other(), case, trials)
    failed = [row for row in rows if row.verdict is Verdict.FAIL]
    assert failed
    assert all("passes under" in row.note for row in failed)


@pytest.fixture(scope="module")
def lammps():
    with Lammps(workers=1) as engine:
        yield engine


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
@pytest.mark.parametrize("name", ["drag", "heat", "moving-wall", "curved-wall", "lj-units"])
def test_single_contacts_hold_in_lammps(lammps, name):
    case = get_case(name)
    trials = [trial for trial in case.trials("default") if trial.submodel != "mindlin, jkr"]
    rows = verdicts(lammps, case, trials)
    assert {row.verdict for row in rows} == {Verdict.PASS}


@pytest.mark.live
@pytest.mark.usefixtures("lammps_here")
def test_in_units_lj_no_bit_of_a_ratio_is_another(lammps):
    case, si = get_case("lj-units"), get_case("oblique")
    for trial in case.trials("default"):
        there, here = lammps.run([case.job(trial.parameters), si.job(trial.parameters)])
        ratios = case.read(trial.parameters, there, lammps.traits)
        assert ratios == si.read(trial.parameters, here, lammps.traits), trial.submodel


@pytest.mark.parametrize("error", [EngineNaNError("NaN"), EngineOutputError("cut")])
def test_an_error_of_an_output_is_a_failure(error):
    case = get_case("drag")
    trial = next(iter(case.trials("quick")))
    scene = case.setup(trial.parameters)
    (row,) = judged(TrialRun(case, trial, "stepped", "", scene, reference.Rules(), error))
    assert row.verdict is Verdict.FAIL
