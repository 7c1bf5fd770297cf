"""The suite of engines passes a good one, and each planted fault fails the check of its name."""

import os
import signal
import time
from dataclasses import replace
from itertools import count
from unittest import SkipTest

import numpy as np
import pytest

from harness.engines.lammps.engine import Lammps
from harness.errors import EngineCrashError
from harness.observables.provenance import Provenance
from harness.testing import CHECKS, EngineCheckError, check_engine, engine_checks
from tests.engine_doubles import Half, Twin, frictionless


class Fault(Twin):
    """A twin of the reference DEM with a fault; the fixture below names it."""

    name = "fault"


def changed(output, **columns):
    """Return an output with columns changed by functions of their values."""
    tables = {
        name: {c: columns.get(c, np.array)(values) for c, values in table.items()}
        for name, table in output.tables.items()
    }
    return replace(output, tables=tables)


class MixedUp(Fault):
    def outcomes(self, jobs):
        yield from enumerate(self.run(jobs)[::-1])


class Hanging(Fault):
    def run(self, jobs):  # noqa: ARG002
        time.sleep(60)


class Dying(Fault):
    def run(self, jobs):  # noqa: ARG002
        os.kill(os.getpid(), signal.SIGSEGV)


class Raising(Fault):
    def run(self, jobs):
        return [1.0 / 0.0 for _ in jobs]


class Short(Fault):
    def run(self, jobs):
        return super().run(jobs)[:-1]


class NotANumber(Fault):
    def run(self, jobs):
        holed = {"vx_m_per_s": lambda v: np.where(np.arange(len(v)) == 1, np.nan, v)}
        return [changed(o, **holed) for o in super().run(jobs)]


class Sparse(Fault):
    def run(self, jobs):
        columns = ("step", "time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")
        return [changed(o, **dict.fromkeys(columns, lambda v: v[::2])) for o in super().run(jobs)]


class Millimetres(Fault):
    def run(self, jobs):
        return [changed(o, y_m=lambda y: 1e3 * y) for o in super().run(jobs)]


class Liar(Fault):
    """Its outputs are of another version than it says it is."""

    def run(self, jobs):
        who = Provenance("fault", "9.9")
        return [replace(o, provenance=who) for o in super().run(jobs)]


class Fickle(Fault):
    versions = count()

    def identify(self):
        return replace(super().identify(), engine_version=str(next(self.versions)))


class Unnamed(Fault):
    def identify(self):
        return replace(super().identify(), engine="another")


class Restless(Fault):
    starts = count()

    def fingerprint(self):
        return {"made": next(self.starts)}


class Drifting(Fault):
    """Kept under a fingerprint, and never the same twice."""

    runs = count()

    def run(self, jobs):
        return [changed(o, x_m=lambda x: x + 1e-15 * next(self.runs)) for o in super().run(jobs)]


class Remembering(Fault):
    """The second run of a batch begins where the first one ended."""

    def run(self, jobs):
        found = super().run(jobs)
        return [changed(o, y_m=lambda y, i=i: y + 1e-9 * i) for i, o in enumerate(found)]


class Agreeable(Fault):
    @classmethod
    def states(cls, template):  # noqa: ARG003
        return True


class Clipping(Fault):
    """It says that it clips, and runs what it is told not to state."""

    traits = replace(Twin.traits, frictionless=frictionless(tail="clipped"))

    def refuses(self, job):
        return "" if self.states(job.template) else super().refuses(job)


class Gullible(Fault):
    """It takes a speed that is no number for none."""

    def run(self, jobs):
        still = [
            replace(j, values={**j.values, "speed": 1.0})
            if not np.isfinite(j.values.get("speed", 0.0))
            else j
            for j in jobs
        ]
        return super().run(still)


class Contagious(Fault):
    """A value that is no number takes the whole batch along."""

    def run(self, jobs):
        if not all(np.isfinite(job.values.get("speed", 0.0)) for job in jobs):
            return [EngineCrashError("a value is not a number") for _ in jobs]
        return super().run(jobs)


class Light(Fault):
    def __init__(self):
        super().__init__(lambda v: {**v, "gravity": 0.99 * v.get("gravity", 0.0)})


class Steeper(Fault):
    def __init__(self):
        super().__init__(lambda v: {**v, "angle": v["angle"] - 2.5} if "angle" in v else v)


class Clinging(Fault):
    """It keeps the tail, and says that it clips."""

    traits = replace(Twin.traits, frictionless=frictionless(tail="clipped"))

    def __init__(self):
        super().__init__(lambda values: {**values, "tail": "attractive"})


class Unruled(Fault):
    traits = replace(Twin.traits, integrator="the best one")


class Damped(Lammps):
    """Its contacts lose energy where none is to be lost."""

    def task(self, job):
        return super().task(replace(job, values={**job.values, "restitution": 0.9}))


