"""Closed forms of contacts against integrated equations, roots and extrema of curves.

The limit of small steps of the reference is the second route of all forms that a case has:
``tests/cases/contacts/test_closed_forms.py``.
"""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar
from scipy.special import j0, j1

from harness.model.law import damping_ratio
from harness.model.scene import sphere
from harness.theory import contact
from harness.theory.contact import rebound as rebound_under_gravity

# ---- the linear dashpot, also of a falling sphere


def collide(zeta, ends):
    """Integrate the contact until ``ends(x, v)`` falls to zero; return the duration and -v."""

    def motion(_, state):
        return [state[1], -state[0] - 2 * zeta * state[1]]

    def event(_, state):
        return ends(*state)

    event.terminal, event.direction = True, -1.0
    # a step past x = v = 0 so that the events do not fire at the first touch
    early = 1e-9
    start = [early, 1.0 - 2 * zeta * early]
    run = solve_ivp(motion, (early, 500.0), start, "DOP853", events=event, rtol=1e-11, atol=1e-13)
    return run.t[-1], -run.y[1, -1]


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.3, 0.6, 0.85, 0.9999, 1.0, 1.0001, 1.5, 5.0])
def test_restitution_and_duration_are_those_of_the_integrated_contact(zeta):
    """Clipped, it ends where the force is gone, else where the overlap is."""
    found = contact.duration_clipped(zeta), contact.restitution_clipped(zeta)
    assert found == pytest.approx(collide(zeta, lambda x, v: x + 2 * zeta * v), rel=1e-5)
    if zeta < 0.9:
        found = contact.duration_unclipped(zeta), contact.restitution_unclipped(zeta)
        assert found == pytest.approx(collide(zeta, lambda x, _: x), rel=1e-5)


@given(st.floats(0.0, 0.999), st.floats(0.0, 3.0))
def test_clipping_never_lowers_the_restitution(zeta, other):
    assert contact.restitution_clipped(zeta) >= contact.restitution_unclipped(zeta)
    low, high = sorted((zeta, other))
    assert contact.restitution_clipped(high) <= contact.restitution_clipped(low) * (1 + 1e-9)


@given(st.floats(1e-12, 1.0))
def test_damping_ratio_inverts_the_unclipped_restitution(restitution):
    again = contact.restitution_unclipped(damping_ratio(restitution))
    assert again == pytest.approx(restitution, rel=1e-9)
    assert (damping_ratio(0.0), damping_ratio(1.0)) == (1.0, 0.0)
    assert contact.restitution_unclipped(1.0) == contact.restitution_unclipped(5.0) == 0.0


@pytest.mark.parametrize("zeta", [0.0, 0.2, 0.7, 1.1, 2.0, 10.0])
def test_the_largest_overlap_is_that_of_the_integrated_motion(zeta):
    root = cmath.sqrt(1.0 - zeta * zeta)
    t = np.linspace(0.0, contact.duration_clipped(zeta), 200_001)
    x = np.exp(-zeta * t) * (np.sin(root * t) / root).real
    assert contact.largest_overlap(zeta) == pytest.approx(x.max(), rel=1e-9)


# ---- a falling sphere

OMEGA = math.sqrt(1e5 / 0.01)
DAMPING = damping_ratio(0.8)


@pytest.mark.parametrize("speed", [1.0, 0.02])
def test_rebound_is_that_of_the_integrated_contact(speed):
    def leaves(_, y):
        return y[0]

    leaves.terminal, leaves.direction = True, -1.0
    path = solve_ivp(
        lambda _, y: [y[1], G - 2.0 * DAMPING * OMEGA * y[1] - OMEGA**2 * y[0]],
        (0.0, 1.0), [0.0, speed], "DOP853", rtol=1e-13, atol=1e-18, first_step=1e-9,
        events=[leaves, lambda _, y: y[1]],
    )  # fmt: skip
    rebound = rebound_under_gravity(OMEGA, DAMPING, G, speed)
    expected = path.t[-1], -path.y[1, -1], path.y_events[1][0, 0]
    assert tuple(rebound) == pytest.approx(expected, rel=1e-10)


