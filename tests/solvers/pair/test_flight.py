"""Free flight: the next contact, against a search along the paths."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene
from harness.solvers.pair.geometry import flown, next_contact, normal_and_gap
from harness.solvers.pair.integration import integrate
from harness.solvers.pair.system import system_of
from tests.solvers.pair.scenes import FLOOR, STILL

SPEED = st.floats(-2.0, 2.0)
GRAVITY = (0.0, 0.0, -9.81)


def state_of(scene):
    system = system_of(scene, Rules())
    y = np.zeros(9 * len(scene.bodies) + 10 * len(system.contacts))
    for b, body in enumerate(scene.bodies):
        y[9 * b : 9 * b + 9] = (*body.position, *body.velocity, *body.omega)
    return y, system


def flight(velocity, other, frozen=False):
    bodies = (
        Body(0.1, 1.0, (0.0, 0.0, 0.5), velocity),
        Body(0.2, 8.0, (0.6, 0.1, 0.7), other, frozen=frozen),
    )
    return ContactScene(bodies, (FLOOR,), ContactLaw(), 0.01, 100, gravity=GRAVITY)


@given(st.tuples(SPEED, SPEED, SPEED), st.tuples(SPEED, SPEED, SPEED), st.booleans())
@settings(max_examples=60, deadline=None)
def test_nothing_touches_before_the_next_contact_which_does(velocity, other, frozen):
    y, system = state_of(flight(velocity, STILL if frozen else other, frozen))
    wait, contact = next_contact(y, system)
    for time in np.linspace(0.0, min(wait, 2.0), 200)[:-1]:
        now = flown(y, system, time)
        assert all(normal_and_gap(now, system, c)[1] < 0.0 for c in range(len(system.contacts)))
    if np.isfinite(wait):
        then = flown(y, system, wait)
        assert normal_and_gap(then, system, contact)[1] == pytest.approx(0.0, abs=1e-12)


def test_a_fall_from_rest():
    y, system = state_of(flight(STILL, STILL, frozen=True))
    assert next_contact(y, system)[0] == pytest.approx(np.sqrt(2 * 0.4 / 9.81), rel=1e-13)


def test_bodies_that_never_meet_fly_on():
    bodies = (Body(0.1, 1.0, STILL), Body(0.1, 1.0, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
    path = integrate(ContactScene(bodies, (), ContactLaw(), 0.01, 100, gravity=GRAVITY))
    assert not path.events
    assert path.positions[-1, :, 2] == pytest.approx(-0.5 * 9.81, rel=1e-12)
    assert path.steps == 0