class Slippery(Lammps):
    """It takes half the friction that it is given."""

    def motions(self, jobs):
        def slippery(scene):
            friction = scene.law.friction
            return scene.replace(law=scene.law.replace(friction=friction and 0.5 * friction))

        return super().motions([replace(job, scene=slippery(job.scene)) for job in jobs])


class Dated(Lammps):
    written = count()

    @classmethod
    def inputs(cls, templates):
        texts = super().inputs(templates)
        return {name: f"# {next(cls.written)}\n{text}" for name, text in texts.items()}


class Executable(Lammps):
    def __init__(self):
        super().__init__(lmp="lmp")


class Vague(Executable):
    """It calls every end of its program a crash."""

    def error_of(self, ended, log):
        return super().error_of(ended, log) and EngineCrashError("it ended")


class Undying(Executable):
    """Closed, it goes on."""

    def close(self):
        pass


FAULTS = [
    (Hanging, "a_run_returns", "did not return within"),
    (Dying, "a_run_returns", "died: SIGSEGV"),
    (Raising, "a_run_returns", "ZeroDivisionError"),
    (Short, "a_run_returns", "returned a list|returned 0 outcomes"),
    (Unnamed, "it_says_who_it_is", "'another'"),
    (Liar, "it_says_who_it_is", "an output is of fault 9.9"),
    (Fickle, "it_says_who_it_is", "asked again"),
    (Unruled, "its_traits_are_sound", "the best one"),
    (Restless, "its_fingerprint_may_be_cached_under", "is another"),
    (Drifting, "its_fingerprint_may_be_cached_under", "repeated"),
    (Agreeable, "it_refuses_what_it_cannot_state", "nobody wrote"),
    (Clipping, "it_refuses_what_it_cannot_state", "does not refuse 'drop' with tail"),
    (Gullible, "bad_values_are_refused_or_a_row", "gave a motion of finite numbers"),
    (Contagious, "bad_values_are_refused_or_a_row", "took a good one along"),
    (MixedUp, "outcomes_are_in_order", "starts with"),
    (Remembering, "a_batch_is_its_runs", "'y_m'"),
    (NotANumber, "values_are_numbers", "'vx_m_per_s'"),
    (Sparse, "values_are_numbers", "samples|rows of a series"),
    (Millimetres, "units_are_those_of_a_free_flight", "^y_m of a free particle"),
    (Light, "it_qualifies_by_drops", "fall"),
    (Clinging, "it_qualifies_by_drops", "restitution"),
    (Steeper, "an_incline_stops_and_slides", "margin|must be"),
    (Damped, "a_tower_is_the_exact_one", "impulse|peak force"),
    (Slippery, "contacts_follow_their_rules", "oblique"),
    (Dated, "scripts_are_reproducible", "differ"),
    (Vague, "faults_of_its_program_are_rows", "a program that hangs ends as"),
    (Undying, "a_closed_engine_runs_nothing", "still starts its program"),
]


def test_each_check_has_a_planted_fault():
    assert {name for _, name, _ in FAULTS} == {check.__name__ for check in CHECKS}


def made(kind, name, **options):
    """Make one check of an engine; return what it found."""
    checks = {check.__name__: check for check in engine_checks(kind, **options)}
    try:
        checks[name]()
    finally:
        checks[name].subject.close()


@pytest.mark.parametrize(
    ("kind", "name", "words"),
    [
        pytest.param(
            *fault, id=fault[0].__name__, marks=[pytest.mark.live] * issubclass(fault[0], Lammps)
        )
        for fault in FAULTS
    ],
)
def test_a_fault_fails_the_check_of_its_name(kind, name, words):
    seconds = 1.0 if kind is Hanging else 60.0
    with pytest.raises(Exception, match=words):
        made(kind, name, seconds=seconds)


@pytest.mark.parametrize("kind", [Twin, Fault, Half])
def test_a_good_engine_passes_whatever_its_rules_are(kind):
    skipped = check_engine(kind)
    assert "tower: it moves one particle" in skipped["a_tower_is_the_exact_one"]
    assert set(skipped) < {check.__name__ for check in CHECKS}


def test_a_bad_engine_is_told_with_the_names_of_all_checks_that_failed():
    with pytest.raises(EngineCheckError) as caught:
        check_engine(Liar)
    (line,) = str(caught.value).splitlines()
    assert line.startswith("it_says_who_it_is: an output is of fault 9.9")


def test_an_engine_that_hangs_costs_its_time_once():
    started = time.monotonic()
    with pytest.raises(EngineCheckError) as caught:
        check_engine(Hanging, seconds=0.5)
    assert len(str(caught.value).splitlines()) == len(CHECKS) - 1
    assert "its_traits_are_sound: not tried: the first run did not return" in str(caught.value)
    assert time.monotonic() - started < 20.0


def test_checks_have_names_and_an_engine_without_scripts_skips_theirs():
    checks = engine_checks("reference")
    assert [check.__name__ for check in checks] == [check.__name__ for check in CHECKS]
    with pytest.raises(SkipTest, match="takes scenes"):
        made("reference", "scripts_are_reproducible")
