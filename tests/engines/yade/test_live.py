import math
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.cases.drop.case import Drop, DropRun, run_drops
from harness.cases.incline.angle import critical_angle
from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, Motion, job_of
from harness.cases.qualification import qualify
from harness.engines.process import Limits
from harness.engines.reference import Reference
from harness.engines.yade.engine import Yade
from harness.errors import EngineCrashError, EngineError, EngineInputError
from harness.parameters.law import PLASTIC, SOURCE
from harness.theory.contact import restitution_clipped

pytestmark = pytest.mark.live

CLIPPED_SOURCE = SOURCE.replace(name="source, clipped", tail="clipped")
SHIFTED = {"phase": 0.3, "diameter": 0.37, "density": 2500.0, "gravity": 3.7}
HEAD_ON = PLASTIC.replace(name="e = 0.5", damping_ratio=None, restitution=0.5)


def columns(path):
    return np.array([path.time_s, path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s])


def leftovers():
    return set(Path("/tmp").glob("yade-??????"))


def test_yade_qualifies(yade):
    found = qualify(yade)
    assert found.holds, found.failures


STATED = "kn=2 * p.stiffness, cn=2 * p.damping, ks=0.0, cs=0.0"
BY_TIME = "tc=math.sqrt(p.mass / p.stiffness) * math.hypot(math.pi, math.log(p.damping)), "
BY_TIME += "en=p.damping, et=1.0"
BY_MODULUS = "young=2 * p.stiffness / p.diameter, poisson=0.3, en=p.damping, et=1.0"


class Naive(Yade):
    """Yade with its own formulas for the contact, or its own damping of the motion."""

    traits = replace(Yade.traits, most_damping=1.0)  # above, there is no restitution to give it
    told: tuple[str, str]

    @classmethod
    def script(cls, template, variant=""):
        script = super().script(template, variant)
        assert cls.told[0] in script.text
        return replace(script, text=script.text.replace(*cls.told))

    @classmethod
    def scene_values(cls, scene):
        """Return the data of a scene, with the restitution for the dashpot where it is told."""
        values = super().scene_values(scene)
        return {**values, "damping": scene.restitution} if cls.told[0] == STATED else values


FULL, HALF, NEAR_ZERO = (
    f"restitution head-on, {name}"
    for name in ("e = 0.5, clipped, m_eff full", "e = 0.5, clipped, m_eff half", "source, clipped")
)
STATIC, FALL = "static contact, overlap over m g / k", "free fall over g t^2 / 2"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("told", "failures", "values"),
    [
        # spring and dashpot for m / 2, of a law whose tail attracts: half the spring, and zeta
        # against m is that of m / 2 over sqrt(2)
        (
            (STATED, BY_TIME),
            [FULL, NEAR_ZERO, STATIC],
            {STATIC: 2.0, FULL: restitution_clipped(HEAD_ON.zeta / math.sqrt(2.0))},
        ),
        # the search for a dashpot near 0 fails: no dashpot
        ((STATED, BY_MODULUS), [FULL, HALF, NEAR_ZERO], {STATIC: 1.0, NEAR_ZERO: 1.0}),
        (("(damping=0, ", "(damping=0.2, "), [FULL, HALF, NEAR_ZERO, FALL], {FALL: 0.8}),
    ],
    ids=["tc-en", "young-en", "newton damping"],
)
def test_what_users_fall_into_does_not_qualify(yade, told, failures, values):  # noqa: ARG001
    kind = type("Naive", (Naive,), {"told": told})
    with kind(workers=2) as naive:
        found = qualify(naive)
    assert not found.holds
    assert found.failures == ", ".join(failures)
    measured = {check.name.partition(": ")[2]: check.value for check in found.checks}
    # 2000 steps per contact: a step's worth of spring and dashpot
    assert {name: measured[name] for name in values} == pytest.approx(values, abs=3e-3)


def test_drops_are_the_references_step_by_step(yade):
    told = {"speed": 1.0, "sideways": 0.3, "gap": 1.5e-3, "gravity": 9.81, "duration": 5.0}
    cases = [Drop(contact=contact, **told) for contact in (HEAD_ON, CLIPPED_SOURCE, PLASTIC)]
    runs = zip(run_drops(yade, cases), run_drops(Reference("mfix-euler"), cases), strict=True)
    for ours, reference in runs:
        assert_allclose(columns(ours.path), columns(reference.path), rtol=1e-11, atol=1e-13)


