"""The engine with MFiX's stand-in: what it states and reads, and how a run that fails is told."""

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.cases.drop.case import TEMPLATE, Drop, DropRun, run_drops, values_of
from harness.cases.incline.angle import critical_angle
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, Motion
from harness.cases.qualification import qualify
from harness.cases.tower.run import run_towers
from harness.comparison.convergence import slope_order
from harness.engines.mfix.contacts import CONTACT
from harness.engines.mfix.engine import MOST_FRAMES, Mfix, keyword_file
from harness.engines.mfix.system import REFERENCE, system_of
from harness.engines.reference import Reference
from harness.engines.registry import ENGINES, engine_class, open_engine
from harness.errors import (
    EngineCrashError,
    EngineInputError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineTimeoutError,
    RequestError,
)
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE
from harness.parameters.tower import Tower
from tests.engine_doubles import frictionless

GOOD = Drop(
    contact=CONTACT.replace(restitution=0.5), speed=1.0, steps_per_contact=100.0, duration=1.0
)
BAD = GOOD.replace(contact=CONTACT.replace(restitution=0.25))
SINGLE = 2.0**-23
RECORDED = Path(__file__).parent / "recorded"


def test_it_is_registered_and_says_how_to_get_it_when_no_program_is_given():
    assert "mfix" in ENGINES
    assert engine_class("mfix") is Mfix
    with pytest.raises(EngineMissingError, match=r"mfix\.netl\.doe\.gov.*--program mfix=PATH"):
        open_engine("mfix")


@pytest.mark.parametrize("answer", ["unversioned", "blank"])
def test_a_build_that_was_not_told_its_version_is_unversioned(stand_in, answer):
    """A plain cmake build outside a checkout answers 0.0, in one without tags nothing."""
    engine = stand_in(answer)
    assert engine.identify().engine_version == "unversioned"
    (run,) = run_drops(engine, [GOOD])
    assert isinstance(run, DropRun)
    with pytest.raises(EngineMissingError, match=r"cmake -DVERSION=21\.3\.2"):
        open_engine("mfix")


@pytest.mark.parametrize("program", ["pip", "cat", "sh"])
def test_a_program_that_names_a_version_is_not_mfix_for_that(program):
    with pytest.raises(EngineMissingError, match="is not an MFiX solver"):
        open_engine("mfix", programs={"mfix": shutil.which(program) or sys.executable})


@pytest.mark.parametrize(
    ("mode", "said"),
    [
        ("old", "is version 20.4.1: must be 21.3 or later"),
        ("another", r"not an MFiX solver: its --help does not speak of mfix\.dat \(it says: hello"),
    ],
)
def test_another_program_or_version_is_missing(stand_in, mode, said):
    with pytest.raises(EngineMissingError, match=said):
        stand_in(mode)


def test_it_names_its_version_and_program(stand_in):
    program = stand_in().identify().executable
    with open_engine("mfix", programs={"mfix": program}) as engine:
        who = engine.identify()
    assert (who.engine, who.engine_version, who.integrator) == ("mfix", "21.3.2", "mfix-euler")
    assert "mfixsolver" in who.executable


def test_it_qualifies_by_what_it_declares(stand_in):
    found = qualify(stand_in())
    assert found.holds, found.failures
    assert found.failures == ""


def halved(jobs):
    return [replace(job, values={**job.values, "effective_mass": "half"}) for job in jobs]


class SaysFull(Mfix):
    """MFiX by one who takes the effective mass for the whole mass, as its manual reads."""

    traits = replace(
        Mfix.traits, frictionless=frictionless(tail="attractive", effective_mass="full")
    )

    def check(self, jobs):
        """Refuse nothing."""

    def run(self, jobs):
        return super().run(halved(jobs))


class HalvedReference(Reference):
    """The reference DEM with MFiX's m/2 in its contacts, which it does not declare."""

    traits = SaysFull.traits

    def run(self, jobs):
        return self.run_scenes([job.template.scene(job.values) for job in halved(jobs)])


