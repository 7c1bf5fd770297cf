"""Oblique impacts: the closed forms against the integration of the laws."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from harness.theory import contact
from tests.theory import closed_forms

NU, FRICTION = 0.3, 0.2
RATIO = 2.0 * (1.0 - NU) / (2.0 - NU)
# a sphere of m = v = 1 on a wall: the power of its elastic force F = d^p, and k_t / (dF/dd)
INCREMENTS, SPRINGS = (1.5, RATIO), (1.0, 2.0 / 7.0)


def press(law, d):
    """Return the normal force and its slope."""
    power, d = law[0], max(d, 0.0)
    return d**power, power * d ** (power - 1.0) if d or power == 1.0 else 0.0


def normal_motion(law, limit=None):
    """Return times and states (d, d', tangential impulse over mu) of an elastic impact."""

    def leaves(_, y):
        return y[0]

    leaves.terminal, leaves.direction = True, -1.0
    return solve_ivp(
        lambda _, y: [y[1], -press(law, y[0])[0], press(law, y[0])[0]], (0.0, limit or 10.0),
        [0.0, 1.0, 0.0], "DOP853", rtol=1e-12, atol=1e-15, events=leaves, first_step=1e-9,
        max_step=min(0.01, (limit or 10.0) / 1000.0),
    )  # fmt: skip


def slides_at_once(law, ratio, *, total=False):
    """Return whether the force of a spring that sticks passes Coulomb's limit from touch on.

    ``total``: k_t acts on the displacement, else its force grows by k_t dq.
    """
    found = normal_motion(law, 1e-3)
    t, d = found.t, found.y[0]
    slopes = law[1] * np.array([press(law, x)[1] for x in d])
    held = slopes * ratio * t if total else np.trapezoid(slopes * ratio, t)
    return float(np.atleast_1d(held)[-1]) > FRICTION * press(law, d[-1])[0]


def slides_throughout(law, ratio):
    """Return whether a contact that slides from touch on never would stick: k_t u < mu F'."""
    _, rate, impulse = normal_motion(law).y
    u = ratio - 3.5 * FRICTION * impulse
    return slides_at_once(law, ratio) and bool(np.all(law[1] * u > FRICTION * rate))


def stuck(k, damping, x_t, *, clipped):
    """Return the velocity at the contact after over before, where friction holds all.

    k_t = k and eta_t = x_t times the normal dashpot 2 ``damping``, of a linear contact of m = 1.
    Where the normal force passes zero its limit does, and cuts the spring back to nothing.
    """

    def rates(_, y):
        return [
            y[1], -y[0] - 2.0 * damping * y[1],
            y[3], -3.5 * (k * y[2] + 2.0 * x_t * damping * y[3]),
        ]  # fmt: skip

    def vanishes(t, y):
        return y[0] + 2.0 * damping * y[1] if t else 1.0

    def leaves(t, y):
        return y[0] if t else 1.0

    y, ends = [0.0, 1.0, 0.0, 1.0], (vanishes,) if clipped else (vanishes, leaves)
    for end in ends:
        end.terminal, end.direction = True, -1.0
        y = solve_ivp(
            rates, (0.0, 20.0), y, "DOP853", rtol=1e-12, atol=1e-14, events=end, first_step=1e-9
        ).y[:, -1]
        y[2] = 0.0
    return y[3]


def test_the_impulse_of_sliding_is_that_of_momentum_balance():
    lost = FRICTION * normal_motion(SPRINGS).y[2, -1]
    assert closed_forms.sliding_impulse(FRICTION, 1.0, 1.0) == pytest.approx(lost, rel=1e-11)


def test_the_angle_of_kharaz():
    """Chung and Ooi (2011), test 4: sliding throughout above 32.52 degrees."""
    angle = math.degrees(math.atan(closed_forms.slides_throughout(0.092, 0.98)))
    assert angle == pytest.approx(32.52, abs=0.005)


@pytest.mark.parametrize(("law", "ratio"), [(INCREMENTS, RATIO), (SPRINGS, 2.0 / 7.0)])
def test_where_an_elastic_contact_sticks_at_first_and_where_it_slides_to_its_end(law, ratio):
    first = closed_forms.sticks_at_first(0.2, ratio)
    assert slides_at_once(law, 1.001 * first)
    assert not slides_at_once(law, 0.999 * first)
    last = closed_forms.slides_throughout_elastic(0.2, ratio)
    assert slides_throughout(law, 1.001 * last)
    assert not slides_throughout(law, 0.999 * last)


def test_mindlin_on_the_total_displacement_sticks_up_to_two_thirds_of_that():
    first = 2.0 / 3.0 * closed_forms.sticks_at_first(0.2, RATIO)
    assert slides_at_once(INCREMENTS, 1.001 * first, total=True)
    assert not slides_at_once(INCREMENTS, 0.999 * first, total=True)


@pytest.mark.parametrize("ratio", [1e-3, 2.0 / 7.0, 0.8])
@pytest.mark.parametrize("restitution", [1.0, 0.6])
@pytest.mark.parametrize("clipped", [False, True])
def test_the_restitution_of_sticking_springs(ratio, restitution, clipped):
    zeta = contact.damping_ratio(restitution) if restitution < 1.0 else 0.0
    expected = closed_forms.sticking_restitution(ratio, zeta, clipped=clipped)
    assert -stuck(ratio, zeta, 0.0, clipped=clipped) == pytest.approx(expected, abs=1e-7)


def test_springs_in_the_ratio_2_to_7_give_all_of_it_back():
    assert closed_forms.sticking_restitution(2.0 / 7.0, 0.0, clipped=False) == pytest.approx(1.0)
    assert closed_forms.sticking_restitution(0.0, 0.5, clipped=False) == -1.0


@pytest.mark.parametrize(
    ("stiffness", "dashpot_"), [(4.0, 0.0), (4.0, 1.0), (1.0, 2.0), (0.5, 3.0), (0.0, 0.7)]
)
def test_a_contact_that_sticks_is_an_oscillator(stiffness, dashpot_):
    def rates(_, y):
        return [y[1], -stiffness * y[0] - dashpot_ * y[1]]

    end = solve_ivp(rates, (0.0, 2.5), [0.0, 1.0], rtol=1e-11, atol=1e-13).y[1, -1]
    assert contact.held(stiffness, dashpot_, 2.5) == pytest.approx(end, abs=1e-9)


@pytest.mark.parametrize("ratio", [1e-3, 2.0 / 7.0, 0.8])
@pytest.mark.parametrize("zeta", [0.0, 0.2])
def test_what_a_sticking_spring_leaves_is_the_restitution_of_one_that_is_clipped(ratio, zeta):
    found = contact.held(3.5 * ratio, 0.0, contact.duration_clipped(zeta))
    assert -found == pytest.approx(closed_forms.sticking_restitution(ratio, zeta, clipped=True))


@pytest.mark.parametrize("x_t", [0.0, 0.5])
def test_the_law_leaves_as_much_where_friction_holds_it(x_t):
    zeta = contact.damping_ratio(0.6)
    lasts = contact.duration_clipped(zeta)  # with omega = 1
    expected = contact.held(3.5 * 2.0 / 7.0, 3.5 * x_t * 2.0 * zeta, lasts)
    assert stuck(2.0 / 7.0, zeta, x_t, clipped=True) == pytest.approx(expected, abs=1e-6)
