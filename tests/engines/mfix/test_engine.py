"""The engine with MFiX's stand-in: its runs are MFiX's scheme, and one that fails is named."""

import shutil
import sys

import numpy as np
import pytest

from harness.cases.drop.case import Drop, DropRun, run_drops
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, Motion
from harness.cases.qualification import qualify
from harness.cases.tower.run import run_towers
from harness.cases.tower.system import start_displacements, timing_of
from harness.comparison.convergence import slope_order
from harness.engines.mfix.engine import CONTACT, MOST_FRAMES, Mfix
from harness.engines.mfix.system import REFERENCE
from harness.engines.reference import Reference
from harness.engines.registry import open_engine
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
    RequestError,
)
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE
from harness.parameters.tower import Tower
from harness.solvers.chain import exact

GOOD = Drop(
    contact=CONTACT.replace(restitution=0.5), speed=1.0, steps_per_contact=100.0, duration=1.0
)
BAD = GOOD.replace(contact=CONTACT.replace(restitution=0.25))
EULER = Reference("mfix-euler")
SINGLE = 2.0**-23


def tower(**changes):
    return Tower(**{"height": 2, "stiffness": 1e5, "law": "overlap", **changes})


def test_without_a_program_it_says_how_to_get_one():
    with pytest.raises(EngineMissingError, match=r"mfix\.netl\.doe\.gov.*--program mfix=PATH"):
        open_engine("mfix")


def test_it_names_its_version_and_another_program_is_refused(stand_in):
    with open_engine("mfix", program=stand_in().program) as engine:
        who = engine.identify()
    assert (who.engine, who.engine_version, who.integrator) == ("mfix", "21.3.2", "mfix-euler")
    # a plain cmake build outside a checkout answers 0.0, in one without tags nothing
    assert {stand_in(how).identify().engine_version for how in ("0.0", "blank")} == {"unversioned"}
    with pytest.raises(EngineMissingError, match=r"not an MFiX solver \(it says: hello"):
        stand_in("another")
    for program in ("pip", "cat", "sh"):
        with pytest.raises(EngineMissingError, match="is not an MFiX solver"):
            open_engine("mfix", program=shutil.which(program) or sys.executable)


def test_it_qualifies_by_what_it_declares(stand_in):
    found = qualify(stand_in())
    assert found.holds, found.failures


@pytest.mark.parametrize(
    ("contact", "said"),
    [
        (CONTACT.replace(restitution=0.0), "a restitution of at least 1e-20"),
        (PLASTIC.replace(tail="attractive", effective_mass="half"), "damping ratio of at most"),
        (SOURCE, "effective_mass = half, not full: --set contact.effective_mass=half"),
        (CLIPPED.replace(effective_mass="half"), "takes tail = attractive, not clipped"),
    ],
    ids=["e = 0", "overdamped", "full mass", "clipped"],
)
def test_a_contact_that_mfix_does_not_have_is_refused(stand_in, contact, said):
    with pytest.raises(RequestError, match=said):
        run_drops(stand_in(), [Drop(contact=contact)])


@pytest.mark.parametrize(
    ("case", "said"),
    [
        (GOOD.replace(steps_per_contact=13.0), "DTSOLID_FACTOR = 9.*: must be at least"),
        (GOOD.replace(duration=2.0 * MOST_FRAMES / 100.0), f"more than {MOST_FRAMES} files"),
    ],
)
def test_a_step_too_coarse_and_too_many_files_are_refused(stand_in, case, said):
    with pytest.raises(RequestError, match=said):
        run_drops(stand_in(), [case])


@pytest.mark.parametrize("case", [GOOD, GOOD.replace(contact=CONTACT, duration=12.0, gravity=9.81)])
def test_a_drop_is_the_reference_dem_in_mfix_s_scheme(stand_in, case):
    (run,), (expected,) = run_drops(stand_in(), [case]), run_drops(EULER, [case])
    assert run.path.time_s == pytest.approx(expected.path.time_s, rel=1e-12)
    # positions to 3.5 m in MFiX's box, from the origin in single precision
    assert np.abs(run.path.y_m - expected.path.y_m).max() < 4 * SINGLE
    assert np.abs(run.path.vy_m_per_s - expected.path.vy_m_per_s).max() < 1e-5


