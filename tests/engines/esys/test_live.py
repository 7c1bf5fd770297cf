"""ESyS-Particle itself: on the reference DEM's path, on the exact tower, and its traps caught."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.drop.case import Drop, run_drops
from harness.cases.incline.angle import critical_angle
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, job_of
from harness.cases.qualification import qualify
from harness.cases.tower.run import run_towers, tower
from harness.comparison.verdicts import Verdict
from harness.engines.esys.engine import Esys
from harness.engines.process import Limits
from harness.engines.reference import Reference
from harness.errors import EngineError, EngineInputError, EngineMissingError, EngineTimeoutError
from harness.observables.windows import impulse
from harness.parameters.law import CLIPPED, PLASTIC, Contact
from harness.parameters.tower import Tower
from harness.theory.incline import critical_angle as closed_form

pytestmark = pytest.mark.live

SLIDING_PAST, FALLING = "oblique contact, angular momentum kept", "restitution head-on"


@pytest.fixture
def reference():
    return Reference("mfix-euler", spring="Hertz")


def test_it_says_who_it_is(esys):
    who = esys.identify()
    assert who.engine_version in esys.traits.versions
    assert who.executable.endswith("esysparticle")


@pytest.mark.slow
def test_it_qualifies(esys):
    found = qualify(esys)
    assert found.holds, found.failures
    assert len([c for c in found.checks if c.verdict is Verdict.PASS]) == 8


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        Drop(contact=PLASTIC, speed=1.0, gap=0.01, duration=5.0, steps_per_contact=200.0),
        Drop(contact=CLIPPED, gravity=9.81, sideways=0.5, gap=-1e-4, steps_per_contact=200.0),
        Drop(
            contact=CLIPPED.replace(effective_mass="half"),
            diameter=3e-3,
            density=2500.0,
            gravity=9.81,
            gap=1e-6,
            steps_per_contact=100.0,
        ),
    ],
    ids=["head-on", "oblique", "3 mm"],
)
def test_a_drop_goes_where_the_reference_goes(esys, reference, case):
    (ours,), (theirs,) = (run_drops(engine, [case]) for engine in (esys, reference))
    scale = max(1.0, float(np.abs(theirs.path.speed_m_per_s).max()))
    for name, unit in (("time_s", 1.0), ("y_m", case.diameter), ("vy_m_per_s", scale)):
        a, b = getattr(ours.path, name), getattr(theirs.path, name)
        assert np.abs(a - b).max() < 1e-11 * unit


def test_a_passage_goes_where_the_reference_goes(esys, reference):
    case = Incline(angle=10.5, stiffness=1e5, contact=PLASTIC, steps_per_contact=50.0)
    cases = [case, case.replace(phase=0.7), case.replace(angle=9.0)]
    runs = (run_inclines(engine, cases, "passage") for engine in (esys, reference))
    for ours, theirs in zip(*runs, strict=True):
        assert (ours.motion, ours.steps) == (theirs.motion, theirs.steps)
        assert ours.margin_J == pytest.approx(theirs.margin_J, abs=1e-10)


@pytest.mark.slow
def test_a_path_that_is_asked_for_is_kept_up_to_where_it_is_decided(esys, reference):
    case = Incline(angle=10.5, stiffness=1e5, contact=PLASTIC, steps_per_contact=50.0)
    (ours,) = run_inclines(esys, [case], "passage", every=25)
    (theirs,) = run_inclines(reference, [case], "passage", every=25)
    rows = ours.trajectory.time_s.size
    assert theirs.trajectory.time_s.size == rows
    for name, column in vars(ours.trajectory).items():
        assert np.abs(column - getattr(theirs.trajectory, name)[:rows]).max() < 1e-11


@pytest.mark.slow
def test_steady_motion_goes_where_the_reference_goes(esys, reference):
    case = Incline(angle=11.0, stiffness=1e5, contact=CLIPPED, steps_per_contact=30.0, wells=3)
    flight = case.replace(angle=29.0)
    cases = [case, case.replace(angle=5.0), flight]
    runs = (run_inclines(engine, cases, "steady") for engine in (esys, reference))
    for ours, theirs in zip(*runs, strict=True):
        assert (ours.motion, ours.steps) == (theirs.motion, theirs.steps)
        assert np.abs(ours.crests.margin_J - theirs.crests.margin_J).max(initial=0.0) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "steps"), [(1e5, 50.0), (1e5, 200.0), (1e6, 50.0), (1e6, 100.0), (1e7, 50.0)]
)
def test_its_critical_angle_is_the_reference_s(esys, reference, stiffness, steps):
    case = Incline(contact=PLASTIC, stiffness=stiffness, steps_per_contact=steps)
    ours, theirs = (critical_angle(case, engine=engine) for engine in (esys, reference))
    assert ours.value_deg == pytest.approx(theirs.value_deg, abs=1e-8)
    # a Hertz spring is soft under the weight: its bias is -0.0019 deg at 1e6 N/m, and falls
    assert abs(ours.value_deg - closed_form()) < 0.02 * (1e5 / stiffness) ** 0.5


@pytest.mark.slow
@pytest.mark.parametrize("height", [1, 2, 4, 9, 19])
def test_a_tower_follows_the_exact_motion_in_second_order(esys, height):
    case = Tower(height=height, stiffness=1e5, law="overlap")
    exact = tower(case, solver="exact", duration=3.0, samples=20_000)
    errors = []
    for steps in (125.0, 1000.0):
        (run,) = run_towers(esys, [case], 3.0, steps_per_contact=steps)
        velocity = np.interp(run.time, exact.time, exact.grain_velocity)
        errors.append(float(np.abs(run.grain_velocity - velocity).max()))
    assert abs(run.grain_force.max() / exact.grain_force.max() - 1.0) < 2e-5
    assert abs(impulse(run) / impulse(exact) - 1.0) < 2e-5
    # where in a step a contact parts jitters about the second order
    assert np.log2(errors[0] / errors[1]) / 3.0 == pytest.approx(2.0, abs=0.25)


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        Tower(height=3, stiffness=1e5, law="overlap", start="preloaded"),
        Tower(height=3, stiffness=1e5, law="overlap", start="gapped", gap=1e-3),
        Tower(height=3, stiffness=1e5, law="overlap", base="free"),
        Tower(height=3, stiffness=1e5, law="overlap", base="free", gravity=0.0),
        Tower(height=2, stiffness=1e7, mass=2e-3, diameter=3e-2, speed=0.3, law="overlap"),
    ],
    ids=["preloaded", "gapped", "free", "air hockey", "3 cm"],
)
def test_every_start_of_a_tower_follows_the_exact_motion(esys, case):
    exact = tower(case, solver="exact", duration=2.0, samples=20_000)
    (run,) = run_towers(esys, [case], 2.0, steps_per_contact=500.0)
    velocity = np.interp(run.time, exact.time, exact.grain_velocity)
    assert np.abs(run.grain_velocity - velocity).max() < 2e-5 * case.speed
    force = np.interp(run.time, exact.time, exact.grain_force)
    assert np.abs(run.grain_force - force).max() < 5e-5 * force.max()


CONTACT = "        self.sim.createInteractionGroup(self.contact())\n"
DASHPOT = (
    CONTACT,
    CONTACT.replace("self.contact()", "NRotElasticPrms('contact', p.stiffness, False)")
    # force = damp * (area / distance) * relative velocity, area that of a disc of diameter d
    + "        eta = p.relaxation / 0.8 * p.stiffness\n"
    + CONTACT.replace(
        "self.contact()",
        "LinearDashpotPrms('dashpot', eta * d / (math.pi * (0.5 * d) ** 2), 1.0)",
    ).rstrip()
    + "\n",
)
IMPORTS = "from esys.lsm import GravityPrms, "


class Naive(Esys):
    """The drops of one check, as a user would state them who does not know the trap."""

    traits = replace(Esys.traits, spring="linear", tails=("attractive",))
    check_name = before = after = ""

    @classmethod
    def script(cls, template, variant=""):
        right = Esys.script(template, variant)
        assert cls.before in right.text
        text = right.text.replace(cls.before, cls.after)
        return replace(right, text=text.replace(IMPORTS, IMPORTS + "LinearDashpotPrms, "))

    def run(self, jobs):
        def chosen(values):
            if self.check_name == SLIDING_PAST:
                return values["sideways"] > 0.0
            return values["restitution"] == 0.5 and values["speed"] > 0.0

        first = next(index for index, job in enumerate(jobs) if chosen(job.values))
        results = [EngineError("left out")] * len(jobs)
        (results[first],) = super().run([jobs[first]])
        return results


@pytest.mark.slow
@pytest.mark.parametrize(
    ("check", "before", "after"),
    [
        (SLIDING_PAST, *DASHPOT),
        (FALLING, "sim.setParticleNonDynamic(FIXED)", "sim.setParticleNonDynamic(0)"),
    ],
    ids=["LinearDashpot brakes along the tangent", "setParticleNonDynamic takes a tag"],
)
def test_a_trap_is_caught(esys, check, before, after):  # noqa: ARG001
    told = {"check_name": check, "before": before, "after": after}
    with type("Told", (Naive,), told)() as engine:
        checks = qualify(engine).checks
    (ran,) = (c for c in checks if not c.engine_died and c.verdict is not Verdict.NOT_TESTED)
    assert check in ran.name
    assert ran.verdict is Verdict.FAIL


@pytest.mark.slow
def test_it_refuses_what_is_no_number_and_does_not_hang(esys):  # noqa: ARG001
    """An exception in a script leaves ESyS-Particle's worker waiting, unless the script sees it."""

    class Told(Esys):
        @classmethod
        def scene_values(cls, scene):
            return {**super().scene_values(scene), "mass": "heavy"}

    with Told() as engine:
        (found,) = engine.run([job_of(Incline(contact=PLASTIC), "passage")])
    assert isinstance(found, EngineInputError)
    assert "mass = heavy: must be a number" in str(found)


