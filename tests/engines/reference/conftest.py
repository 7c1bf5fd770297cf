"""What the tests of the reference DEM share."""

import math

import pytest

from harness.cases.incline.runs import follow
from harness.cases.incline.system import Incline, Start
from harness.engines.reference import Reference
from harness.parameters.law import Contact


@pytest.fixture(scope="session")
def collide():
    """Return a function that drops the grain head-on on one sphere and returns e [-].

    ``phase`` is where in a step the contact begins.
    """

    def run(contact, integrator, steps, phase=0.0):
        case = Incline(angle=0.0, contact=contact, gravity=1e-12, steps_per_contact=steps)
        start = Start(0.0, 1.0 + phase * case.step, 0.0, -1.0)
        duration = 25.0 * case.contact_time
        path = follow(Reference(integrator), case, start, duration, every=math.ceil(steps))
        return path.vy_m_per_s[-1]

    return run


@pytest.fixture(scope="session")
def contact():
    """Return a function that makes a contact by its restitution."""

    def make(restitution, tail="attractive", effective_mass="full"):
        return Contact(
            restitution=restitution, damping_ratio=None, tail=tail, effective_mass=effective_mass
        )

    return make
