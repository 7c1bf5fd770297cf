"""The incline: geometry, energy map, critical angle; friction and sizes; their second routes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from harness.errors import RequestError
from harness.model.law import Law
from harness.model.scene import Body, Scene
from harness.solvers import reference
from harness.theory import incline
from harness.theory.chain import shock_from_impulse_ratio, shock_from_restitution
from harness.theory.incline import CREST, Grain, State, integrated_critical_angle
from tests.theory.closed_forms import slid_over_sphere

ANGLES, SHOCKS = st.floats(0.0, 30.0), st.floats(0.0, 1.0)


# ---- geometry, which the closed forms were derived without


@given(ANGLES)
def test_well_depth_and_gain_are_differences_of_height(angle):
    def height(along, normal):
        tilt = math.radians(angle)
        return normal * math.cos(tilt) - along * math.sin(tilt)

    crests = [1.0 + height(sphere, 0.0) for sphere in (0, 1)]
    found = incline.well_depth(angle), incline.gain_per_crest(angle)
    expected = crests[1] - height(0.5, math.sqrt(0.75)), crests[0] - crests[1]
    assert found == pytest.approx(expected, abs=1e-14)


# ---- energy map


@pytest.mark.parametrize("angle", [5.0, 10.2, 15.0])
def test_one_cycle_agrees_with_sliding_motion_integrated_over_a_sphere(angle):
    start, theta = incline.well_depth(angle) + 0.05, math.radians(angle)
    arrival = slid_over_sphere(theta, start).y_events[0][0][1]
    survives = (arrival * math.cos(math.radians(60))) ** 2 / 2
    assert incline.after_next_shock(start, angle, 0.25) == pytest.approx(survives, rel=1e-8)


@given(st.floats(0.0, 2.0), st.integers(1, 40), ANGLES, SHOCKS)
def test_closed_form_energies_are_the_recursion_iterated(start, shocks, angle, shock):
    energy, expected = start, []
    for _ in range(shocks):
        energy = shock * (energy + incline.gain_per_crest(angle))
        expected.append(energy)
    # E* cancels in the closed form: its error grows as 1 / (1 - shock)
    tolerance = 1e-12 * (1.0 + (incline.steady_energy(angle, shock) if shock < 1.0 else shocks))
    assert incline.energies(start, shocks, angle, shock) == pytest.approx(expected, abs=tolerance)


@given(ANGLES, st.floats(0.0, 0.99))
def test_the_steady_energy_is_a_fixed_point_and_clears_the_crest_with_a_margin(angle, shock):
    rest = incline.steady_energy(angle, shock)
    assert incline.after_next_shock(rest, angle, shock) == pytest.approx(rest, rel=1e-12, abs=1e-15)
    excess = rest - incline.well_depth(angle)
    assert incline.passage_margin(angle, shock) == pytest.approx((1.0 - shock) * excess, abs=1e-12)


# ---- critical angle


def keeps_moving(angle, shock, energy=5.0, wells=4000):
    theta = math.radians(angle)
    ahead, behind = (1 - math.cos(math.pi / 6 + sign * theta) for sign in (-1, 1))
    for _ in range(wells):
        if energy < ahead:
            return False
        energy = shock * (energy - ahead + behind)
    return True


@pytest.mark.parametrize("shock", [0.01, 0.1, 0.25, 0.5, 0.9])
def test_the_angle_is_the_root_of_the_steady_state_and_where_the_fate_changes(shock):
    def excess(angle):
        return incline.steady_energy(angle, shock) - incline.well_depth(angle)

    angle = incline.critical_angle(shock)
    assert angle == pytest.approx(brentq(excess, 0.0, 30.0, xtol=1e-12), abs=1e-9)
    assert keeps_moving(angle + 1e-6, shock)
    assert not keeps_moving(angle - 1e-6, shock)


def test_limits_of_the_shock():
    assert incline.critical_angle() == pytest.approx(10.20782, abs=5e-6)  # the source's value
    assert incline.critical_angle(0.0) == pytest.approx(incline.STATIC_ANGLE_DEG, rel=1e-14)
    assert incline.critical_angle(1e-12) == pytest.approx(30.0, abs=1e-4)
    assert incline.critical_angle(1.0 - 1e-12) == pytest.approx(0.0, abs=1e-9)
    assert incline.steady_energy(10.0, 1.0) == math.inf


def test_the_bound_of_flight_is_where_the_integrated_contact_force_vanishes():
    def smallest_force(angle):  # [m g] in steady motion, from well to well
        slid = slid_over_sphere(math.radians(angle), incline.steady_energy(angle, 0.25))
        return float(np.min(np.cos(slid.y[0]) - slid.y[1] ** 2))

    root = brentq(smallest_force, 12.0, 20.0, xtol=1e-8)
    assert incline.no_flight_bound() == pytest.approx(root, abs=1e-6)
    bounds = [incline.no_flight_bound(shock) for shock in np.linspace(0.0, 0.99, 9)]
    assert bounds[-1] > 0.0
    assert bounds == sorted(bounds, reverse=True)


@pytest.mark.parametrize("value", [-0.1, 1.1, math.nan])
@pytest.mark.parametrize(
    "function", [incline.critical_angle, incline.no_flight_bound, shock_from_restitution]
)
def test_a_value_out_of_range_is_named(function, value):
    with pytest.raises(RequestError, match=r"^\w+ = \S+ is not allowed: must be from 0 to "):
        function(value)


# ---- the shock in the well


@given(SHOCKS)
def test_the_shock_of_a_restitution_is_that_of_a_collision_in_vectors(restitution):
    before, normal = (
        np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
        for angle in (-30.0, 120.0)
    )
    after = before - (1 + restitution) * (before @ normal) * normal
    kept = after @ after
    assert shock_from_restitution(restitution) == pytest.approx(kept, rel=1e-12)
    lost = shock_from_restitution(restitution, "lost")
    assert lost == pytest.approx((1.0 - math.sqrt(kept)) ** 2, abs=1e-12)


@given(st.floats(1e-6, 2.0 - 1e-6))
def test_the_impulse_of_a_rigid_base_leaves_half_of_the_velocity(ratio):
    kept, lost = (shock_from_impulse_ratio(ratio, reading) for reading in ("kept", "lost"))
    assert kept == pytest.approx(0.25 * ratio**2, rel=1e-12)
    assert math.sqrt(kept) + math.sqrt(lost) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 2.0, math.nan])
def test_ratios_out_of_range_and_other_readings_are_named(ratio):
    with pytest.raises(RequestError, match=r"^impulse-ratio = .* than 2$"):
        shock_from_impulse_ratio(ratio)
    with pytest.raises(RequestError, match="'given' is not allowed: must be 'kept' or 'lost'"):
        shock_from_impulse_ratio(0.5, "given")


# ---- friction and sizes


SPHERE, DISC = 0.4, 0.5
HALF_ANGLES = st.floats(3.0, 33.0)
INERTIAS = st.floats(0.05, 1.0)
EQUAL = math.pi / 6
SYSTEMS = pytest.mark.parametrize(
    ("inertia", "ratio"), [(SPHERE, 1.0), (DISC, 1.0), (SPHERE, 2.0), (DISC, 0.85)]
)


def half_angle(ratio):
    return math.radians(incline.well_half_angle(ratio))


# ---- a whole well, by an ODE in time with events


def followed(state, end, grain):
    """Integrate in time: slip and rolling from event to event; return the state at the end."""
    mu, beta = grain
    angle, v, w = state
    while angle < end - 1e-13:
        rolls = abs(v - w) < 1e-10
        normal = math.cos(angle) - v * v
        rolls = rolls and beta / (1 + beta) * abs(math.sin(angle)) < mu * normal * (1 - 1e-9)
        sign = math.copysign(1.0, math.sin(angle) if abs(v - w) < 1e-10 else v - w)

        def rates(_, y, rolls=rolls, sign=sign):
            friction = sign * mu * (math.cos(y[0]) - y[1] ** 2)
            if rolls:
                friction = beta / (1 + beta) * math.sin(y[0])
            return [y[1], math.sin(y[0]) - friction, friction / beta]

        def change(t, y, rolls=rolls, sign=sign):
            if rolls:
                normal = math.cos(y[0]) - y[1] ** 2
                return beta / (1 + beta) * abs(math.sin(y[0])) - mu * normal
            return sign * (y[1] - y[2]) + 1e-14 if t > 1e-7 else 1.0

        def done(_, y):
            return y[0] - end

        change.terminal = done.terminal = True
        change.direction = 1.0 if rolls else -1.0
        run = solve_ivp(rates, (0.0, 100.0), [angle, v, w], events=(change, done),
                        method="DOP853", rtol=1e-11, atol=1e-13)  # fmt: skip
        angle, v, w = run.y[:, -1]
        if not rolls and run.t_events[0].size:
            v = w = (v + beta * w) / (1 + beta)
    return State(angle, v, w)


@SYSTEMS
@pytest.mark.parametrize("friction", [0.01, 0.08, 0.2, 0.34, 2.0])
def test_a_well_is_that_of_the_equations_in_time(inertia, ratio, friction):
    grain, phi = Grain(friction, inertia), half_angle(ratio)
    tilt = math.radians(integrated_critical_angle(math.degrees(phi), grain) + 0.3)
    start = State(1e-3, 1e-3 / math.sqrt(1 + inertia), 1e-3 / math.sqrt(1 + inertia))
    before = followed(start, phi + tilt, grain)
    assert before == pytest.approx(incline.over_arc(CREST, phi + tilt, grain), abs=1e-7)
    after = State(tilt - phi, *incline.after_shock(before, grain, phi))
    next_crest = incline.over_arc(after, 0.0, grain)
    assert followed(after, 0.0, grain) == pytest.approx(next_crest, abs=1e-7)


@SYSTEMS
@pytest.mark.parametrize("friction", [0.0, 1e9])
def test_the_energy_over_a_well_returns_at_the_critical_angle(inertia, ratio, friction):
    phi, coupled = half_angle(ratio), inertia if friction else 0.0
    share = incline.kept_speed(math.degrees(phi), coupled)

    def returned(tilt):
        down, up = 1 - math.cos(phi + tilt), 1 - math.cos(phi - tilt)
        return share**2 * down - up

    root = math.degrees(brentq(returned, 0.0, phi, xtol=1e-15))
    found = incline.critical_angle_without_loss(math.degrees(phi), coupled)
    assert found == pytest.approx(root, abs=1e-12)


# ---- the shock, by the reference with a contact whose dashpots outweigh its springs

ROW = tuple(Body(radius=1.0, mass=1.0, position=(x, 0, 0), motion="frozen") for x in (0.0, 2.0))


def shock_of_the_reference(friction, inertia, ratio, zeta=100.0, stiffness=1e6):
    """Return speeds of centre and rim after the shock, of a grain that rolled at 1 m/s."""
    phi, count = half_angle(ratio), int(1000 * zeta)
    step = 2 * math.pi / math.sqrt(stiffness) / count
    law = Law.linear(stiffness, zeta, clipped=True)
    if friction:
        share = inertia / (1 + inertia)
        law = law.replace(tangential="linear_history", tangential_damping=share, friction=friction)
    before, after = (np.array([math.cos(phi), 0.0, sign * math.sin(phi)]) for sign in (-1.0, 1.0))
    place = (1.0 + ratio) * np.array([math.sin(phi), 0.0, math.cos(phi)]) - 0.5 * step * before
    grain = Body(radius=ratio, mass=1.0, inertia=inertia * ratio**2, position=tuple(place),
                 velocity=tuple(before), angular_velocity=(0.0, 1.0 / ratio, 0.0))  # fmt: skip
    scene = Scene(bodies=(grain, *ROW), law=law, step=step, steps=count, every=count)
    motion = reference.run(scene)
    return motion.velocity[-1, 0] @ after, motion.angular_velocity[-1, 0, 1] * ratio


@SYSTEMS
@pytest.mark.parametrize("share", [0.0, 0.5, 0.95, 1.05, 10.0])  # of the friction that sticks
def test_the_shock_is_that_of_the_reference(inertia, ratio, share):
    half = incline.well_half_angle(ratio)
    friction = share * incline.sticking_friction(half, inertia)
    grain = Grain(friction, inertia)
    expected = incline.after_shock(State(0.0, 1.0, 1.0), grain, half_angle(ratio))
    assert shock_of_the_reference(friction, inertia, ratio) == pytest.approx(expected, abs=2e-5)
    assert (expected[0] == expected[1]) is (share > 1)
    if share in (0.0, 10.0):
        kept = incline.kept_speed(half, inertia if share else 0.0)
        assert expected[0] == pytest.approx(kept, rel=1e-14)


# ---- values, limits and bounds


@settings(max_examples=15)
@given(HALF_ANGLES, INERTIAS)
def test_from_the_bound_on_the_grain_rolls_and_the_closed_form_holds(half, inertia):
    bound = incline.rolling_friction(half, inertia)
    assert bound > incline.sticking_friction(half, inertia)
    closed = incline.critical_angle_without_loss(half, inertia)
    above, below = (
        integrated_critical_angle(half, Grain(x * bound, inertia)) for x in (1.001, 0.9)
    )
    assert above == pytest.approx(closed, rel=1e-6)
    assert below > closed * (1 + 1e-6)


@settings(max_examples=6)
@given(HALF_ANGLES, INERTIAS)
def test_without_friction_or_inertia_the_frictionless_angle(half, inertia):
    frictionless = incline.critical_angle_without_loss(half, 0.0)
    slight = integrated_critical_angle(half, Grain(1e-8, inertia))
    assert slight == pytest.approx(frictionless, rel=1e-4)
    for friction in (3e-16, 1e-20, 1e-300):  # below round-off it would slide and roll for ever
        least = incline.rigid_angle(min(half, 30.0), Grain.of(friction, "disc"))
        assert least == incline.rigid_angle(min(half, 30.0), Grain.of(0.0, "disc"))
    assert incline.critical_angle_without_loss(half, 1e-12) == pytest.approx(frictionless, rel=1e-9)


def keeps_rolling(grain, tilt_deg, wells=200):
    tilt, state = math.radians(tilt_deg), State(math.radians(tilt_deg) - EQUAL, 0.5, 0.35)
    for _ in range(wells):
        before = incline.over_arc(state, EQUAL + tilt, grain)
        if before.angle < EQUAL + tilt:
            return False
        state = State(tilt - EQUAL, *incline.after_shock(before, grain, EQUAL))
    return True


@pytest.mark.parametrize(("friction", "lower"), [(0.005, 0.0176), (0.2, 0.0)])
def test_steady_motion_ends_at_that_angle_or_with_slight_friction_just_below(friction, lower):
    grain = Grain(friction, SPHERE)
    angle = integrated_critical_angle(30.0, grain) - lower
    assert keeps_rolling(grain, angle + 5e-4)
    assert not keeps_rolling(grain, angle - 5e-4)


@pytest.mark.parametrize("inertia", [SPHERE, DISC])
def test_a_grain_as_large_as_the_row_stays_on_it_at_any_friction(inertia):
    frictions = (0.0, 1e-6, 1e-3, 0.01, 0.05, 0.2, 0.5, 1.0, 10.0, 1e9)
    assert max(incline.smallest_size_ratio(Grain(mu, inertia)) for mu in frictions) < 0.83


@pytest.mark.parametrize(("friction", "ratio"), [(0.0, 0.81797), (0.1, 0.71491), (1.0, 0.61889)])
def test_the_smallest_grain_takes_off_at_its_critical_angle(friction, ratio):
    grain = Grain(friction, SPHERE)
    half = incline.largest_half_angle(grain)
    assert incline.smallest_size_ratio(grain) == pytest.approx(ratio, abs=5e-6)
    if friction:
        integrated_critical_angle(half - 1e-3, grain)
        with pytest.raises(incline.LeavesRow):
            integrated_critical_angle(half + 1e-3, grain)
        return
    steepest = half + incline.critical_angle_without_loss(half, 0.0)
    assert math.cos(math.radians(steepest)) == pytest.approx(2.0 / 3.0)


@pytest.mark.parametrize("half", [30.0, 9.6])
def test_a_grain_that_slides_leaves_the_row_at_less_tilt_than_one_that_rolls(half):
    bound, kept = incline.integrated_no_flight_bound, incline.kept_speed
    slides, rolls = (bound(half, Grain(mu, SPHERE)) for mu in (0.1, 99))
    frictionless, rolling = (
        incline.no_flight_bound(kept(half, beta) ** 2, half, beta) for beta in (0.0, SPHERE)
    )
    assert rolls == pytest.approx(rolling, abs=5e-3)
    assert 0.9 * frictionless < slides < rolls
    assert bound(half, Grain(1e-5, SPHERE)) is None
