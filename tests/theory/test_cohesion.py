"""Adhesion: what stands out on the curves of the force, and the energy that parting takes."""

import math

import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar

from harness.model.scene import sphere
from harness.theory import contact
from tests.theory import closed_forms

GAMMA, MODULUS, R = 0.05, 5e7, 1e-4
MASS = sphere(R, 2500.0).mass
C = math.sqrt(math.pi * GAMMA / MODULUS)


def overlap(a):
    return a * a / R - 2.0 * C * math.sqrt(a)


def force(a):
    return MODULUS * (4.0 * a**3 / (3.0 * R) - 4.0 * C * a**1.5)


def spread(a):
    """Return d(overlap)/da, which is 0 at the fold."""
    return 2.0 * a / R - C / math.sqrt(a)


def impact(speed, end):
    """Return the speed after an impact of jkr, None where it sticks.

    In a time s with dt = d(overlap)/da ds, so that nothing is infinite at the fold.
    """
    last = contact.jkr_contact_radius(end, GAMMA, MODULUS, R)
    first = contact.jkr_contact_radius("contact forms", GAMMA, MODULUS, R)

    def rates(_, y):
        a, v = y
        return [v, -force(a) / MASS * spread(a)]

    def parts(_, y):
        return y[0] - last

    def returns(_, y):
        return y[1]

    parts.terminal, parts.direction = True, -1.0
    returns.terminal, returns.direction = True, 1.0
    scale = first / speed
    found = solve_ivp(
        rates, (0.0, 1e3 * scale), [first, speed], "DOP853", rtol=1e-12, atol=1e-30,
        events=[parts, returns], first_step=1e-6 * scale,
    )  # fmt: skip
    return -found.y[1, -1] if found.t_events[0].size else None


def test_states_that_stand_out_are_roots_and_extrema_of_the_curves():
    at = {state: contact.jkr_contact_radius(state, GAMMA, MODULUS, R) for state in contact.SIZES}
    far = at["without load"] * 2.0
    rest = brentq(force, at["largest tension"], far, rtol=1e-14)
    forms = brentq(overlap, at["largest tension"], far, rtol=1e-14)
    tension = minimize_scalar(force, bounds=(0.0, far), options={"xatol": 1e-16}, method="bounded")
    fold = minimize_scalar(overlap, bounds=(0.0, far), options={"xatol": 1e-16}, method="bounded")
    assert at["without load"] == pytest.approx(rest, rel=1e-12)
    assert at["contact forms"] == pytest.approx(forms, rel=1e-12)
    assert at["largest tension"] == pytest.approx(tension.x, rel=1e-5)
    assert at["fold"] == pytest.approx(fold.x, rel=1e-5)
    assert tension.fun == pytest.approx(-contact.jkr_pull_off(GAMMA, R), rel=1e-10)
    for state, a in at.items():
        size = at["fold"] ** 2 / R
        assert contact.jkr_overlap(state, GAMMA, MODULUS, R) == pytest.approx(
            overlap(a), abs=1e-12 * size
        )
        assert closed_forms.jkr_force(state, GAMMA, R) == pytest.approx(force(a), abs=1e-15)


@pytest.mark.parametrize("end", ["largest tension", "fold"])
def test_what_parting_takes_by_quadrature(end):
    low = contact.jkr_contact_radius(end, GAMMA, MODULUS, R)
    high = contact.jkr_contact_radius("contact forms", GAMMA, MODULUS, R)
    work, _ = quad(lambda a: force(a) * (2.0 * a / R - C / math.sqrt(a)), low, high, epsrel=1e-12)
    assert closed_forms.jkr_loss(end, GAMMA, MODULUS, R) == pytest.approx(-work, rel=1e-9)


@pytest.mark.parametrize("end", ["largest tension", "fold"])
def test_an_impact_loses_it_or_sticks(end):
    loss = closed_forms.jkr_loss(end, GAMMA, MODULUS, R)
    sticks = math.sqrt(2.0 * loss / MASS)
    left = 0.5 * MASS * impact(1.5 * sticks, end) ** 2
    assert left == pytest.approx(1.25 * loss, rel=1e-8)
    assert impact(0.99 * sticks, end) is None


def test_dmt_gives_back_what_it_took():
    pull = contact.dmt_pull_off(GAMMA, R)

    def parts(_, y):
        return y[0]

    parts.terminal, parts.direction = True, -1.0
    found = solve_ivp(
        lambda _, y: [y[1], (pull - 4 / 3 * MODULUS * math.sqrt(R * max(y[0], 0.0) ** 3)) / MASS],
        (0.0, 1.0), [0.0, 0.01], "DOP853", rtol=1e-12, atol=1e-22, events=parts, first_step=1e-9,
    )  # fmt: skip
    assert -found.y[1, -1] == pytest.approx(0.01, rel=1e-9)


STRAIN = 2.0 * MODULUS


def test_mdr_on_a_flat_is_jkr_for_a_small_contact():
    # sphere and flat share the energy 2 gamma of JKR; R* = R, E* = E' of a rigid flat
    tension, last = contact.mdr_pull_off(2.0 * GAMMA, STRAIN, R)
    a = contact.jkr_contact_radius("largest tension", GAMMA, STRAIN, R)
    assert tension == pytest.approx(contact.jkr_pull_off(GAMMA, R), rel=(a / R) ** 2)
    assert last == pytest.approx(contact.jkr_overlap("fold", GAMMA, STRAIN, R), rel=(a / R) ** 2)
    small = 1e-3 * R
    c = math.sqrt(math.pi * GAMMA / STRAIN)
    jkr = STRAIN * (4.0 * small**3 / (3.0 * R) - 4.0 * c * small**1.5)
    force, depth = contact.mdr_force_and_depth(2.0 * GAMMA, STRAIN, R, small)
    assert force == pytest.approx(jkr, rel=1e-6)
    assert depth == pytest.approx(small**2 / R - 2.0 * c * math.sqrt(small), rel=1e-6)


def test_mdr_s_largest_tension_and_last_depth_are_extremes_of_its_curve():
    tension, last = contact.mdr_pull_off(GAMMA, STRAIN, R)

    def least(part):
        return minimize_scalar(
            lambda a: contact.mdr_force_and_depth(GAMMA, STRAIN, R, a)[part],
            bounds=(1e-4 * R, 0.5 * R), method="bounded", options={"xatol": 1e-12 * R},
        ).fun  # fmt: skip

    assert tension == pytest.approx(-least(0), rel=1e-10)
    assert last == pytest.approx(least(1), rel=1e-10)