@pytest.mark.parametrize("route", ["passage", "steady"])
def test_an_incline_is_the_reference_dem_in_mfix_s_scheme(stand_in, route):
    """At 0.5 deg without loss it comes to the next crest almost at rest, in a later stretch."""
    case = Incline(contact=CONTACT, steps_per_contact=20.0, stiffness=1e5, wells=2)
    slow = {"contact": CONTACT.replace(restitution=1.0), "stiffness": 1e4, "time_limit": 9.0}
    cases = [case.replace(angle=a) for a in (9.0, 11.0)]
    cases += [case.replace(angle=0.5, **slow), case.replace(angle=10.2, time_limit=0.5)]
    expected = run_inclines(EULER, cases, route, every=50)
    assert {run.motion for run in expected} >= {Motion.TRAPPED, Motion.MOVES_ON, Motion.UNDECIDED}
    for run, other in zip(run_inclines(stand_in(), cases, route, every=50), expected, strict=True):
        assert (run.case, run.motion) == (other.case, other.motion)
        if run.motion is Motion.UNDECIDED:
            continue
        assert run.steps == other.steps
        assert run.margin_J == pytest.approx(other.margin_J, abs=2e-5)
        assert np.abs(run.trajectory.x_m - other.trajectory.x_m).max() < 1e-5


def test_what_the_first_step_of_the_row_costs_falls_with_the_third_order(stand_in):
    """In that step the held spheres move against the dashpot of a grain that rests on them."""
    engine, fineness = stand_in(), np.array([20.0, 28.0, 40.0])
    errors = []
    for steps in fineness:
        case = Incline(angle=10.3, stiffness=1e4, contact=CONTACT, steps_per_contact=steps)
        (run,) = run_inclines(engine, [case], "passage")
        (expected,) = run_inclines(EULER, [case], "passage")
        errors.append(abs(run.margin_J - expected.margin_J) / case.weight_energy)
    order, _ = slope_order(1 / fineness, errors)
    assert order == pytest.approx(3.0, abs=0.3)
    assert errors[-1] < 1e-6


def scheme(case, step, steps):
    """Return displacements, velocities and forces at every step of semi-implicit Euler."""
    x, v = np.array(start_displacements(case)), np.zeros(case.particles)
    v[0] = case.speed
    places, speeds, forces = [], [], []
    for _ in range(steps + 1):
        force = 1e5 * np.maximum(x[:-1] - x[1:], 0.0)
        places.append(x.copy())
        speeds.append(v.copy())
        forces.append(force)
        acceleration = case.gravity + np.diff(np.pad(-force, 1))
        if case.base == "fixed":
            acceleration[-1] = 0.0
        v = v + step * acceleration
        x = x + step * v
    return np.array(places), np.array(speeds), np.array(forces)


def assert_is_the_scheme(engine, case, samples):
    """Compare a tower's run with the scheme."""
    how = {"steps_per_contact": 100.0, "samples": samples, "profiles": True}
    (run,) = run_towers(engine, [case], 3.0, **how)
    timing = timing_of(case, 3.0, 100.0, samples)
    places, speeds, forces = scheme(case, timing.step, timing.steps)
    taken = np.rint(run.time / timing.step).astype(int)
    assert list(taken) == list(range(0, timing.steps + 1, timing.every))
    assert run.time == pytest.approx(taken * timing.step, rel=1e-12, abs=1e-15)
    box = case.height + 3.0
    assert np.abs(run.profiles.displacements - places[taken]).max() < box * SINGLE
    assert np.abs(run.profiles.velocities - speeds[taken]).max() < 3 * 2.0 * SINGLE
    assert np.abs(run.profiles.forces - forces[taken]).max() < 2 * SINGLE * forces.max()
    assert np.array_equal(run.profiles.forces > 0.0, forces[taken] > 0.0)


SAMPLES = pytest.mark.parametrize("samples", [100, 10_000], ids=["every third", "every step"])
TOWERS = pytest.mark.parametrize(
    "case",
    [
        tower(height=1),
        tower(height=4),
        tower(base="free", gravity=0.0, height=3),
        tower(base="free"),
        tower(start="preloaded", height=4),
        tower(start="gapped", gap=0.002),
    ],
    ids=lambda c: f"{c.height}-{c.base}-{c.start}-{c.gravity}",
)


@SAMPLES
@TOWERS
def test_a_tower_is_mfix_s_scheme_sample_by_sample(stand_in, case, samples):
    """The force of a sample is that of the frame a step later."""
    assert_is_the_scheme(stand_in(), case, samples)


def test_a_search_with_cells_of_less_than_two_diameters_loses_the_contacts(stand_in, monkeypatch):
    monkeypatch.setattr("harness.engines.mfix.system.SEARCH_CELL", 1.5)
    (run,) = run_towers(stand_in(), [tower()], 1.0, steps_per_contact=50.0)
    assert isinstance(run, EngineOutputError)
    assert "no contact of the tower ever presses" in str(run)


