"""Oblique impacts: the closed forms against the integration of the laws."""

import math

import pytest
from scipy.integrate import solve_ivp

from harness.parameters.law import ContactLaw
from harness.solvers.pair.integration import integrate
from harness.theory import contact
from tests.solvers.pair.scenes import RADIUS, impact
from tests.theory import closed_forms

NU = 0.3
RATIO = 2.0 * (1.0 - NU) / (2.0 - NU)
INCREMENTS = ContactLaw(
    normal="hertz", youngs_modulus=7e9, poisson_ratio=NU, tangential="mindlin/force", friction=0.2
)
SPRINGS = ContactLaw(normal_stiffness=1e6, tangential="linear_history", friction=0.2)


def slip(law, ratio):
    """Return what happens to the tangential spring of an impact at u/v: times and kinds."""
    path = integrate(impact(law, (ratio, 0.0, -1.0)))
    return [(event.time, event.kind) for event in path.events if event.slider == "tangential"]


def slides_at_once(law, ratio):
    return any(kind == "slides" and time < 1e-15 for time, kind in slip(law, ratio))


def slides_throughout(law, ratio):
    return slides_at_once(law, ratio) and len(slip(law, ratio)) == 1


def test_the_impulse_of_sliding_is_that_of_momentum_balance():
    path = integrate(impact(SPRINGS, (3.0, 0.0, -1.0)))
    lost = contact.sliding_impulse(0.2, 1.0, 1.0)
    assert path.velocities[-1, 0, 0] == pytest.approx(3.0 - lost, rel=1e-11)
    assert path.omegas[-1, 0, 1] * RADIUS == pytest.approx(2.5 * lost, rel=1e-11)


def test_the_angle_of_kharaz():
    """Chung and Ooi (2011), test 4: sliding throughout above 32.52 degrees."""
    angle = math.degrees(math.atan(contact.slides_throughout(0.092, 0.98)))
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
    law = INCREMENTS.replace(tangential="mindlin")
    first = 2.0 / 3.0 * closed_forms.sticks_at_first(0.2, RATIO)
    assert slides_at_once(law, 1.001 * first)
    assert not slides_at_once(law, 0.999 * first)


@pytest.mark.parametrize("ratio", [1e-3, 2.0 / 7.0, 0.8])
@pytest.mark.parametrize("restitution", [1.0, 0.6])
@pytest.mark.parametrize("clipped", [False, True])
def test_the_restitution_of_sticking_springs(ratio, restitution, clipped):
    law = SPRINGS.replace(
        tangential_stiffness=ratio * 1e6,
        friction=1e9,
        damping="coeff_restitution",
        restitution=restitution,
        clipped=clipped,
    )
    path = integrate(impact(law, (1.0, 0.0, -1.0)))
    end = path.velocities[-1, 0, 0] - RADIUS * path.omegas[-1, 0, 1]
    zeta = contact.damping_ratio(restitution) if restitution < 1.0 else 0.0
    expected = closed_forms.sticking_restitution(ratio, zeta, clipped=clipped)
    assert -end == pytest.approx(expected, abs=1e-7)


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
    law = SPRINGS.replace(
        friction=1e9,
        damping="coeff_restitution",
        restitution=0.6,
        clipped=True,
        tangential_damping=x_t,
    )
    path = integrate(impact(law, (1.0, 0.0, -1.0)))
    left = path.velocities[-1, 0, 0] - RADIUS * path.omegas[-1, 0, 1]
    zeta = contact.damping_ratio(0.6)
    k_t, k = law.tangential_stiffness, law.normal_stiffness
    lasts = contact.duration_clipped(zeta)  # with omega = 1
    expected = contact.held(3.5 * k_t / k, 3.5 * x_t * 2.0 * zeta, lasts)
    assert left == pytest.approx(expected, abs=1e-6)