def test_without_gravity_it_is_the_dashpot_alone_and_a_slow_sphere_stays():
    rebound = rebound_under_gravity(OMEGA, DAMPING, 0.0, 2.0)
    expected = 0.8 * 2.0, contact.duration_unclipped(DAMPING) / OMEGA
    assert (rebound.speed, rebound.duration) == pytest.approx(expected, rel=1e-12)
    assert rebound_under_gravity(OMEGA, DAMPING, G, 1e-5) is None


# ---- elastic spheres and adhesion


@pytest.mark.parametrize(
    ("material", "sizes", "speed", "expected"),
    [
        # Chung and Ooi (2011), tests 1 (two spheres, at 10 m/s each) and 2 (a rigid wall)
        ((48e9, 0.2, 2800.0), (0.01, 0.5, 0.5), 20.0, (10697.0, 274.1e-6, 40.34e-6)),
        ((140e9, 0.3, 2699.0), (0.1, 1.0, 1.0), 0.2, (11370.0, 49.72e-6, 731.6e-6)),
    ],
)
def test_benchmarks_of_chung_and_ooi(material, sizes, speed, expected):
    young, poisson, density = material
    radius, radius_share, mass_share = sizes
    modulus = young / (2.0 * (1.0 - poisson**2))
    mass = mass_share * sphere(radius, density).mass
    k = contact.stiffness(modulus, radius_share * radius)
    forms = contact.largest_force, contact.largest_hertz_overlap, contact.contact_time
    assert [form(mass, k, speed) for form in forms] == pytest.approx(expected, rel=5e-4)


# ---- adhesion

GAMMA, MODULUS, R = 0.05, 5e7, 1e-4


def overlap(a, modulus=MODULUS):
    return a * a / R - 2.0 * math.sqrt(math.pi * GAMMA / modulus * a)


def force(a, modulus=MODULUS):
    return modulus * 4.0 * a**3 / (3.0 * R) - 4.0 * math.sqrt(math.pi * GAMMA * modulus * a**3)


def least(curve, low, high):
    return minimize_scalar(curve, bounds=(low, high), options={"xatol": 1e-16}, method="bounded")


def test_states_that_stand_out_are_roots_and_extrema_of_the_curves():
    at = {state: contact.jkr_contact_radius(state, GAMMA, MODULUS, R) for state in contact.SIZES}
    far = at["without load"] * 2.0
    for state, curve in (("without load", force), ("contact forms", overlap)):
        root = brentq(curve, at["largest tension"], far, rtol=1e-14)
        assert at[state] == pytest.approx(root, rel=1e-12)
    for state, curve in (("largest tension", force), ("fold", overlap)):
        assert at[state] == pytest.approx(least(curve, 0.0, far).x, rel=1e-5)
    tension = least(force, 0.0, far).fun
    assert tension == pytest.approx(-contact.jkr_pull_off(GAMMA, R), rel=1e-10)
    for state, a in at.items():
        expected = pytest.approx(overlap(a), abs=1e-12 * at["fold"] ** 2 / R)
        assert contact.jkr_overlap(state, GAMMA, MODULUS, R) == expected


STRAIN = 2.0 * MODULUS


def test_mdr_on_a_flat_is_jkr_for_a_small_contact():
    # sphere and flat share the energy 2 gamma of JKR; R* = R, E* = E' of a rigid flat
    tension, last = contact.mdr_pull_off(2.0 * GAMMA, STRAIN, R)
    a = contact.jkr_contact_radius("largest tension", GAMMA, STRAIN, R)
    assert tension == pytest.approx(contact.jkr_pull_off(GAMMA, R), rel=(a / R) ** 2)
    assert last == pytest.approx(contact.jkr_overlap("fold", GAMMA, STRAIN, R), rel=(a / R) ** 2)
    small = 1e-3 * R
    jkr = force(small, STRAIN), overlap(small, STRAIN)
    found = contact.mdr_force_and_depth(2.0 * GAMMA, STRAIN, R, small)
    assert found == pytest.approx(jkr, rel=1e-6)