@pytest.mark.parametrize("naive", [SaysFull, HalvedReference])
def test_half_the_mass_that_is_not_declared_fails_by_its_restitution(naive, stand_in):
    program = stand_in().identify().executable
    with naive(program=program) if naive is SaysFull else naive("mfix-euler") as engine:
        found = qualify(engine)
    assert not found.holds
    assert "restitution head-on" in found.failures
    assert "contact found" not in found.failures


@pytest.mark.parametrize(
    ("contact", "said"),
    [
        (CONTACT.replace(restitution=0.0), "a restitution of at least 1e-20"),
        (CONTACT.replace(restitution=1e-25), "a restitution of at least 1e-20"),
        (PLASTIC.replace(tail="attractive", effective_mass="half"), "damping ratio of at most"),
        (SOURCE, "effective_mass = half, not full: --set contact.effective_mass=half"),
        (CLIPPED.replace(effective_mass="half"), "takes tail = attractive, not clipped"),
    ],
    ids=["e = 0", "e = 1e-25", "overdamped", "full mass", "clipped"],
)
def test_a_contact_that_mfix_does_not_have_is_refused_before_it_divides_by_zero(
    stand_in, contact, said
):
    engine = stand_in()
    with pytest.raises(RequestError, match=said):
        run_drops(engine, [Drop(contact=contact)])
    with pytest.raises(RequestError, match=said):
        run_inclines(engine, [Incline(contact=contact)], "passage")


@pytest.mark.parametrize("case", [GOOD, GOOD.replace(contact=CONTACT, duration=12.0, gravity=9.81)])
def test_a_drop_is_the_reference_dem_in_mfix_s_scheme(stand_in, case):
    (run,) = run_drops(stand_in(), [case])
    (expected,) = run_drops(Reference("mfix-euler"), [case])
    assert run.path.time_s == pytest.approx(expected.path.time_s, rel=1e-12)
    # positions to 3.5 m in MFiX's box, from the origin in single precision
    assert np.abs(run.path.y_m - expected.path.y_m).max() < 4 * SINGLE
    assert np.abs(run.path.vy_m_per_s - expected.path.vy_m_per_s).max() < 1e-5


@pytest.mark.parametrize("route", ["passage", "steady"])
def test_an_incline_is_the_reference_dem_in_mfix_s_scheme(stand_in, route):
    cases = [
        Incline(angle=a, contact=CONTACT, steps_per_contact=20.0, stiffness=1e5, wells=2)
        for a in (9.0, 11.0)
    ]
    runs = run_inclines(stand_in(), cases, route, every=50)
    for run, expected in zip(
        runs, run_inclines(Reference("mfix-euler"), cases, route, every=50), strict=True
    ):
        assert (run.case, run.motion, run.steps) == (expected.case, expected.motion, expected.steps)
        assert run.margin_J == pytest.approx(expected.margin_J, abs=2e-5)
        assert np.abs(run.trajectory.x_m - expected.trajectory.x_m).max() < 1e-5


def test_the_path_is_kept_only_where_it_is_asked_for(stand_in):
    case = Incline(angle=9.0, contact=CONTACT, steps_per_contact=10.0, stiffness=1e4)
    (run,) = run_inclines(stand_in(), [case], "passage")
    assert run.trajectory is None


def test_a_grain_that_takes_long_is_followed_to_its_time_limit(stand_in):
    """Started past the crest at the angle where it comes to the next one almost at rest."""
    case = Incline(
        angle=0.5,
        contact=CONTACT.replace(restitution=1.0),
        steps_per_contact=20.0,
        stiffness=1e4,
        time_limit=9.0,
    )
    (run,) = run_inclines(stand_in(), [case], "steady")
    (expected,) = run_inclines(Reference("mfix-euler"), [case], "steady")
    assert run.case == case
    assert run.motion is expected.motion


