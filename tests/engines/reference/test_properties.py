"""What must hold whatever the numbers: shifts in time and along the row, other units."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harness.cases.incline.runs import follow, run_inclines
from harness.cases.incline.system import Incline, Start, crest_energy, energy, start_behind_crest
from harness.engines.reference import INTEGRATORS, Reference
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE

CONTACTS = st.sampled_from([SOURCE, CLIPPED, PLASTIC])
FIXED = st.sampled_from([name for name in INTEGRATORS if name != "adaptive"])
STEPS = 100.0
few = settings(max_examples=25, deadline=None)


def path(case, start, integrator, steps=400):
    return follow(Reference(integrator), case, start, steps * case.step, every=50)


@few
@given(FIXED, CONTACTS, st.integers(-5, 5), st.floats(0.3, 0.7))
def test_the_row_is_periodic(integrator, contact, spheres, x):
    case = Incline(contact=contact, steps_per_contact=STEPS)
    start = Start(x, math.sqrt(1.0 - min(x, 1 - x) ** 2), 0.4, -0.3)
    here = path(case, start, integrator)
    there = path(case, Start(x + spheres, start.y_m, 0.4, -0.3), integrator)
    # the last digits of x differ; a contact of 100 steps multiplies them little
    np.testing.assert_allclose(there.x_m - spheres, here.x_m, atol=1e-9)
    np.testing.assert_allclose(there.y_m, here.y_m, atol=1e-9)


@few
@given(st.sampled_from(["mfix-euler", "rk4"]), CONTACTS, st.integers(1, 7))
def test_a_run_goes_on_from_where_another_ended(integrator, contact, fiftieths):
    case = Incline(contact=contact, steps_per_contact=STEPS)
    whole = path(case, Start(0.45, 0.9, 0.3, -0.5), integrator)
    first = [
        float(column[fiftieths])
        for column in (whole.x_m, whole.y_m, whole.vx_m_per_s, whole.vy_m_per_s)
    ]
    rest = path(case, Start(*first), integrator, 400 - 50 * fiftieths)
    np.testing.assert_array_equal(rest.x_m, whole.x_m[fiftieths:])
    np.testing.assert_array_equal(rest.vy_m_per_s, whole.vy_m_per_s[fiftieths:])


@few
@given(
    st.sampled_from(["velocity-verlet", "mfix-euler", "mfix-adams-bashforth", "rk4"]),
    CONTACTS,
    st.floats(1e-3, 1e2),
    st.floats(0.1, 1e4),
    st.floats(0.5, 50.0),
)
def test_only_the_relative_stiffness_matters(integrator, contact, diameter, density, gravity):
    """The path in d and sqrt(d/g) is the same in other units at the same k d / (m g)."""
    base = Incline(contact=contact, steps_per_contact=STEPS)
    other = base.replace(diameter=diameter, density=density, gravity=gravity, stiffness=1e200)
    stiffness = other.mass * gravity / (base.static_overlap * diameter)
    other = other.replace(stiffness=stiffness)
    runs = []
    for case in (base, other):
        (run,) = run_inclines(Reference(integrator), [case], "passage")
        runs.append(run)
    margins = [run.margin_J / run.case.weight_energy for run in runs]
    assert runs[0].motion is runs[1].motion
    assert abs(runs[0].steps - runs[1].steps) <= 50
    assert margins[1] == pytest.approx(margins[0], abs=1e-7)


@few
@given(CONTACTS, st.floats(0.0, 25.0), st.floats(0.0, 1.0))
def test_the_passage_starts_with_the_energy_of_the_crest(contact, angle, phase):
    case = Incline(contact=contact, angle=angle, phase=phase)
    total = energy(case, *start_behind_crest(case).state())
    assert total == pytest.approx(crest_energy(case), rel=1e-12)