def test_mdr_s_largest_tension_and_last_depth_are_extremes_of_its_curve():
    def extreme(part):
        return least(
            lambda a: contact.mdr_force_and_depth(GAMMA, STRAIN, R, a)[part],
            1e-4 * R,
            0.5 * R,
        ).fun

    expected = -extreme(0), extreme(1)
    assert contact.mdr_pull_off(GAMMA, STRAIN, R) == pytest.approx(expected, rel=1e-10)


# ---- oblique impacts: sticking, partial slip, and sliding throughout


POISSON = 0.3
CHI = 1.75 * contact.stiffness_ratio(POISSON)


def test_beyond_four_chi_less_one_all_slides():
    psi = np.array([4.0 * CHI - 0.999, 6.0, 9.0])
    assert contact.partial_slip_rebound(psi, POISSON) == pytest.approx(psi - 4.0 * CHI, abs=2e-3)
    less = 4.0 * CHI - 1.5
    assert contact.partial_slip_rebound(less, POISSON) > less - 4.0 * CHI + 1e-3


def test_springs_under_a_constant_load_are_cattaneo_and_mindlin():
    # T / (mu F) = 1 - (1 - s)^(3/2), s the displacement over the one at which all slides; and
    # Mindlin and Deresiewicz on the way back: twice the same at half the way
    overlap, n = 1.0, 20_000
    x = (np.arange(n) + 0.5) / n
    limit, width = overlap - x**2, 2.0 / n
    load = width * limit.sum()
    assert load == pytest.approx(4.0 / 3.0, rel=1e-6)
    for s in (0.1, 0.5, 0.9):
        there = contact.spring_strains(np.full(n, s), limit)
        assert width * there.sum() / load == pytest.approx(1.0 - (1.0 - s) ** 1.5, rel=1e-4)
        back = contact.spring_strains(there - s, limit)
        force = (1.0 - (1.0 - s) ** 1.5) - 2.0 * (1.0 - (1.0 - s / 2.0) ** 1.5)
        assert width * back.sum() / load == pytest.approx(force, abs=1e-6)


def test_the_rebound_is_odd_and_settles_as_steps_and_springs_are_refined():
    psi = np.array([0.3, 1.0, 2.0, 3.0, 4.0])
    coarse, fine, finest = (
        contact.partial_slip_rebound(psi, POISSON, springs, steps)
        for springs, steps in ((100, 1000), (200, 2000), (400, 4000))
    )
    assert contact.partial_slip_rebound(-psi, POISSON) == pytest.approx(-fine, abs=1e-12)
    assert np.abs(finest - fine).max() < 2e-3
    assert np.abs(finest - fine).max() < 0.7 * np.abs(fine - coarse).max()


def test_friction_takes_energy_and_the_contact_comes_back_the_other_way():
    psi = np.linspace(0.05, 4.0, 20)
    found = contact.partial_slip_rebound(psi, POISSON)
    assert (np.abs(found) < psi).all()
    assert (found[psi > 1.2] < 0.0).all()


# ---- friction, rolling and twisting whose limits are reached or left on the way


RADIUS, STIFFNESS, G = 0.01, 3e5, 9.81
MASS = sphere(RADIUS, 2500.0).mass
EXACT = {"rtol": 1e-12, "atol": 1e-18, "method": "DOP853"}


@pytest.mark.parametrize(("speed", "pull"), [(0.5, 0.0), (0.5, -1.0), (0.02, 1.5)])
def test_a_constant_torque_slows_a_sphere_that_rolls(speed, pull):
    load, end = MASS * G, 0.01
    limits = 0.3 * load, 0.05 * load

    def newton(_, y):
        force = STIFFNESS * y[0]
        return y[1] - y[2], pull - force / MASS, (force - limits[1]) / (0.4 * MASS)

    ran = solve_ivp(newton, (0.0, end), (0.0, speed, speed), **EXACT)
    state = contact.against_constant_torque(end, speed, pull, MASS, STIFFNESS, limits)
    assert state == pytest.approx(ran.y[1:, -1], rel=1e-9)
    # a stiff spring: it rolls, and the torque takes 5/7 mu_r g from 5/7 of the pull
    rigid = contact.against_constant_torque(end, speed, pull, MASS, 1e22, limits)
    assert rigid[0] == pytest.approx(speed + 5 / 7 * (pull - 0.05 * G) * end, rel=1e-9)
    assert rigid[1] == pytest.approx(rigid[0], rel=1e-7)


