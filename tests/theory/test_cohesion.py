"""Adhesion: what stands out on the curves of the force, and the energy that parting takes."""

import math

import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene, sphere_mass
from harness.solvers.pair.integration import integrate
from harness.theory import contact
from tests.solvers.pair.scenes import FLOOR
from tests.theory import closed_forms

GAMMA, MODULUS, R = 0.05, 5e7, 1e-4
NU = 0.3
MASS = sphere_mass(R, 2500.0)
C = math.sqrt(math.pi * GAMMA / MODULUS)


def overlap(a):
    return a * a / R - 2.0 * C * math.sqrt(a)


def force(a):
    return MODULUS * (4.0 * a**3 / (3.0 * R) - 4.0 * C * a**1.5)


def law(normal):
    return ContactLaw(
        normal=normal,
        youngs_modulus=2.0 * (1.0 - NU**2) * MODULUS,
        poisson_ratio=NU,
        surface_energy=GAMMA,
    )


def impact(normal, speed, rules=None):
    ball = Body(R, MASS, (0.0, 0.0, R), (0.0, 0.0, -speed))
    return integrate(ContactScene((ball,), (FLOOR,), law(normal), 1e-6, 100, every=100), rules)


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


@pytest.mark.parametrize(
    ("rules", "end"),
    [(Rules(), "largest tension"), (Rules(pull_off="fold"), "fold")],
)
def test_an_impact_loses_it_or_sticks(rules, end):
    loss = closed_forms.jkr_loss(end, GAMMA, MODULUS, R)
    sticks = math.sqrt(2.0 * loss / MASS)
    path = impact("jkr", 1.5 * sticks, rules)
    left = 0.5 * MASS * path.velocities[-1, 0, 2] ** 2
    assert left == pytest.approx(1.25 * loss, rel=1e-8)
    ends = path.of_kind("ends")[0]
    assert ends.overlap == pytest.approx(contact.jkr_overlap(end, GAMMA, MODULUS, R), rel=1e-9)
    # at the fold the force falls with the root of what is left of the overlap
    assert ends.force == pytest.approx(closed_forms.jkr_force(end, GAMMA, R), rel=1e-5)
    assert not impact("jkr", 0.99 * sticks, rules).of_kind("ends")


def test_dmt_gives_back_what_it_took():
    path = impact("dmt", 0.01)
    assert path.velocities[-1, 0, 2] == pytest.approx(0.01, rel=1e-9)
    ends = path.of_kind("ends")[0]
    assert ends.force == pytest.approx(-contact.dmt_pull_off(GAMMA, R), rel=1e-9)


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
