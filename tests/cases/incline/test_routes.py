"""Starts and ends of the routes, and the energy by which a grain is judged."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.incline.system import (
    Incline,
    Start,
    crest_energy,
    crest_place,
    end_of,
    energy,
    margin,
    overlaps,
    settled_place,
    start_of,
)
from harness.errors import RequestError
from harness.parameters.law import CONTACTS

ANGLES = st.floats(0.0, 30.0)


@given(st.floats(0.0, 29.0), st.integers(1, 50))
def test_a_grain_at_rest_on_a_crest_has_no_margin(angle, well):
    case = Incline(angle=angle)
    tilt = math.radians(angle)
    x = crest_place(case, well)
    y = case.diameter * (1.0 - case.static_overlap) * math.cos(tilt)
    left = margin(case, well, x, y, 0.0, 0.0)
    assert left == pytest.approx(0.0, abs=1e-12 * well * case.weight_energy)


@given(ANGLES, st.floats(0.0, 1.0), st.sampled_from(sorted(CONTACTS)))
def test_the_passage_starts_with_the_energy_of_the_crest_behind_it(angle, phase, name):
    case = Incline(angle=angle, phase=phase, contact=CONTACTS[name], steps_per_contact=100.0)
    start = start_of(case, "passage")
    assert energy(case, *start.state()) == pytest.approx(crest_energy(case), rel=1e-12)
    assert max(overlaps(case, start.x_m, start.y_m)) > 0.0


def test_the_steady_route_starts_between_two_spheres_just_touching():
    start = start_of(Incline(), "steady")
    assert overlaps(Incline(), start.x_m, start.y_m) == pytest.approx((0.0, 0.0), abs=1e-15)


@given(ANGLES, st.floats(-5.0, 5.0), st.floats(0.5, 3.0), st.floats(-2.0, 2.0))
def test_arrays_are_judged_as_numbers_are(angle, x, y, v):
    case = Incline(angle=angle)
    state = (x, y, v, -v)
    several = energy(case, *(np.array([value, value]) for value in state))
    # powers of arrays and of numbers may differ in the last bit
    assert several.tolist() == pytest.approx([energy(case, *state)] * 2, rel=1e-14)


def test_a_passage_ends_before_the_crest_but_past_the_well():
    case = Incline(angle=10.0, stiffness=1e7)
    assert 0.5 * case.diameter < settled_place(case) < crest_place(case, 1)
    assert end_of(case, "passage", 1) == settled_place(case)
    assert end_of(case, "steady", 4) == crest_place(case, 4)


def test_a_start_that_is_not_finite_is_refused():
    with pytest.raises(RequestError, match="finite numbers"):
        Start(0.0, math.nan, 0.0, 0.0).state()
