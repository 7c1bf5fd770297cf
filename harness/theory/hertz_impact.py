"""The head-on impact of elastic spheres under Hertz's law, and the loss of a viscous dashpot.

m* x'' = -K x^(3/2) with K = 4/3 E* sqrt(R*) (Johnson, Contact Mechanics (1985), section 11.4).
"""

from __future__ import annotations

import math

from scipy.special import beta


def stiffness(modulus: float, radius: float) -> float:
    """Return K = 4/3 E* sqrt(R*) [N/m^(3/2)] of the effective modulus [Pa] and radius [m]."""
    return 4.0 / 3.0 * modulus * math.sqrt(radius)


def largest_overlap(mass: float, coefficient: float, speed: float) -> float:
    """Return (5 m* v^2 / 4 K)^(2/5) [m]."""
    return float((1.25 * mass * speed**2 / coefficient) ** 0.4)


def largest_force(mass: float, coefficient: float, speed: float) -> float:
    """Return K overlap^(3/2) at the largest overlap [N]."""
    return float(coefficient * largest_overlap(mass, coefficient, speed) ** 1.5)


def contact_time(mass: float, coefficient: float, speed: float) -> float:
    """Return 4/5 B(2/5, 1/2) = 2.9432 times overlap / speed [s], with Euler's beta function."""
    periods = 0.8 * float(beta(0.4, 0.5))
    return periods * largest_overlap(mass, coefficient, speed) / speed


def relaxation(damping_coefficient: float, mass: float, radius: float, coefficient: float) -> float:
    """Return A [s] of a dashpot eta_n = eta_0 m* a, a^2 = R* overlap: eta_0 m* sqrt(R*) / K.

    ``harness.theory.hertz.impact`` takes A v / overlap and returns the restitution.
    """
    return damping_coefficient * mass * math.sqrt(radius) / coefficient