@pytest.mark.parametrize(
    ("mode", "error", "said"),
    [
        ("SIGSEGV", EngineCrashError, "SIGSEGV"),
        ("SIGFPE", EngineNaNError, "signal SIGFPE"),
        ("refuse", EngineInputError, "refused its input: Error 1000: Required input"),
        ("unknown", EngineInputError, "input: Illegal or unknown input: DES_EN_INPUT = 0.25"),
        ("invalid", EngineInputError, "input: Invalid particle-particle collision model"),
        ("hang", EngineTimeoutError, "within 2 s"),
        ("half a file", EngineOutputError, "only in part"),
        ("stops early", EngineOutputError, "ended at"),
    ],
)
def test_each_way_to_fail_has_its_error_and_costs_only_its_own_run(stand_in, mode, error, said):
    engine = stand_in(mode, seconds=2.0)
    first, failed, last = run_drops(engine, [GOOD, BAD, GOOD])
    assert type(failed) is error
    assert said in str(failed)
    assert "\n" not in str(failed)
    assert "DTSOLID_FACTOR" in failed.log
    assert "# particle_input.dat" in failed.log
    assert isinstance(first, DropRun)
    assert isinstance(last, DropRun)
    engine.close()
    assert isinstance(run_drops(engine, [GOOD])[0], EngineCrashError)


def test_a_sphere_that_is_not_held_is_an_error(stand_in):
    (run,) = run_drops(stand_in("no hold"), [GOOD.replace(gravity=9.81, duration=20.0)])
    assert isinstance(run, EngineOutputError)
    assert "moved a sphere that is to be held" in str(run)


def test_adams_bashforth_is_an_option_that_its_inputs_state(stand_in):
    program, options = stand_in().program, {"scheme": "ADAMS_BASHFORTH"}
    with open_engine("mfix", program=program, options=options) as engine:
        assert engine.identify().integrator == engine.traits.integrator == "mfix-adams-bashforth"
        assert engine.fingerprint() == Mfix.fingerprint_of(program=program, **options)
        assert isinstance(run_drops(engine, [GOOD])[0], DropRun)
        with pytest.raises(RequestError, match="forces of lines in scheme EULER only"):
            run_towers(engine, [tower(height=1)], 1.0)
    with pytest.raises(RequestError, match=r"scheme=RK4: must be one of EULER, ADAMS_BASHFORTH"):
        open_engine("mfix", program=program, options={"scheme": "RK4"})


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("name", REFERENCE)
def test_mfix_itself_is_the_reference_dem(mfix, name):
    with Mfix(program=mfix.program, scheme=name) as engine:
        assert qualify(engine).holds
        drops = [GOOD.replace(duration=4.0), GOOD.replace(contact=CONTACT, duration=4.0)]
        reference = Reference(REFERENCE[name])
        runs = zip(run_drops(engine, drops), run_drops(reference, drops), strict=True)
        for run, expected in runs:
            assert np.abs(run.path.y_m - expected.path.y_m).max() < 4 * SINGLE
            assert np.abs(run.path.vy_m_per_s - expected.path.vy_m_per_s).max() < 1e-6
        passage = Incline(contact=CONTACT, steps_per_contact=50.0)
        cases = [passage.replace(angle=angle) for angle in (9.5, 10.3)]
        both = (run_inclines(code, cases, "passage") for code in (engine, reference))
        for run, expected in zip(*both, strict=True):
            assert (run.motion, run.steps) == (expected.motion, expected.steps)
            # single precision, and the first step of the row
            assert run.margin_J == pytest.approx(expected.margin_J, abs=2e-5)


@pytest.mark.live
@pytest.mark.slow
@SAMPLES
@TOWERS
def test_a_tower_of_mfix_itself_is_its_scheme_sample_by_sample(mfix, case, samples):
    assert_is_the_scheme(mfix, case, samples)


@pytest.mark.live
@pytest.mark.slow
@pytest.mark.parametrize("height", [1, 4])
@pytest.mark.parametrize("base", ["fixed", "free"])
def test_a_tower_of_mfix_itself_is_the_exact_one(mfix, height, base):
    case = tower(height=height, base=base, stiffness=1e6)
    (run,) = run_towers(mfix, [case], 3.0, samples=300)
    expected = exact.run(case, 3.0 * case.contact_time, samples=6000)
    force = np.interp(run.time, expected.time, expected.grain_force)
    # 1000 steps a contact, first order: gravity in the first half step
    assert np.abs(run.grain_force - force).max() < 2e-4 * force.max()