def test_a_constant_torque_without_a_motion_in_closed_form():
    load = MASS * G
    down = contact.against_constant_torque(1.0, 0.0, 1.0, MASS, 1e22, (load, 0.0))
    expected = contact.down_an_incline(math.asin(1.0 / G), 1.0, G)
    assert down == pytest.approx((expected.acceleration, expected.turning), rel=1e-8)
    for limits, time in (((0.01 * load, 0.05 * load), 0.01), ((load, 0.05 * load), 2.0)):
        assert contact.against_constant_torque(time, 0.5, 0.0, MASS, STIFFNESS, limits) is None


def test_a_sphere_on_an_incline_ends_where_the_springs_hold_it_or_rolls_at_a_constant_rate():
    springs = ((1e4, 30.0), (2e4, 30.0))
    (rests,) = contact.on_an_incline((1.0,), 0.2, 0.01, *springs, (1.0, 4.1e-3))
    assert rests == pytest.approx([0.002 / 1e4 + 0.002 / 2e4, 0.0, 0.002 / 2e4, 0.0], abs=1e-15)
    one, two = contact.on_an_incline((1.0, 2.0), 0.2, 0.01, *springs, (1.0, 1e-3))
    rate = 5.0 / 7.0 * (0.2 - 1e-3 / 0.01)
    assert (two - one)[[1, 3]] == pytest.approx([rate, rate], rel=1e-9)
    # it slides; it is held again after it rolled
    assert contact.on_an_incline((1.0,), 0.2, 0.01, *springs, (1e-3, 1e-3)) is None
    assert contact.on_an_incline((1.0,), 0.2, 0.01, *springs, (1.0, 2.1e-3)) is None


def twisted(until, spin, inertia, k, c, limit):
    """Integrate the spin: the contact sticks, slips at the limit of its torque, and sticks again.

    While it slips the spring is cut back so that k q + c w is the limit, until it would grow more
    slowly than that.
    """
    slowing = limit / inertia

    def held(_, y):
        return [y[1], -(k * y[0] + c * y[1]) / inertia]

    def reaches(_, y):
        return k * y[0] + c * y[1] - limit

    def slows(_, y):
        return y[1] - c * slowing / k

    reaches.terminal = slows.terminal = True
    slips = c * spin > limit
    t, y = 0.0, [(limit - c * spin) / k if slips else 0.0, spin]
    phases = (held, reaches), (lambda *_: [c * slowing / k, -slowing], slows), (held, None)
    for rates, event in phases[slips:]:
        if t < until and not (event is slows and y[1] <= c * slowing / k):
            run = solve_ivp(rates, (t, until), y, events=event, **EXACT)
            t, y = run.t[-1], run.y[:, -1]
    return y[1]


@pytest.mark.parametrize("dashpot", [0.0, 0.1, 0.6])  # over critical damping
@pytest.mark.parametrize("start", [0.5, 3.0, 30.0])  # over the amplitude at the limit
def test_a_twist_slips_stops_and_swings_back(start, dashpot):
    k, limit, inertia = 1.0, 1e-5, 0.4 * MASS
    c, largest = 2.0 * dashpot * math.sqrt(k * inertia), limit / math.sqrt(k * inertia)
    for time in np.array([1.0, 3.0, 10.0, 40.0]) * math.sqrt(inertia / k):
        found = contact.twisting_spin(time, start * largest, inertia, (k, c), limit)
        expected = twisted(time, start * largest, inertia, k, c, limit)
        assert found == pytest.approx(expected, abs=1e-9 * largest)


