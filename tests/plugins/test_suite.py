"""The engines of another package go through the suite, as its own tests would have it."""

import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from harness.cases.contact.verification import verify_trials
from harness.cases.registry import get_case
from harness.cases.verification import Study
from harness.comparison.verdicts import Verdict
from harness.testing import check_engine, engine_checks

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


def test_small_dem():
    (reason,) = check_engine(small_dem).values()
    assert reason == "oblique: it has no template 'contact-scene'"


@pytest.mark.parametrize("check", engine_checks(small_contacts))
def test_small_contacts(check):
    check()


def verdicts(engine, name):
    """Return the verdicts of the trials of a case that an engine states."""
    case = get_case(name)
    trials = [t for t in case.trials("default") if not engine.refuses(case.job(t.parameters))]
    return {check.verdict for check in verify_trials(case, engine, Study("quick"), trials).checks}


@pytest.mark.parametrize("name", ["oblique", "spin", "slip-to-roll"])
def test_its_contacts_hold(name):
    with small_contacts() as engine:
        assert verdicts(engine, name) == {Verdict.PASS}


@pytest.mark.parametrize("value", ["friction", "tangential_damping", "tangential_stiffness"])
def test_an_error_of_a_millionth_in_its_friction_fails(value, monkeypatch):
    with small_contacts() as engine:
        module = sys.modules[type(engine).__module__]
        right = module.plane_load

        def wrong(law, *rest):
            changed = {value: (1.0 + 1e-6) * getattr(law, value)}
            return right(law.replace(**changed), *rest)

        monkeypatch.setattr(module, "plane_load", wrong)
        assert Verdict.FAIL in verdicts(engine, "oblique")