def test_cut_off_by_time_is_undecided(stand_in):
    case = Incline(angle=10.2, contact=CONTACT, steps_per_contact=20.0, time_limit=0.5)
    (run,) = run_inclines(stand_in(), [case], "steady")
    assert run.motion is Motion.UNDECIDED
    assert run.case == case


def test_a_path_that_would_take_too_many_files_ends_undecided(stand_in, monkeypatch):
    case = Incline(angle=10.2, contact=CONTACT, steps_per_contact=20.0, time_limit=20.0)
    case = case.replace(stiffness=1e4, wells=20)
    first = int(8.0 * 9.81**-0.5 / case.step)
    monkeypatch.setattr("harness.engines.mfix.engine.MOST_FRAMES", first + 1)
    (run,) = run_inclines(stand_in(), [case], "steady", every=1)
    assert isinstance(run, EngineOutputError)
    assert "undecided" in str(run)
    assert "every = 1 steps" in str(run)


def test_what_the_first_step_of_the_row_costs_falls_with_the_third_order(stand_in):
    """In that step the held spheres move against the dashpot of a grain that rests on them."""
    engine, fineness = stand_in(), np.array([20.0, 28.0, 40.0])
    errors = []
    for steps in fineness:
        case = Incline(angle=10.3, stiffness=1e4, contact=CONTACT, steps_per_contact=steps)
        (run,) = run_inclines(engine, [case], "passage")
        (expected,) = run_inclines(Reference("mfix-euler"), [case], "passage")
        errors.append(abs(run.margin_J - expected.margin_J) / case.weight_energy)
    order, _ = slope_order(1 / fineness, errors)
    assert order == pytest.approx(3.0, abs=0.3)
    assert errors[-1] < 1e-6


@pytest.mark.slow
def test_the_critical_angle_is_the_reference_dem_s(stand_in):
    case = Incline(stiffness=1e5, contact=CONTACT, steps_per_contact=50.0)
    found = critical_angle(case, engine=stand_in())
    expected = critical_angle(case, engine=Reference("mfix-euler"))
    # 1e-7 of m g d from single precision and the first step, over a margin of 0.009 a degree
    assert found.value_deg == pytest.approx(expected.value_deg, abs=1.2e-5)


@pytest.mark.parametrize(
    ("mode", "limits", "error", "said"),
    [
        ("segfault", {}, EngineCrashError, "SIGSEGV"),
        ("exit", {}, EngineCrashError, "exit status 3"),
        ("trap", {}, EngineNaNError, "signal SIGFPE: its builds stop at a division by zero"),
        ("refuse", {}, EngineInputError, "refused its input: Error 1000: Required input"),
        ("unknown", {}, EngineInputError, "input: Illegal or unknown input: DES_EN_INPUT = 0.25"),
        ("invalid", {}, EngineInputError, "input: Invalid particle-particle collision model"),
        ("hang", {"seconds": 1.0}, EngineTimeoutError, "within 1 s"),
        ("exceed memory", {"memory": 1024**3}, EngineMemoryError, "memory"),
        ("half a file", {}, EngineOutputError, "only in part"),
        ("stops early", {}, EngineOutputError, "ended at"),
    ],
)
def test_each_way_to_fail_has_its_error_and_costs_only_its_own_run(
    stand_in, mode, limits, error, said
):
    results = run_drops(stand_in(mode, **limits), [GOOD, BAD, GOOD])
    assert type(results[1]) is error
    assert said in str(results[1])
    assert "\n" not in str(results[1])
    assert "DTSOLID_FACTOR" in results[1].log
    assert "# particle_input.dat" in results[1].log
    assert isinstance(results[0], DropRun)
    assert isinstance(results[2], DropRun)


