"""The engines of another package go through the suite, as its own tests would have it."""

import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.testing import engine_checks

HERE = Path(__file__).parent


@contextmanager
def importable():
    """Make the example package importable, which need not be installed."""
    sys.path.insert(0, str(HERE / "small_dem"))
    try:
        yield
    finally:
        sys.path.remove(str(HERE / "small_dem"))


def small_dem():
    """Open the engine of the example package."""
    with importable():
        from small_dem.engine import SmallDem
    return SmallDem()


def small_contacts():
    """Open the one that takes contacts with friction, too."""
    with importable():
        from small_dem.contacts import SmallContacts
    return SmallContacts()


@pytest.mark.parametrize("check", engine_checks(small_dem))
def test_small_dem(check):
    check()


@pytest.mark.parametrize("check", engine_checks(small_contacts))
def test_small_contacts(check):
    check()


def verdicts(engine, name):
    """Return the verdicts of the contacts with a wall that the engine states, of a case."""
    case = get_case(name)
    trials = [
        trial
        for trial in case.trials("default")
        if trial.submodel in ("hooke", "hooke, velocity", "linear_history")
        and trial.system.startswith("wall")
        and "material" not in trial.system
    ]
    checks = verify_trials(case, engine, Study("quick"), trials).checks
    return {check.verdict for check in checks} - {Verdict.FINDING}


@pytest.mark.parametrize("name", ["head-on", "oblique", "spin", "slip-to-roll"])
def test_its_contacts_hold(name):
    with small_contacts() as engine:
        assert verdicts(engine, name) == {Verdict.PASS}


@pytest.mark.parametrize(
    ("value", "factor"),
    [("friction", 0.5), ("tangential_damping", 1.1), ("tangential_stiffness", 2.0)],
)
def test_a_fault_in_its_friction_fails(value, factor, monkeypatch):
    with small_contacts() as engine:
        module = sys.modules[type(engine).__module__]
        right = module.simulate
        monkeypatch.setattr(
            module, "simulate", lambda job: right({**job, value: factor * job[value]})
        )
        assert Verdict.FAIL in verdicts(engine, "oblique")