def test_the_launcher_of_another_mpi_is_named(esys, mpirun):  # noqa: ARG001
    named = subprocess.run([mpirun, "--version"], capture_output=True, text=True, check=False)
    if "HYDRA" not in named.stdout:
        pytest.skip(f"{mpirun} is not MPICH's")
    with (
        Esys(launcher=mpirun) as engine,
        pytest.raises(EngineMissingError, match="the Open MPI that it was built with"),
    ):
        engine.identify()


@pytest.mark.slow
def test_an_undamped_contact_keeps_the_energy(esys):
    contact = Contact(restitution=1.0, damping_ratio=None, tail="clipped")
    case = Drop(contact=contact, speed=1.0, gap=1e-3, duration=3.0, every=100)
    (run,) = run_drops(esys, [case])
    assert run.path.vy_m_per_s[-1] == pytest.approx(1.0, abs=1e-5)


@pytest.mark.slow
def test_a_run_out_of_time_is_ended(esys):  # noqa: ARG001
    case = Drop(contact=PLASTIC, gravity=9.81, duration=1e4)
    with Esys(limits=Limits(seconds=2.0)) as engine:
        (found,) = run_drops(engine, [case])
    assert isinstance(found, EngineTimeoutError)
    assert "esysparticle drop.py" in found.log
