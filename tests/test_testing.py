"""The suite of engines passes good ones, and each planted fault fails the check of its name."""

from dataclasses import replace
from itertools import count
from unittest import SkipTest

import numpy as np
import pytest

from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output, Provenance
from harness.errors import Unsupported
from harness.model.conventions import Rules
from harness.testing import CHECKS, EngineCheckError, check_engine, engine_checks
from tests.engine_doubles import Clipping, Crashing, Twin, lost


def fault(label, base=Twin, **members):
    """Return a subclass with other members, as an engine of the package ``tests``."""
    return type(label, (base,), {"__module__": __name__, **members})


def altered(label, alter):
    """Return an engine whose outcomes are altered by a function of them."""
    return fault(label, run=lambda self, jobs: alter(Twin.run(self, jobs)))


def changed(label, **changes):
    """Return an engine that changes its scenes or motions by functions of them."""
    return fault(label, __init__=lambda self: Twin.__init__(self, **changes))


def without_places(_, motion):
    return replace(motion, position=np.full_like(motion.position, np.nan))


def without_forces(_, motion):
    unknown = np.full_like(motion.force, np.nan)
    return replace(motion, force=unknown, torque=unknown)


def lighter(scene):
    return scene.replace(gravity=tuple(0.999999 * g for g in scene.gravity))


def all_or_none(outcomes):
    """Return the first error in place of all outcomes."""
    errors = [outcome for outcome in outcomes if not isinstance(outcome, Output)]
    return [errors[0]] * len(outcomes) if errors else outcomes


def swallowing(self, jobs):
    return [o if isinstance(o, Output) else Twin.run(self, jobs[:1])[0]
            for o in Twin.run(self, jobs)]  # fmt: skip


def middle_off(outputs):
    """Return outputs of which the middle one has other places, where there are more than two."""
    middle = len(outputs) // 2
    off = replace(outputs[middle], tables={"series": {**outputs[middle].tables["series"],
                  "x_m": 2.0 * outputs[middle].tables["series"]["x_m"]}})  # fmt: skip
    return [*outputs[:middle], off, *outputs[middle + 1 :]] if len(outputs) > 2 else outputs


numbers = count()
others = Provenance("twin", "9.9")
IDENTIFIES, REFUSES, RETURNS, REPORTS, MATCHES = [check.__name__ for check in CHECKS]
# fmt: off
FAULTS = [
    (altered("OfAnother", lambda outs: [replace(o, provenance=others) for o in outs]),
     IDENTIFIES, "'twin 9.9'"),
    (fault("Fickle", identify=lambda _: Provenance("twin", f"{next(numbers)}")),
     IDENTIFIES, "found .'twin "),
    (fault("Restless", fingerprint=lambda _: {"made": next(numbers)}),
     IDENTIFIES, "expected one fingerprint"),
    (fault("Agreeable", refuses=lambda *_: ""), REFUSES, "a template that nobody wrote"),
    (fault("Wordy", refuses=lambda s, job: "\n".join(Twin.refuses(s, job))),
     REFUSES, "expected a line of reason"),
    (fault("Brave", Clipping, run=lambda s, jobs: s.run_scenes(jobs)), REFUSES, "RequestError"),
    (altered("Short", lambda outs: outs[:-1]), RETURNS, "7 outcomes of 8 jobs"),
    (altered("Reversed", lambda outs: outs[::-1]), RETURNS, "left .* samples|in the drop"),
    (altered("Lopsided", middle_off), RETURNS, "position = "),
    (altered("Raising", lambda outs: 1 / (len(outs) - len(outs))), RETURNS, "ZeroDivisionError"),
    (fault("Gullible", run=swallowing), REPORTS, "3 outcomes, of them 1 errors of a line"),
    (altered("Contagious", all_or_none), REPORTS, "of them 3: "),
    (fault("Rough", traits=replace(Twin.traits, digits=2)), MATCHES, "traits.digits of at least 6"),
    (changed("Light", change_scene=lighter), MATCHES, "in the reference's drop, .*, found"),
    (changed("Sparse", change_motion=lost), MATCHES, "left 40 samples, not 41"),
    (changed("Blank", change_motion=without_places), MATCHES, "not finite"),
    (changed("Backward", change_motion=lambda _, m: replace(m, velocity=-m.velocity)),
     MATCHES, "velocity = "),
    (changed("Pulling", change_motion=lambda _, m: replace(m, force=-m.force)),
     MATCHES, "force = "),
    (changed("Twisted", change_motion=lambda _, m: replace(m, torque=-m.torque)),
     MATCHES, "torque = "),
    (changed("Slow", change_motion=lambda _, m: replace(m, time=1.001 * m.time)),
     MATCHES, "left a sample at 0.00015015 s, where its step is at 0.00015 s"),
    (fault("Levered", Lammps, rules=lambda *_: Rules(wall_lever="height")),
     MATCHES, "in the reference's oblique impact, hooke"),
]
# fmt: on


def test_each_check_has_a_planted_fault():
    assert {name for _, name, _ in FAULTS} == {check.__name__ for check in CHECKS}


@pytest.mark.parametrize(
    ("kind", "name", "words"),
    [
        pytest.param(
            *row, id=row[0].__name__, marks=[pytest.mark.live] * issubclass(row[0], Lammps)
        )
        for row in FAULTS
    ],
)
def test_a_fault_fails_the_check_of_its_name_in_one_line(kind, name, words):
    (check,) = [check for check in engine_checks(kind) if check.__name__ == name]
    with pytest.raises(EngineCheckError, match=words) as caught:
        check()
    start = f"engine {kind.name!r} of package 'tests': {name}: expected "
    assert str(caught.value).startswith(start)
    assert "\n" not in str(caught.value)


def test_good_engines_pass_and_all_failures_are_named_line_by_line():
    mute = changed("Mute", change_motion=without_forces)
    assert [check_engine(kind) for kind in (Twin, Clipping, mute)] == [{}, {}, {}]
    with pytest.raises(EngineCheckError) as caught:
        check_engine(Crashing)
    failed = [line.split(": ")[1] for line in str(caught.value).splitlines()]
    assert failed == [IDENTIFIES, RETURNS, REPORTS, MATCHES]


def test_a_check_without_a_subject_is_skipped_with_its_reason():
    def refuse(*_):
        raise Unsupported("it states nothing")

    with pytest.raises(SkipTest, match="states no drop and no impact: it states nothing"):
        engine_checks(fault("Silent", rules=refuse))[-1]()
