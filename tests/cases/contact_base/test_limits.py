"""Limits of a small step, and what is read off samples, against functions that are known."""

import math

import numpy as np
import pytest

from harness.cases.contact.limits import STEPS, powers, refine
from harness.cases.contact.motion import crossing, peak, value_at
from harness.cases.prescribed_motion import CHORDS
from harness.cases.registry import get_case
from harness.comparison.verdicts import Kind, Tolerance, Verdict, decided, is_undecided, judge
from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules

LADDER = STEPS["default"]
SPRING = {"tangential": "linear_history"}
H = 1.0 / np.array(LADDER)


@pytest.mark.parametrize(
    ("law", "first"),
    [
        (ContactLaw(), 2.0),
        (ContactLaw(damping="velocity", damping_coefficient=1.0), 1.0),
        (ContactLaw(normal="hertz", damping="viscoelastic", damping_coefficient=1.0), 1.0),
        (ContactLaw(normal="hertz", damping="coeff_restitution", restitution=0.5), 1.0),
        (ContactLaw(normal="jkr"), 1.0),
        (ContactLaw(normal="hertz", tangential="mindlin_rescale/force"), 1.0),
        (ContactLaw(normal="mdr", damping="mdr", damping_coefficient=0.2), 1.0),
        (ContactLaw(normal="mdr", yield_stress=1e6), 1.0),
        (ContactLaw(normal="mdr", bulk_response=True), 1.0),
    ],
)
def test_a_series_in_the_powers_of_the_law_has_its_limit_to_round_off(law, first):
    y = 0.7 + sum((0.3 + 0.2 * i) * H**p for i, p in enumerate(powers(law)))
    limit = refine(powers(law), LADDER, [{"x": v} for v in y], kinked=False)["x"]
    assert limit.value == pytest.approx(0.7, abs=1e-11)
    assert limit.order == pytest.approx(first, abs=0.3)


def test_a_spring_held_as_a_force_has_the_error_of_a_sum_over_the_ends_of_steps():
    # a sphere that moves down and along at one rate: the force is the integral of overlap^(1/2)
    sums = [sum(math.sqrt(i / n) for i in range(1, n + 1)) / n for n in LADDER]
    law = ContactLaw(normal="hertz", tangential="mindlin/force")
    # Euler and Maclaurin: h/2, zeta(-1/2) h^(3/2) from the beginning, h^2/24
    limit = refine(powers(law), LADDER, [{"x": v} for v in sums], kinked=False)["x"]
    assert limit.value == pytest.approx(2.0 / 3.0, abs=1e-9)
    assert powers(ContactLaw(normal="hertz", tangential="mindlin"))[0] == 2.0


def test_the_jitter_of_a_kink_stays_within_the_uncertainty():
    phase = np.array([0.3, -0.9, 0.8, -0.2, 0.6])
    y = 0.7 + 0.5 * H + 3.0 * phase * H**2
    limit = refine(powers(ContactLaw()), LADDER, [{"x": v} for v in y], kinked=True)["x"]
    assert abs(limit.value - 0.7) < 1e-5
    assert abs(limit.value - 0.7) <= limit.uncertainty
    assert limit.order_interval[0] <= limit.order <= limit.order_interval[1]


T = np.linspace(0.0, 4.0, 101)


def test_zeros_values_and_peaks_lie_between_samples():
    x, v = np.sin(T), np.cos(T)
    assert crossing(T[1:], x[1:], v[1:]) == pytest.approx(np.pi, abs=1e-9)
    assert np.isnan(crossing(T[1:], x[1:], v[1:], 1))
    assert value_at(1.234, T, x, v) == pytest.approx(np.sin(1.234), abs=1e-8)
    assert peak(x) == pytest.approx(1.0, abs=1e-9)
    assert peak(np.array([1.0, 2.0])) == 2.0


@pytest.mark.parametrize("tangential", ["linear_history", "mindlin", "mindlin_rescale/force"])
def test_a_pair_that_turns_as_one_body_keeps_its_forces_with_levers_to_the_contact(tangential):
    case = get_case("prescribed-motion")
    (trial,) = (
        one
        for one in case.trials("default")
        if one.submodel == tangential and one.parameters.turned
    )
    parameters = trial.parameters.replace(steps_per_contact=100)
    to_contact = case.expected(parameters, Rules(velocity_lever="contact_point"))
    to_centre = case.expected(parameters, Rules())
    held, turned = (to_contact[name].value for name in ("shear_ratio", "turned_ratio"))
    # the path is made of chords: on each the overlap grows by their sagitta and shrinks again, of
    # which a spring that is rescaled, or cut back as it shrinks, may keep all
    reach = parameters.radius + parameters.second_radius
    sagitta = reach * (1.0 - math.cos(parameters.turned / CHORDS / 2.0))
    width = CHORDS * sagitta / parameters.overlap
    assert turned == pytest.approx(held, rel=width)
    # with the lever r the surfaces slip by the turn times the overlap, further along
    overlap, shear = parameters.overlap, parameters.shear
    strained = held * (1.0 - parameters.turned * overlap / shear)
    assert to_centre["turned_ratio"].value == pytest.approx(strained, rel=width)


def test_only_two_free_spheres_turn_as_one_body():
    with pytest.raises(RequestError, match=r"turned = 0\.1: needs two spheres"):
        get_case("prescribed-motion").parameters(turned=0.1)


@pytest.mark.parametrize(
    ("apart", "uncertainty", "verdict"),
    [
        (0.5, 0.5, Verdict.PASS),
        (0.5, 2.0, Verdict.NOT_TESTED),  # agrees, but nobody knows
        (1.5, 0.2, Verdict.FAIL),
        (1.5, 0.7, Verdict.NOT_TESTED),  # no more than it is uncertain by
        (math.nan, 0.1, Verdict.FAIL),
        (0.5, math.nan, Verdict.NOT_TESTED),
    ],
)
def test_a_verdict_needs_an_uncertainty_within_the_tolerance(apart, uncertainty, verdict):
    row = judge("x", Kind.CROSS_CODE, 1.0 + apart, 1.0, Tolerance("", 1.0, 0.0, ""),
                uncertainty=uncertainty)  # fmt: skip
    assert decided(row, "no more runs").verdict is verdict
    assert is_undecided(1.0 + apart, 1.0, uncertainty, 1.0) is (verdict is Verdict.NOT_TESTED)
    if verdict is Verdict.NOT_TESTED:
        assert "undecided: 0.5 apart" in decided(row, "no more runs").note or apart != 0.5
        assert "no more runs" in decided(row, "no more runs").note


SMALL, LARGE = 1e-3, 10.0
"""[m/s] of a jitter at that step, of 1 m/s."""
