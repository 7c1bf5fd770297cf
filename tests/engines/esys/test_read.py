"""How ESyS-Particle is told a contact, and what its ends say."""

import re

import numpy as np
import pytest

from harness.cases.drop import case as drops
from harness.cases.drop.case import Drop
from harness.cases.incline import system as inclines
from harness.cases.incline.system import Incline
from harness.engines.esys.engine import Esys
from harness.engines.process import Ended, Limits
from harness.errors import (
    EngineInputError,
)
from harness.parameters.law import PLASTIC, Contact, hertz

INCLINE = Incline(angle=10.5, stiffness=1e5, contact=PLASTIC, steps_per_contact=50.0)
DROP = Drop(
    contact=Contact(restitution=0.5, damping_ratio=None, tail="clipped"),
    speed=1.0,
    gap=1e-4,
    steps_per_contact=200.0,
    duration=4.0,
    every=20,
)


@pytest.mark.parametrize(
    ("job", "law"),
    [
        (
            inclines.job_of(INCLINE, "passage"),
            hertz(INCLINE.contact, INCLINE.stiffness, INCLINE.mass, np.sqrt(9.81)),
        ),
        (drops.job_of(DROP), hertz(DROP.contact, DROP.stiffness, DROP.mass, DROP.speed)),
    ],
    ids=["incline", "drop"],
)
def test_the_engine_translates_the_contact_as_the_harness_does(job, law):
    told = Esys.__new__(Esys).task(job).values
    assert told["coefficient"] == pytest.approx(law.coefficient, rel=1e-14)
    assert told["relaxation"] == pytest.approx(law.relaxation, rel=1e-14)


@pytest.fixture
def engine():
    """Return an engine that only tells ends apart, without ESyS-Particle."""
    engine = Esys.__new__(Esys)
    engine.limits = Limits(seconds=7.0)
    return engine


@pytest.mark.parametrize(
    ("said", "code", "late", "error", "words"),
    [
        ("refused.txt", 1, False, EngineInputError, "could not convert string to float: 'soft'"),
    ],
)
def test_each_bad_end_has_its_error(engine, recorded, said, code, late, error, words):
    text = recorded(said) if said.endswith(".txt") else said
    found = engine.error_of(Ended(text, code, 1.0, late), "")
    assert isinstance(found, error)
    assert re.search(words, str(found))
