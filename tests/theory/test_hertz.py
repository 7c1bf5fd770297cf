"""The impact with Hertz's spring and a dashpot: closed forms of its limits, and other routes."""

import math

import pytest
from scipy.special import gamma

from harness.errors import RequestError
from harness.theory.contact import impact
from tests.theory import closed_forms


@pytest.mark.parametrize("clipped", [True, False])
def test_without_damping_nothing_is_lost_and_the_duration_is_hertz_s(clipped):
    found = impact(0.0, clipped=clipped)
    assert found.restitution == pytest.approx(1.0, abs=1e-9)
    # Hertz's 2.94 overlap / speed, Landau and Lifshitz, Theory of Elasticity, section 9
    hertz = 0.8 * math.sqrt(math.pi) * gamma(0.4) / gamma(0.9)
    assert found.duration == pytest.approx(hertz, rel=1e-7)


@pytest.mark.parametrize("clipped", [True, False])
def test_weak_damping_loses_what_it_takes_of_the_undamped_motion(clipped):
    loss = closed_forms.first_order_loss()
    errors = [
        abs((1.0 - impact(a, clipped=clipped).restitution) / a / loss - 1.0)
        for a in (1e-2, 1e-3, 1e-4)
    ]
    assert errors[1] / errors[0] == pytest.approx(0.1, rel=0.05)  # first order in a
    assert errors[2] < 1e-4


def test_strong_damping_clipped_follows_its_power_law():
    errors = [
        abs(impact(a, clipped=True).restitution / closed_forms.strongly_damped(a) - 1.0)
        for a in (30.0, 100.0, 300.0, 900.0)
    ]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-3


def test_strong_damping_unclipped_falls_as_the_fifth_power():
    first, second = (impact(a, clipped=False).restitution for a in (50.0, 100.0))
    assert first / second == pytest.approx(2.0**5, rel=2e-3)


@pytest.mark.parametrize("a", [-1.0, math.nan, 1e4])
def test_a_damping_out_of_range_is_refused(a):
    with pytest.raises(RequestError, match="must be from 0 to 1000"):
        impact(a, clipped=True)
