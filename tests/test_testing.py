"""The suite of engines passes good ones, and each planted fault fails the check of its name."""

from dataclasses import replace
from itertools import count
from unittest import SkipTest

import numpy as np
import pytest

from harness.engines.lammps.engine import Lammps
from harness.engines.output import Output
from harness.errors import EngineCrashError, Unsupported
from harness.model.conventions import Rules
from harness.observables.provenance import Provenance
from harness.testing import CHECKS, EngineCheckError, check_engine, engine_checks
from tests.engine_doubles import Half, Twin, frictionless


class Plain(Twin):
    """The reference, without scenes of spheres and walls."""

    name = "plain"
    traits = replace(Twin.traits, conventions=None)


def fault(label, base=Plain, **members):
    """Return a subclass with other members, as an engine of the package ``tests``."""
    return type(label, (base,), {"__module__": __name__, **members})


def altered(label, alter):
    """Return an engine whose outcomes are altered by a function of them."""
    return fault(label, run=lambda self, jobs: alter(Plain.run(self, jobs)))


def told(label, name, change, **members):
    """Return an engine that changes a value of its jobs."""
    change_values = lambda v: {**v, name: change(v[name])}  # noqa: E731
    return fault(label, __init__=lambda self: Plain.__init__(self, change_values), **members)


def changed(output, **columns):
    """Return an output with columns of samples changed by functions."""
    series = output.tables["series"]
    series = {name: columns.get(name, np.array)(values) for name, values in series.items()}
    return replace(output, tables={"series": series})


def contagious(self, jobs):
    if not all(np.isfinite(job.values["speed"]) for job in jobs):
        return [EngineCrashError("a value is not a number") for _ in jobs]
    return Plain.run(self, jobs)


def without_jkr(self, scene):
    if scene.law.normal == "jkr":
        raise Unsupported("it has no jkr")
    return Lammps.rules(self, scene)


def giving_up(self, jobs):
    outcomes = Lammps.run(self, jobs)
    errors = [outcome for outcome in outcomes if not isinstance(outcome, Output)]
    return [errors[0]] * len(jobs) if errors else outcomes


numbers = count()
others = Provenance("plain", "9.9")
COLUMNS = ("step", "time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")
CLIPPED = replace(Plain.traits, frictionless=frictionless(tail="clipped"))
halved = dict.fromkeys(COLUMNS, lambda v: v[::2])
NAMES = [check.__name__ for check in CHECKS]
IDENTIFIES, REFUSES, RETURNS, REPORTS, MATCHES = NAMES
# fmt: off
FAULTS = [
    (altered("OfAnother", lambda outs: [replace(o, provenance=others) for o in outs]),
     IDENTIFIES, "'plain 9.9'"),
    (fault("Unnamed", identify=lambda _: Provenance("another", "1")),
     IDENTIFIES, "expected 'plain' and a version"),
    (fault("Fickle", identify=lambda _: Provenance("plain", f"{next(numbers)}")),
     IDENTIFIES, "found .'plain "),
    (fault("Restless", fingerprint=lambda _: {"made": next(numbers)}),
     IDENTIFIES, "expected one fingerprint"),
    (fault("Agreeable", states=classmethod(lambda _, template: True)),  # noqa: ARG005
     REFUSES, "a template that nobody wrote"),
    (fault("Unclipped", traits=CLIPPED, refuses=lambda s, j: "" if s.states(j.template) else "no"),
     REFUSES, "against drop with tail = attractive, found ''"),
    (fault("Wordy", refuses=lambda s, job: "\n".join(Plain.refuses(s, job))),
     REFUSES, "expected a line of reason"),
    (altered("Short", lambda outs: outs[:-1]), RETURNS, "returned 2 outcomes, must return"),
    (altered("Reversed", lambda outs: outs[::-1]), RETURNS, "x_m = .* in job 0 alone"),
    (altered("Growing", lambda outs: [changed(o, y_m=lambda y: y * len(outs)) for o in outs]),
     RETURNS, "y_m = "),
    (altered("Raising", lambda outs: 1 / (len(outs) - len(outs))), RETURNS, "ZeroDivisionError"),
    (told("Gullible", "speed", lambda v: np.nan_to_num(v, nan=1.0), refuses=lambda *_: ""),
     REPORTS, "expected 3 outcomes, of them 1 errors of a line, found 3, of them 0"),
    (fault("Contagious", run=contagious), REPORTS, "of them 3: a value is not a number"),
    (told("Light", "gravity", lambda g: 0.999999 * g), MATCHES, "in the reference's drop, found"),
    (altered("Sparse", lambda outs: [changed(o, **halved) for o in outs]),
     MATCHES, "expected 41 values of time_s in the reference's drop, found 21"),
    (fault("Levered", Lammps, rules=lambda *_: Rules(wall_lever="height")),
     MATCHES, "in the reference's hooke impact"),
    (fault("Hasty", Lammps, rules=without_jkr,
           refuses=lambda self, job: "" if job.scene else Lammps.refuses(self, job)),
     MATCHES, "found Unsupported"),
    (fault("Fragile", Lammps, run=giving_up, __init__=lambda s: Lammps.__init__(s, lmp="lmp")),
     REPORTS, "of them 3: "),
]
# fmt: on


def test_each_check_has_a_planted_fault():
    assert {name for _, name, _ in FAULTS} == set(NAMES)


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
    assert str(caught.value).startswith(
        f"engine {kind.name!r} of package 'tests': {name}: expected "
    )
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", [Twin, Plain, Half])
def test_a_good_engine_passes_whatever_its_rules_are(kind):
    assert set(check_engine(kind)) <= {MATCHES}


def test_a_check_without_a_subject_is_skipped_with_its_reason():
    with pytest.raises(SkipTest, match="oblique: it has no template"):
        engine_checks(Plain)[-1]()


def test_all_failures_are_named_line_by_line():
    with pytest.raises(EngineCheckError) as caught:
        check_engine(altered("Raising", lambda outs: 1 / (len(outs) - len(outs))))
    failed = [line.split(": ")[1] for line in str(caught.value).splitlines()]
    assert failed == [IDENTIFIES, RETURNS, MATCHES]
