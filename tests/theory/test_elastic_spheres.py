"""Elastic spheres: Hertz's impact, adhesion as roots and extrema of the curves of the force."""

import math

import pytest
from scipy.optimize import brentq, minimize_scalar

from harness.model.scene import sphere
from harness.theory import contact


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
MASS = sphere(R, 2500.0).mass
C = math.sqrt(math.pi * GAMMA / MODULUS)


def overlap(a):
    return a * a / R - 2.0 * C * math.sqrt(a)


def force(a):
    return MODULUS * (4.0 * a**3 / (3.0 * R) - 4.0 * C * a**1.5)


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
