import math
import time
from dataclasses import replace
from pathlib import Path

import pytest

from harness.cases.drop.case import Drop, DropRun, run_drops
from harness.cases.qualification import qualify
from harness.engines.yade.engine import Yade
from harness.errors import EngineCrashError
from harness.parameters.law import PLASTIC, SOURCE
from harness.theory.contact import restitution_clipped
from tests.engine_doubles import most_damping

pytestmark = pytest.mark.live

CLIPPED_SOURCE = SOURCE.replace(name="source, clipped", tail="clipped")
HEAD_ON = PLASTIC.replace(name="e = 0.5", damping_ratio=None, restitution=0.5)


def leftovers():
    return set(Path("/tmp").glob("yade-??????"))


STATED = "kn=2 * p.stiffness, cn=2 * p.damping, ks=0.0, cs=0.0"
BY_TIME = "tc=math.sqrt(p.mass / p.stiffness) * math.hypot(math.pi, math.log(p.damping)), "
BY_TIME += "en=p.damping, et=1.0"
BY_MODULUS = "young=2 * p.stiffness / p.diameter, poisson=0.3, en=p.damping, et=1.0"


class Naive(Yade):
    """Yade with its own formulas for the contact, or its own damping of the motion."""

    traits = replace(
        Yade.traits, frictionless=most_damping(1.0, tail="clipped")
    )  # above, there is no restitution to give it
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
        return {**values, "damping": scene.contact.restitution} if cls.told[0] == STATED else values


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
