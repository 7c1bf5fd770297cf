"""The Hertz contact that stands for a linear one: its two conditions, met by integration."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from harness.cases.drop.case import Drop
from harness.cases.incline.system import Incline
from harness.errors import RequestError
from harness.parameters.law import (
    PLASTIC,
    SOURCE,
    STIFFEST,
    Contact,
    fewest_steps_per_contact,
    hertz,
)
from harness.solvers.grain import row

POSITIVE = st.floats(1e-6, 1e6)


def of(case):
    """Return the Hertz contact of a drop or an incline."""
    return hertz(case.contact, case.stiffness, case.mass, case.hertz_speed)


@given(POSITIVE, POSITIVE, POSITIVE)
def test_an_impact_without_damping_reaches_the_overlap_of_the_linear_spring(k, m, v):
    law = hertz(Contact(restitution=1.0, damping_ratio=None), k, m, v)
    assert law.relaxation == 0.0
    # without units: the quadrature's absolute tolerance is none for small energies
    share, _ = quad(lambda x: x**1.5, 0.0, 1.0, epsabs=0.0, epsrel=1e-11)
    work = law.coefficient * law.overlap**2.5 * share
    assert work == pytest.approx(0.5 * m * v * v, rel=1e-9)
    assert 0.5 * k * law.overlap**2 == pytest.approx(0.5 * m * v * v, rel=1e-12)


def test_the_motion_turns_there():
    law = hertz(Contact(restitution=1.0, damping_ratio=None), 1e6, 2.0, 3.0)

    def rates(_, state):
        return [state[1], -law.coefficient * max(state[0], 0.0) ** 1.5 / 2.0]

    def turns(_, state):
        return state[1]

    turns.terminal = True
    path = solve_ivp(rates, (0.0, 1.0), [0.0, 3.0], events=turns, rtol=1e-10, atol=1e-14)
    assert path.y[0, -1] == pytest.approx(law.overlap, rel=1e-8)


@pytest.mark.parametrize("mass", ["full", "half"])
def test_the_dashpot_has_the_linear_coefficient_at_that_overlap(mass):
    case = Incline(contact=PLASTIC.replace(effective_mass=mass), steps_per_contact=100.0)
    law = hertz(case.contact, case.stiffness, case.mass, case.hertz_speed)
    m_eff = case.mass * (0.5 if mass == "half" else 1.0)
    eta = 2.0 * PLASTIC.zeta * math.sqrt(case.stiffness * m_eff)
    assert law.coefficient * law.relaxation * math.sqrt(law.overlap) == pytest.approx(eta)


@given(st.floats(1e-3, 1e6))
def test_rest_slope_and_damping_ratio_are_those_of_the_force(force):
    law = of(Incline(contact=SOURCE))
    rest = law.rest(force)
    assert law.coefficient * rest**1.5 == pytest.approx(force, rel=1e-12)
    around = rest * (1.0 + np.array([-1e-5, 1e-5]))
    slope = np.ptp(law.coefficient * around**1.5) / np.ptp(around)
    assert law.slope(rest) == pytest.approx(slope, rel=1e-8)
    zeta = law.relaxation * math.sqrt(law.slope(rest) / 2.0) / 3.0
    assert law.damping_ratio(rest, 2.0) == pytest.approx(zeta, rel=1e-12)


def test_the_spring_is_at_most_so_much_stiffer_than_the_linear_one():
    case = Incline(contact=SOURCE, stiffness=1e5)
    law = hertz(case.contact, case.stiffness, case.mass, case.hertz_speed)
    assert law.slope(law.overlap) / case.stiffness == pytest.approx(STIFFEST, rel=1e-14)


def test_a_drop_and_an_incline_of_one_weight_have_one_contact():
    incline, drop = Incline(contact=PLASTIC, steps_per_contact=100.0), Drop(gravity=9.81)
    assert of(drop.replace(contact=PLASTIC)) == of(incline)


def test_a_drop_without_gravity_is_measured_by_its_speed():
    law = of(Drop(speed=3.0, sideways=4.0))
    assert law.overlap == pytest.approx(5.0 * math.sqrt(1.0 / 1e6))


def test_nothing_that_moves_is_no_scale():
    with pytest.raises(RequestError, match=r"speed = 0\.0 m/s: a Hertz contact needs a speed"):
        of(Drop())


@given(st.floats(0.0, 20.0))
def test_the_step_of_the_well_is_bounded_as_the_reference_bounds_it(zeta):
    """Written as a linear contact: sqrt(15/8) times as fast, with a smaller damping ratio."""
    contact = Contact(restitution=None, damping_ratio=zeta)
    faster = math.sqrt(STIFFEST)
    linear = row.fewest_steps_per_contact(row.FIXED_STEP["mfix-euler"].growth, zeta / faster)
    assert fewest_steps_per_contact(contact) == pytest.approx(faster * linear, rel=1e-6)
