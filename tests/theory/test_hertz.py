"""Hertz's impact: published values, quadrature, and limits with a dashpot."""

import math

import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import beta

from harness.model.scene import sphere
from harness.theory import contact
from tests.theory.closed_forms import impact


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


def test_overlap_and_time_by_energy_and_quadrature():
    mass, k, speed = 2.0, 3e9, 0.7
    overlap = brentq(lambda x: 0.4 * k * x**2.5 - 0.5 * mass * speed**2, 1e-9, 1.0, rtol=1e-14)
    assert contact.largest_hertz_overlap(mass, k, speed) == pytest.approx(overlap, rel=1e-12)
    # x = 1 - y^2 takes the root from the end of 2 dx / sqrt(1 - x^(5/2))
    passed, _ = quad(lambda y: 4.0 * y / math.sqrt(1.0 - (1.0 - y * y) ** 2.5), 0.0, 1.0)
    assert contact.contact_time(mass, k, speed) * speed / overlap == pytest.approx(passed)
    assert passed == pytest.approx(2.9432, abs=1e-4)


@pytest.mark.parametrize("clipped", [True, False])
def test_weak_damping_loses_what_it_takes_of_the_undamped_motion(clipped):
    undamped = impact(0.0, clipped=clipped)
    assert undamped.restitution == pytest.approx(1.0, abs=1e-9)
    assert undamped.duration == pytest.approx(0.8 * beta(0.4, 0.5), rel=1e-7)
    loss = beta(0.6, 1.5)
    errors = [
        abs((1.0 - impact(a, clipped=clipped).restitution) / a / loss - 1.0) for a in (1e-2, 1e-3)
    ]
    assert errors[1] / errors[0] == pytest.approx(0.1, rel=0.05)
    # 3/5 of its square: Ramirez and others, Phys. Rev. E 60, 4465 (1999), whose a grows as v^(1/5)
    thirds = [
        impact(a, clipped=False).restitution - 1.0 + loss * a - 0.6 * (loss * a) ** 2
        for a in (0.04, 0.02)
    ]
    assert thirds[0] / thirds[1] == pytest.approx(8.0, rel=0.25)


def test_strong_damping_follows_its_power_laws():
    ratios = [impact(a, clipped=True).restitution * a ** (5 / 3) for a in (100.0, 300.0, 900.0)]
    assert ratios[-1] == pytest.approx(1.2 ** (2 / 3), rel=1e-3)
    assert abs(ratios[1] - ratios[2]) < abs(ratios[0] - ratios[1])
    first, second = (impact(a, clipped=False).restitution for a in (50.0, 100.0))
    assert first / second == pytest.approx(2.0**5, rel=2e-3)