@pytest.mark.parametrize("angle", [0.0175, 0.07])
def test_rolling_resistance_holds_a_sphere_on_an_incline_or_slows_it_down(angle):
    """Its torque is a spring and a dashpot of the rim until it reaches the limit."""
    (k, c), (stiffness, dashpot), end = (STIFFNESS, 2.0), (1e5, 10.0), 2e-2
    load, pull = MASS * G * math.cos(angle), G * math.sin(angle)

    def torque(y):
        return stiffness * y[2] + dashpot * y[3]

    def rates(y, resistance):  # of the path, the speed, and the path and the speed of the rim
        friction = k * (y[0] - y[2]) + c * (y[1] - y[3])
        turning = (friction - resistance) / (0.4 * MASS)
        return [y[1], pull - friction / MASS, y[3], turning]

    def reaches(_, y):
        return torque(y) - 0.05 * load

    reaches.terminal = True
    held = solve_ivp(lambda _, y: rates(y, torque(y)), (0.0, end), np.zeros(4), events=reaches,
                     dense_output=True, **EXACT)  # fmt: skip
    rolls = solve_ivp(lambda _, y: rates(y, 0.05 * load), (held.t[-1], 2.0 * end), held.y[:, -1],
                      dense_output=True, **EXACT)  # fmt: skip
    limits, times = (0.3 * load, 0.05 * load), (0.5 * end, end)
    states = contact.on_an_incline(times, pull, MASS, (k, c), (stiffness, dashpot), limits)
    for time, state in zip(times, states, strict=True):
        found = (held if time <= held.t[-1] else rolls).sol(time)
        assert state == pytest.approx(found, rel=1e-8, abs=1e-16)


def test_a_sphere_that_turns_on_its_spot_is_slowed_down_by_the_limit_of_the_torque():
    inertia, limit = 0.4 * MASS * RADIUS**2, 1e-3 * MASS * G
    spins = [contact.twisting_spin(t, 50.0, inertia, (100.0, 0.0), limit) for t in (0.005, 0.01)]
    expected = 0.005 * contact.twisting_deceleration(1e-3, RADIUS, G)
    assert spins[0] - spins[1] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("decay", [0.0, 0.3, 5.0])
def test_a_contact_on_an_oscillating_wall_is_a_driven_oscillator(decay):
    frequency, acceleration, drive, end = 2.0, 0.7, 0.9, 13.0

    def rates(t, y):
        pull = -2.0 * decay * y[1] - frequency**2 * y[0]
        return [y[1], pull - acceleration * math.cos(drive * t)]

    path = solve_ivp(rates, (0.0, end), [0.0, 0.0], **EXACT)
    found = contact.driven(np.array([0.0, end]), frequency, decay, acceleration, drive)
    assert np.array(found) == pytest.approx(path.y[:, [0, -1]], abs=1e-9)


def test_a_circle_between_two_half_spaces_conducts_2_k_a():
    """Heat through a circle of one temperature: of the potential integral J0(sr) sin(sa)/s e^-sz.

    2/pi of it is 1 on the circle. Its flow is 2 pi a k 2/pi integral J1(sa) sin(sa)/s ds = 4 k a
    into a half-space: 2 k a for the difference that both share.
    """

    def damped(bessel, z):  # Weber's integral for a = 1, whose limit is that of a small z
        return quad(lambda s: bessel(s) * np.sin(s) / s * np.exp(-s * z), 0, 60 / z, limit=4000)[0]

    # it falls with the root of z at the rim, linearly within
    far, near = (4.0 * damped(j1, z) for z in (0.02, 0.01))
    assert near + (near - far) / (math.sqrt(2.0) - 1.0) == pytest.approx(4.0, rel=0.02)
    far, near = (2.0 / math.pi * damped(lambda s: j0(0.3 * s), z) for z in (0.02, 0.01))
    assert 2.0 * near - far == pytest.approx(1.0, rel=1e-3)
    assert contact.conductance("radius", 3.0, 2.0) == 0.5 * 4.0 * 3.0 * 2.0
    assert contact.conductance("area", 3.0, 2.0) == pytest.approx(3.0 * math.pi * 4.0)
