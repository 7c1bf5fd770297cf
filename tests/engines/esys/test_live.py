"""ESyS-Particle itself: on the reference DEM's path, on the exact tower, and its traps caught."""

import subprocess
from dataclasses import replace

import pytest

from harness.cases.drop.case import Drop, run_drops
from harness.cases.incline.system import Incline, job_of
from harness.cases.qualification import qualify
from harness.comparison.verdicts import Verdict
from harness.engines.esys.engine import Esys
from harness.engines.process import Limits
from harness.errors import EngineError, EngineInputError, EngineMissingError, EngineTimeoutError
from harness.parameters.law import PLASTIC, Contact
from tests.engine_doubles import frictionless

pytestmark = pytest.mark.live

SLIDING_PAST, FALLING = "oblique contact, angular momentum kept", "restitution head-on"


def test_it_says_who_it_is(esys):
    who = esys.identify()
    assert who.engine_version in esys.traits.versions
    assert who.executable.endswith("esysparticle")


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

    traits = replace(Esys.traits, spring="linear", frictionless=frictionless(tail="attractive"))
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
        def settings(self, job):
            return {**super().settings(job), "mass": "heavy"}

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
