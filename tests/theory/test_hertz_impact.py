"""Hertz's impact in closed form, against published values, quadrature and integration."""

import math

import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from harness.model.scene import sphere
from harness.theory import contact
from tests.theory import closed_forms


@pytest.mark.parametrize(
    ("material", "sizes", "speed", "expected"),
    [
        # Chung and Ooi (2011), tests 1 (two spheres, at 10 m/s each) and 2 (a rigid wall)
        ((48e9, 0.2, 2800.0), (0.01, 0.5, 0.5), 20.0, (10697.0, 274.1e-6, 40.34e-6)),
        ((140e9, 0.3, 2699.0), (0.1, 1.0, 1.0), 0.2, (11370.0, 49.72e-6, 731.6e-6)),
    ],
)
def test_the_benchmarks_of_chung_and_ooi(material, sizes, speed, expected):
    young, poisson, density = material
    radius, radius_share, mass_share = sizes
    modulus = young / (2.0 * (1.0 - poisson**2))
    mass = mass_share * sphere(radius, density).mass
    k = contact.stiffness(modulus, radius_share * radius)
    force, overlap, time = expected
    assert contact.largest_force(mass, k, speed) == pytest.approx(force, rel=5e-4)
    assert contact.largest_hertz_overlap(mass, k, speed) == pytest.approx(overlap, rel=5e-4)
    assert contact.contact_time(mass, k, speed) == pytest.approx(time, rel=5e-4)


def test_overlap_and_time_by_energy_and_quadrature():
    mass, k, speed = 2.0, 3e9, 0.7
    overlap = brentq(lambda x: 0.4 * k * x**2.5 - 0.5 * mass * speed**2, 1e-9, 1.0, rtol=1e-14)
    assert contact.largest_hertz_overlap(mass, k, speed) == pytest.approx(overlap, rel=1e-12)
    # x = 1 - y^2 takes the root from the end of 2 dx / sqrt(1 - x^(5/2))
    passed, _ = quad(lambda y: 4.0 * y / math.sqrt(1.0 - (1.0 - y * y) ** 2.5), 0.0, 1.0)
    assert contact.contact_time(mass, k, speed) * speed / overlap == pytest.approx(passed)
    assert passed == pytest.approx(2.9432, abs=1e-4)


def test_the_series_of_the_viscoelastic_restitution_has_an_error_of_third_order():
    errors = [
        contact.impact(a, clipped=False).restitution - closed_forms.viscoelastic_series(a)
        for a in (0.04, 0.02)
    ]
    assert errors[0] / errors[1] == pytest.approx(8.0, rel=0.25)


def test_the_relaxation_gives_the_dashpot():
    k, radius, mass, overlap, eta = contact.stiffness(1e9, 0.02), 0.02, 0.3, 1e-5, 5e4
    relaxation = closed_forms.relaxation(eta, mass, radius, k)
    dashpot = k * relaxation * math.sqrt(overlap)
    assert dashpot == pytest.approx(eta * mass * math.sqrt(radius * overlap))
