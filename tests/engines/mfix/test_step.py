"""DTSOLID_FACTOR and steps per contact, both ways."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.grain import steps_of_factor
from harness.engines.mfix.contacts import CONTACT
from harness.engines.mfix.system import LEAST_FACTOR, factor, steps_per_contact
from harness.errors import RequestError
from harness.parameters.law import SOURCE, Contact


@given(
    given_factor=st.floats(LEAST_FACTOR * 1.001, 1e6),
    restitution=st.floats(1e-20, 1.0),
)
def test_the_factor_is_the_inverse_of_the_steps(given_factor, restitution):
    contact = Contact(restitution=restitution, damping_ratio=None, effective_mass="half")
    steps = steps_per_contact(given_factor, contact)
    assert factor(steps, contact) == pytest.approx(given_factor, rel=1e-12)


def test_the_default_factor_of_50_is_not_five_steps_at_the_recorded_restitution():
    logarithm = math.log(1e-20)
    expected = 50 * math.sqrt(2) * math.pi / math.hypot(math.pi, logarithm)
    assert steps_per_contact(50, CONTACT) == pytest.approx(expected, rel=1e-12)
    assert expected == pytest.approx(4.8, abs=0.03)


@pytest.mark.parametrize(
    ("steps", "contact", "said"),
    [
        (0.9, CONTACT, "DTSOLID_FACTOR = 9.35"),
        (math.nan, CONTACT, "which takes 10 or more"),
        (50.0, SOURCE, "takes half the mass"),
        (50.0, CONTACT.replace(restitution=0.0), "asks for less than 1"),
    ],
)
def test_steps_that_mfix_cannot_take_are_refused(steps, contact, said):
    with pytest.raises(RequestError, match=said):
        factor(steps, contact)


def test_without_damping_the_contact_time_is_that_of_half_the_mass():
    undamped = CONTACT.replace(restitution=1.0)
    assert steps_per_contact(50, undamped) == steps_of_factor(50, undamped)
    assert steps_per_contact(50, CONTACT) == steps_of_factor(50, CONTACT)
    assert steps_per_contact(50, undamped) == pytest.approx(50 * math.sqrt(2))


@pytest.mark.parametrize(
    ("given_factor", "contact"),
    [(0.0, CONTACT), (math.nan, CONTACT), (50, SOURCE), (50, CONTACT.replace(restitution=0.0))],
)
def test_a_step_that_mfix_does_not_have_is_refused(given_factor, contact):
    with pytest.raises(RequestError):
        steps_per_contact(given_factor, contact)
