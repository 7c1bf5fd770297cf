"""The geometry against the closed forms, which were derived without positions."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.theory import incline
from harness.theory.incline import critical_angle, no_flight_bound

angles = st.floats(0.0, 30.0)


def distances(points, position):
    return np.hypot(*(points - position).T)


def test_the_grain_in_the_well_touches_two_spheres_and_no_other():
    apart = distances(incline.row(4), incline.well(1))
    assert apart[1:3] == pytest.approx([1, 1], abs=1e-15)
    assert (apart[[0, 3]] > 1.5).all()


def test_the_well_is_30_deg_either_side_of_the_normal():
    grain = incline.well(0)
    for sphere in incline.row(2):
        assert incline.angle_between(grain - sphere, (0, 1)) == pytest.approx(30)


@given(angles)
def test_well_depth_and_gain_from_positions(angle):
    crests = [incline.height(incline.crest(i, angle), angle) for i in (0, 1)]
    well = incline.height(incline.well(0), angle)
    assert crests[1] - well == pytest.approx(incline.well_depth(angle), abs=1e-14)
    assert crests[0] - crests[1] == pytest.approx(incline.gain_per_crest(angle), abs=1e-14)


@given(angles)
def test_no_point_of_the_path_is_higher_than_the_crest(angle):
    """A crest is a maximum, found by search instead of by the direction of gravity."""
    path = incline.path(0, 2)
    over = path[np.abs(path[:, 0] - 1) < 0.5]
    highest = max(incline.height(p, angle) for p in over)
    crest = incline.height(incline.crest(1, angle), angle)
    assert highest <= crest + 1e-12
    assert highest == pytest.approx(crest, abs=1e-3)


def test_at_the_static_angle_the_well_is_the_crest():
    assert incline.crest(1, 30.0) == pytest.approx(incline.well(0))


def test_the_path_keeps_its_distance():
    apart = np.array([distances(incline.row(4), p).min() for p in incline.path(0, 3)])
    assert apart == pytest.approx(1, abs=1e-12)


@given(st.floats(0.5, 30.0))
def test_the_shock_turns_the_velocity_by_60_deg_and_keeps_its_projection(angle):
    before, after = incline.steady_shock(angle)
    assert incline.angle_between(before.velocity, after.velocity) == pytest.approx(60)
    onwards = after.velocity / np.hypot(*after.velocity)
    assert before.velocity @ onwards == pytest.approx(np.hypot(*after.velocity))


def test_after_the_shock_the_grain_just_reaches_the_crest_at_the_critical_angle():
    _, after = incline.steady_shock(critical_angle())
    assert after.velocity @ after.velocity / 2 == pytest.approx(
        incline.well_depth(critical_angle())
    )


@given(st.floats(0.5, 29.5))
def test_the_contact_force_vanishes_at_the_bound_of_flight(angle):
    """Force from positions against the closed form of the angle where contact is lost."""
    before, after = incline.steady_shock(angle)
    pressing = float(before.contact_force @ (before.grain - before.sphere))
    assert (pressing > 0) == (angle < no_flight_bound())
    for state in (before, after):
        along = state.grain - state.sphere
        assert float(state.contact_force @ along) <= state.normal_weight
        # Newton along the contact: what is left of the weight turns the velocity
        total = state.weight + state.contact_force
        assert -float(total @ along) == pytest.approx(float(state.velocity @ state.velocity))


@given(angles)
def test_turned_points_keep_their_distances_and_stand_upright(angle):
    points = incline.row(3)
    world = incline.turned(points, angle)
    assert distances(world, world[0]) == pytest.approx(distances(points, points[0]))
    assert world[:, 1] == pytest.approx([incline.height(p, angle) for p in points])
    down = incline.turned(incline.downwards(angle), angle)
    assert down == pytest.approx([0, -1], abs=1e-15)
    assert world[1, 1] <= 0  # downhill is down


@pytest.mark.parametrize("layers", [1, 2, 5])
@pytest.mark.parametrize(
    ("arrange", "sideways"), [(incline.towers, 0.0), (incline.close_packed, 0.5)]
)
def test_layers_touch_and_do_not_overlap(arrange, sideways, layers):
    spheres = arrange(4, layers)
    pairs = np.hypot(*(spheres[:, None] - spheres[None, :]).reshape(-1, 2).T)
    assert pairs[pairs > 0].min() == pytest.approx(1)
    assert len(spheres) == 4 * (layers + 1)
    top = spheres[4 * layers]
    assert top == pytest.approx([sideways * (layers % 2), layers * math.sqrt(1 - sideways**2)])


@pytest.mark.parametrize("layers", [1, 4])
def test_only_close_packed_layers_go_on_along_the_contact(layers):
    for arrange, length in ((incline.towers, 1), (incline.close_packed, layers + 1)):
        spheres = arrange(8, layers)
        top = spheres[8 * layers :][3:5]
        grain = incline.resting_on(*top)
        chain = incline.straight_chain(grain, spheres, top[1])
        assert len(chain) == length
    assert incline.straight_chain((0, 1), incline.towers(2, 3) - [0, 3], (0, 0)).shape == (4, 2)