PASSAGES = [
    Incline(contact=PLASTIC, angle=10.2),
    Incline(contact=CLIPPED_SOURCE, angle=10.2, stiffness=1e5),
    Incline(contact=PLASTIC, angle=10.5, steps_per_contact=200.0, **SHIFTED),
    Incline(contact=PLASTIC, angle=12.0, time_limit=0.1),
]
STEADY = [
    Incline(contact=PLASTIC, angle=15.0, stiffness=1e5, spheres=4, wells=7),
    Incline(contact=PLASTIC, angle=10.0, stiffness=1e5),
    Incline(contact=PLASTIC, angle=12.0, stiffness=1e5, time_limit=1.01),
]


@pytest.mark.parametrize(
    ("route", "cases", "ends"),
    [
        ("passage", PASSAGES, {Motion.TRAPPED, Motion.MOVES_ON, Motion.UNDECIDED}),
        ("steady", STEADY, {Motion.TRAPPED, Motion.MOVES_ON, Motion.UNDECIDED}),
    ],
)
def test_inclines_are_the_references_step_by_step(yade, route, cases, ends):
    ours = run_inclines(yade, cases, route, every=7)
    references = run_inclines(Reference("mfix-euler"), cases, route, every=7)
    assert {run.motion for run in references} == ends
    for case, run, reference in zip(cases, ours, references, strict=True):
        assert run.motion is reference.motion
        assert (run.steps, run.touching) == (reference.steps, reference.touching)
        # round-off, which the shocks of a plastic contact do not blow up
        ours_path, path = columns(run.trajectory), columns(reference.trajectory)
        assert_allclose(ours_path, path, rtol=1e-10, atol=1e-10 * case.diameter)
        assert run.margin_J == pytest.approx(reference.margin_J, abs=1e-10 * case.weight_energy)
        assert run.crests.time_s == pytest.approx(reference.crests.time_s, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("contact", [PLASTIC, CLIPPED_SOURCE], ids=lambda c: c.name)
@pytest.mark.parametrize("stiffness", [1e5, 1e6, 1e7])
def test_critical_angle_is_the_references(yade, contact, stiffness):
    case = Incline(contact=contact, stiffness=stiffness)
    ours = critical_angle(case, engine=yade)
    reference = critical_angle(case, engine=Reference("mfix-euler"))
    assert ours.value_deg == pytest.approx(reference.value_deg, abs=1e-9)


@pytest.mark.slow
def test_critical_angle_of_the_plastic_contact(yade):
    case = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=200.0)
    assert critical_angle(case, engine=yade).value_deg == pytest.approx(10.2078, abs=0.003)


@pytest.mark.slow
def test_a_run_that_yade_refuses_costs_only_itself(yade):  # noqa: ARG001
    class Refused(Yade):
        def settings(self, job):
            told = {"fixed": []} if job.values["speed"] == 2.0 else {}
            return {**super().settings(job), **told}

    before = leftovers()
    cases = [Drop(contact=HEAD_ON, speed=speed, steps_per_contact=50.0) for speed in (1, 2, 3)]
    with Refused(workers=1) as engine:
        first, second, third = run_drops(engine, cases)
    assert isinstance(first, DropRun)
    assert isinstance(third, DropRun)
    assert isinstance(second, EngineCrashError)
    assert "IndexError: list index out of range" in str(second)
    assert "Traceback" in second.log
    left = leftovers() - before  # those of other tests go with their runs
    deadline = time.monotonic() + 60.0
    while any(folder.exists() for folder in left) and time.monotonic() < deadline:
        time.sleep(0.5)
    assert not [folder for folder in left if folder.exists()]


@pytest.mark.slow
def test_a_mass_that_is_no_number_is_refused_by_the_script(yade):  # noqa: ARG001
    class Told(Yade):
        def settings(self, job):
            return {**super().settings(job), "mass": math.nan}

    with Told(workers=1) as engine:
        (error,) = engine.run([job_of(Incline(contact=PLASTIC), "passage")])
    assert isinstance(error, EngineInputError)
    assert "mass = nan: must be greater than 0" in str(error)


@pytest.mark.slow
def test_too_little_memory_is_an_engine_error(yade):  # noqa: ARG001
    with Yade(workers=1, limits=Limits(memory=200 * 1024**2)) as engine:
        (error,) = run_drops(engine, [Drop(contact=HEAD_ON)])
    assert isinstance(error, EngineError)
    assert error.log


@pytest.mark.slow
@pytest.mark.parametrize("script", ["drop.py", "tower.py", "incline.py"])
def test_committed_script_runs_alone(yade, inputs, tmp_path, script):
    ended = subprocess.run(
        [yade.identify().executable, "-n", "-x", str(inputs / "yade" / script)],
        cwd=tmp_path,
        env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0
    assert ended.stdout.endswith("RESULT verdict = finished\n")
    assert (tmp_path / script).with_suffix(".csv").is_file()
