"""Single commands say whether the engine that they ran qualifies."""

import json

import pytest

from harness.engines import registry
from harness.engines.contract import Job
from harness.engines.lammps.engine import Lammps
from harness.engines.mfix.engine import Mfix
from harness.parameters.law import contact_of, contact_values
from tests import engine_doubles as doubles

QUICK = {
    "critical-angle": ("--contact", "clipped", "--stiffness", "1e5", "--engine"),
    "tower": ("--law", "overlap", "--solver"),
    "impulse": ("--heights=1", "--law=overlap", "--stiffness=1e5", "--speed=2", "--solver"),
    "run": ("drop", "--set", "contact=clipped", "--engine"),
}
"""What each command needs for a short run, up to the name of the engine."""

DEAD = "restitution head-on"


class Sound(doubles.Twin):
    """The reference DEM under another name."""

    name = "yade"


class SoundInTowers(Lammps):
    """LAMMPS under another name: the reference DEM has no towers."""

    name = "yade"


class TwiceDamped:
    """Doubles the dashpot of what it is told."""

    def run(self, jobs):
        return super().run([self._doubled(job) for job in jobs])

    @staticmethod
    def _doubled(job):
        if "damping" not in job.values:
            return job
        contact = contact_of(job.values)
        twice = contact.replace(restitution=None, damping_ratio=2.0 * contact.zeta)
        values = {**job.values, **contact_values(twice)}
        return Job(job.template, values, job.variant, job.sampled)


class Doubled(TwiceDamped, Sound):
    pass


class DoubledInTowers(TwiceDamped, SoundInTowers):
    pass


class AsMfix(doubles.Half):
    """The reference DEM in MFiX's scheme, with its count of steps."""

    steps_of = Mfix.steps_of


def with_kinds(inclines, towers):
    """Return each command with the kind of engine that can run it."""
    return [
        pytest.param(name, towers, marks=pytest.mark.live)
        if "--solver" in words
        else (name, inclines)
        for name, words in QUICK.items()
    ]


@pytest.fixture
def command_in(command, monkeypatch):
    """Run a command in this process, where a stand-in is registered."""

    def run(kind, *words, **more):
        monkeypatch.setitem(registry.ENGINES, "yade", f"{__name__}:{kind.__name__}")
        return command(*words, **more)

    return run


@pytest.mark.parametrize(("name", "kind"), with_kinds(Doubled, DoubledInTowers))
def test_an_engine_with_a_doubled_dashpot_is_told_of_and_ends_with_status_3(command_in, name, kind):
    done = command_in(kind, name, *QUICK[name], "yade", "--json", status=3)
    record = json.loads(done.out)  # one object, with the number
    assert record["qualified"] is False
    assert DEAD in record["qualification_failures"]
    assert "engine 'yade' did not qualify" in done.err
    assert DEAD in done.err
    printed = command_in(kind, name, *QUICK[name], "yade", status=3)
    assert printed.out
    assert "did not qualify" in printed.err


@pytest.mark.parametrize(("name", "kind"), with_kinds(Sound, SoundInTowers))
def test_an_engine_that_qualifies_is_said_to(command_in, name, kind):
    done = command_in(kind, name, *QUICK[name], "yade", "--json")
    record = json.loads(done.out)
    assert record["qualified"] is True
    assert record["qualification_failures"] == ""
    assert done.err == ""


def test_the_engine_that_others_are_held_against_is_not_asked(command_in):
    record = json.loads(command_in(Sound, "run", "drop", "--engine", "reference", "--json").out)
    assert "qualified" not in record


def test_a_wrong_request_is_refused_before_an_engine_qualifies(command_in):
    said = command_in(AsMfix, "critical-angle", "--engine", "yade", status=2)
    assert "--half-mass" in said.err


def test_a_step_as_mfix_counts_it(command_in):
    words = ("critical-angle", "--engine", "yade", "--stiffness", "1e5", "--half-mass")
    steady = ("--method", "steady", "--wells", "10", "--engine-step", "50", "--json")
    record = json.loads(command_in(AsMfix, *words, *steady).out)
    assert record["steps_per_contact"] == pytest.approx(4.812, abs=1e-3)
    assert record["wells"] == 10
    for options, said in (
        (("--engine-step", "50", "--steps-per-contact", "5"), "must be one of the two"),
        (("--engine-step", "-1"), "factor = -1.0: must be finite and greater than 0"),
        (("--engine-step", "50", "--extrapolate"), "cannot go with --extrapolate"),
    ):
        assert said in command_in(AsMfix, *words, *options, status=2).err
    assert "half-mass" in command_in(AsMfix, *words[:-1], "--engine-step", "50", status=2).err
    assert "no measure of a step" in command_in(Sound, *words, "--engine-step", "50", status=2).err
