"""Yade itself where it is, recorded output of it, and the cases that were recorded."""

import shutil
from pathlib import Path

import pytest

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.engines.yade.engine import Yade
from harness.parameters.contact import PLASTIC
from harness.parameters.tower import Tower

RECORDED = Path(__file__).parent / "recorded"


@pytest.fixture(scope="session")
def incline():
    return Incline(angle=10.5, contact=PLASTIC, stiffness=1e5)


@pytest.fixture(scope="session")
def drop():
    contact = PLASTIC.replace(name="e = 0.5", damping_ratio=None, restitution=0.5)
    return Drop(contact=contact, speed=1.0, steps_per_contact=100.0, duration=2.0, every=20)


@pytest.fixture(scope="session")
def tower():
    return Tower(height=2, law="overlap", stiffness=1e5)


@pytest.fixture
def recorded():
    """Return a function that reads a recorded output by name."""
    return lambda name: (RECORDED / name).read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def yade():
    """Return Yade, ready to run; skip with the reason where there is none."""
    if shutil.which("yade") is None:
        pytest.skip("no Yade on PATH")
    with Yade(workers=2) as engine:
        yield engine
