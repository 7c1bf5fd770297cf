"""The reference DEM with Hertz's spring: its orders, its two routes, the rigid limit."""

import math

import numpy as np
import pytest

from harness.cases.incline.angle import critical_angle
from harness.cases.incline.runs import follow, run_inclines
from harness.cases.incline.system import Incline, Start, energy
from harness.comparison.convergence import slope_order
from harness.engines.reference import Reference
from harness.errors import RequestError
from harness.parameters.law import CLIPPED, PLASTIC
from harness.theory.incline import critical_angle as closed_form

CASE = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=200.0)


def ends(path):
    return np.array([path.x_m[-1], path.y_m[-1]])


@pytest.mark.parametrize(
    ("integrator", "order"), [("velocity-verlet", 2), ("mfix-euler", 1), ("rk4", 4)]
)
def test_order_while_the_contact_does_not_change(integrator, order, contact):
    """The grain rings on the flank of one sphere, pressed in deeply: nothing begins or ends."""
    case = Incline(angle=0.0, stiffness=1e4, contact=contact(1.0), gravity=9.81)
    start, duration = Start(0.02, 0.95, 0.1, 0.05), 0.2 * case.contact_time
    end = ends(follow(Reference("adaptive", spring="Hertz"), case, start, duration, every=10))
    steps = 20.0 * 2.0 ** np.arange(5)
    errors = []
    for count in steps:
        fine = case.replace(steps_per_contact=float(count))
        path = follow(Reference(integrator, spring="Hertz"), fine, start, duration)
        errors.append(math.hypot(*(ends(path) - end)))
    found, _ = slope_order(1.0 / steps, errors)
    assert found == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize(("integrator", "most"), [("rk4", 1e-6), ("adaptive", 1e-9)])
def test_energy_is_kept_without_damping(integrator, most, contact):
    case = Incline(angle=0.0, stiffness=1e4, contact=contact(1.0), steps_per_contact=200.0)
    engine = Reference(integrator, spring="Hertz")
    path = follow(engine, case, Start(0.02, 0.95, 0.1, 0.05), 20.0 * case.contact_time, every=20)
    state = (path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s)
    total = energy(case, *state, "Hertz")
    assert np.abs(total / total[0] - 1.0).max() < most


def test_fixed_steps_lead_to_the_adaptive_angle():
    exact = critical_angle(CASE, engine=Reference("adaptive", spring="Hertz"), phases=2)
    found = critical_angle(CASE, engine=Reference("rk4", spring="Hertz"))
    assert found.value_deg == pytest.approx(exact.value_deg, abs=found.uncertainty_deg + 1e-5)


@pytest.mark.parametrize("contact", [PLASTIC, CLIPPED], ids=lambda c: c.name)
def test_both_routes_tell_one_angle(contact):
    case, engine = CASE.replace(contact=contact), Reference("rk4", spring="Hertz")
    passage = critical_angle(case, engine=engine)
    steady = critical_angle(case, engine=engine, method="steady")
    assert steady.value_deg == pytest.approx(passage.value_deg, abs=steady.uncertainty_deg + 1e-3)


def test_the_rigid_limit_is_the_closed_form():
    """Less than 0.02 deg away at 1e5 N/m, and nearer by four or more with each decade."""
    engine = Reference("rk4", spring="Hertz")
    bias = [
        abs(critical_angle(CASE.replace(stiffness=k), engine=engine).value_deg - closed_form())
        for k in (1e5, 1e6, 1e7)
    ]
    assert bias[0] < 0.02
    assert bias[0] > 4.0 * bias[1] > 16.0 * bias[2]


def test_what_it_declares_is_what_it_was_told():
    traits = Reference("rk4", spring="Hertz").traits
    assert (traits.spring, traits.integrator) == ("Hertz", "rk4")
    assert Reference.traits.spring == Reference().traits.spring == "linear"


def test_a_spring_that_is_not_known_is_refused():
    with pytest.raises(RequestError, match="spring 'cubic' is not known: must be linear or Hertz"):
        Reference(spring="cubic")


def test_a_step_too_coarse_for_the_stiffest_overlap_is_refused():
    case = CASE.replace(steps_per_contact=23.8)
    run_inclines(Reference("mfix-euler"), [case], "passage")
    with pytest.raises(RequestError, match=r"unstable with mfix-euler .* greater than 23\.853"):
        run_inclines(Reference("mfix-euler", spring="Hertz"), [case], "passage")