def test_adams_bashforth_is_the_recorded_run_of_mfix_and_euler_is_not():
    """What the reference DEM computes in the scheme that the engine declares then."""
    case = GOOD.replace(duration=4.0)
    recorded = np.loadtxt(RECORDED / "drop_adams_bashforth.csv", delimiter=",", skiprows=1)
    apart = {}
    for scheme, name in REFERENCE.items():
        (run,) = run_drops(Reference(name), [case])
        assert run.path.time_s[::4] == pytest.approx(recorded[:, 0], rel=1e-7, abs=1e-12)
        apart[scheme] = (
            np.abs(run.path.y_m[::4] - recorded[:, 1]).max(),
            np.abs(run.path.vy_m_per_s[::4] - recorded[:, 2]).max(),
        )
    place, speed = apart["ADAMS_BASHFORTH"]
    assert place < 4 * SINGLE
    assert speed < 1e-7
    assert apart["EULER"][1] > 1e-3


def test_adams_bashforth_is_an_option_that_its_inputs_state(stand_in):
    program = stand_in().identify().executable
    options = {"scheme": "ADAMS_BASHFORTH"}
    with open_engine("mfix", program=program, options=options) as engine:
        assert engine.identify().integrator == engine.traits.integrator == "mfix-adams-bashforth"
        assert engine.traits.contact_powers == ()
        assert engine.fingerprint() == Mfix.fingerprint_of(program=program, **options)
        (run,) = run_drops(engine, [BAD.replace(contact=GOOD.contact)])
        assert isinstance(run, DropRun)
        tower = Tower(height=1, law="overlap", stiffness=1e5)
        with pytest.raises(RequestError, match="forces of a state in scheme EULER only"):
            run_towers(engine, [tower], 1.0)
    with pytest.raises(RequestError, match=r"scheme=RK4: must be one of EULER, ADAMS_BASHFORTH"):
        open_engine("mfix", program=program, options={"scheme": "RK4"})


def test_a_held_sphere_is_at_its_place_after_the_first_step_of_either_scheme():
    """By the schemes of the reference DEM: x + h (v + h a), and x + h/2 (v + v + h a)."""
    case = GOOD.replace(gravity=9.81, gap=-1e-3)
    scene = TEMPLATE.scene(values_of(case))
    for scheme, average in (("EULER", 1.0), ("ADAMS_BASHFORTH", 0.5)):
        system = system_of("drop", scene, 100, 1, scheme)
        assert f"DES_INTG_METHOD = '{scheme}'" in keyword_file(system)
        grain, held = system.mobile[0], system.spheres[1]
        eta = 2.0 * case.contact.zeta * np.sqrt(0.5 * case.stiffness * case.mass)
        press = case.stiffness * 1e-3 - eta * grain.vy
        acceleration = -9.81 - press / case.mass
        moved = held.vy + average * case.step * acceleration
        assert moved == pytest.approx(0.0, abs=1e-9 * abs(acceleration) * case.step)


def test_a_restart_file_that_a_run_leaves_does_not_stop_the_next(stand_in):
    engine = stand_in()
    for _ in range(2):
        (run,) = run_drops(engine, [GOOD])
        assert isinstance(run, DropRun)


def test_a_row_that_is_not_held_is_told(stand_in):
    case = GOOD.replace(gravity=9.81, duration=20.0)
    (run,) = run_drops(stand_in("no hold"), [case])
    assert isinstance(run, EngineOutputError)
    assert "moved a sphere that is to be held" in str(run)


def test_a_closed_engine_runs_nothing(stand_in):
    engine = stand_in()
    engine.close()
    (run,) = run_drops(engine, [GOOD])
    assert isinstance(run, EngineCrashError)


def test_more_files_than_is_sensible_are_refused(stand_in):
    case = GOOD.replace(duration=2.0 * MOST_FRAMES / GOOD.steps_per_contact)
    with pytest.raises(RequestError, match=f"must be at most {MOST_FRAMES}"):
        run_drops(stand_in(), [case])


@pytest.mark.live
def test_mfix_itself_qualifies(mfix):
    found = qualify(mfix)
    assert found.holds, found.failures
