"""The source's formulas and numbers exactly as it prints them, right or wrong.

Harper, Dufek and Breard, arXiv 2409.13633. Nothing here is used for physics: the
ledger evaluates it and holds it against routes that share no code with it. Energies
are in units of m g r where the source has that factor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Printed:
    """The numbers that the source prints, in the order of the text."""

    critical_angle_deg: float = 10.21
    simulated_within_deg: float = 0.01  # "to one-hundredth of a degree"
    rest_angle_deg: float = 30.0
    well_divisor: float = 4.0  # of theta in the steady-state condition, eq. (6)
    shock: float = 0.25
    diverges_above: float = 1.0  # "E > 1 ... will go to infinity"
    restitution: float = 1e-20
    gravity: float = 9.81  # [m/s2]
    glass_rigidity: float = 40_000.0
    glass_depth: float = 0.5  # [m]
    rigidities: tuple[float, float] = (1e4, 1e6)
    stiffnesses: tuple[float, float] = (1e5, 1e7)  # [N/m]
    orders_of_magnitude: float = 3.0  # that the rigidities are said to span
    median_rigidity: float = 1e5
    crest_time: float = 0.41  # [s]
    contact_time: float = 0.007  # [s]
    damping_factor: float = 1.0  # of (gamma/m_eff)^2, eq. (12)
    error_percent: float = 0.5  # of the peak deformation ...
    error_stiffness: float = 1e4  # [N/m] ... from here on
    joins: float = 0.5  # [t0] the third particle
    returns: float = 1.0  # [t0] the second contact of the grain
    leaves: float = 1.5  # [t0] the grain
    speeds: tuple[float, float] = (2.0, 4.0)  # [m/s]
    heights: tuple[int, int] = (1, 19)
    longest_chain: int = 10  # contacts
    halved: float = 0.5  # "can nearly halve the impulse"
    speed_exponent: float = 0.5  # v ~ sqrt(n)
    difference_percent: float = 1e-6  # of deformations at the largest rigidity
    search: float = 3.0  # [t0] bound of the largest compression
    structure_particles: tuple[int, int] = (2, 7)
    first_packet: float = 1.5  # [t0] end of grain-neighbour interactions
    window_figure: tuple[int, int] = (4, 3)  # particles: its caption, its text


PRINTED = Printed()


def series_stiffness(stiffness: float, springs: int) -> float:
    """Return k' = k/n (eq. 1)."""
    return stiffness / springs


def well(angle_deg: float) -> float:
    """Return 1 - cos(pi/6 - theta), in m g r (Table I)."""
    return 1 - math.cos(math.pi / 6 - math.radians(angle_deg))


def gain(angle_deg: float) -> float:
    """Return sin(theta), in m g r (Table I)."""
    return math.sin(math.radians(angle_deg))


def energy_after_first(start: float, gained: float, shock: float) -> float:
    """Return E_1 = (E_0 + dE) shock (Table I)."""
    return (start + gained) * shock


def energy_series(shocks: int, start: float, gained: float, shock: float) -> float:
    """Return E_n of eq. (2), whose sum has the power n - 1 twice and n - 2 never (n >= 3)."""
    powers = (shocks - 1, shocks - 1, *range(shocks - 3, -1, -1))
    return float(start * shock**shocks + gained * shock * sum(shock**p for p in powers))


def geometric_sum(ratio: float, terms: int) -> float:
    """Return S_n = (1 - x^(n+1)) / (1 - x) (eq. 3)."""
    return (1 - ratio ** (terms + 1)) / (1 - ratio)


def energy_closed(shocks: int, first: float, gained: float, shock: float) -> float:
    """Return E_n = E_1 shock^(n-1) + dE shock (1 - shock^(n-1)) / (1 - shock) (eq. 4)."""
    power = shock ** (shocks - 1)
    return first * power + gained * shock * (1 - power) / (1 - shock)


def limiting_energy(gained: float, shock: float) -> float:
    """Return dE shock / (1 - shock) (eq. 5)."""
    return gained * shock / (1 - shock)


def steady_state_margin(angle_deg: float, shock: float, divisor: float) -> float:
    """Return left minus right side of the last line of eq. (6); ``divisor`` is that of theta."""
    theta = math.radians(angle_deg)
    return shock / (1 - shock) - 2 * math.sin(math.pi / 12 - theta / divisor) ** 2 / math.sin(theta)


def shock_of_velocities(before: float, after: float) -> float:
    """Return |(v' - v)/v'|^2 (eq. 7)."""
    return abs((before - after) / before) ** 2


def velocity_after(before: float, restitution: float) -> float:
    """Return sqrt((v'/2)^2 + (e v' sqrt(3)/2)^2) (eq. 8)."""
    return math.sqrt((before / 2) ** 2 + (restitution * before * math.sqrt(3) / 2) ** 2)


def shock_of_restitution(restitution: float) -> float:
    """Return (1 - sqrt(1/4 + 3/4 e^2))^2 (eq. 9)."""
    return (1 - math.sqrt(0.5**2 + (restitution * math.sqrt(3) / 2) ** 2)) ** 2


def rigidity(stiffness: float, pressure: float) -> float:
    """Return kappa = k/P (eq. 10)."""
    return stiffness / pressure


def crest_time(radius: float, gravity: float) -> float:
    """Return 1/4 sqrt(2 g (2 r (1 - sin 60))) cos 60 / g [s] (eq. 11)."""
    sixty = math.radians(60)
    speed = math.sqrt(2 * gravity * (2 * radius * (1 - math.sin(sixty))))
    return 0.25 * speed * math.cos(sixty) / gravity


def collision_time(stiffness: float, effective_mass: float, damping: float, factor: float) -> float:
    """Return pi (k/m_eff - factor (gamma/m_eff)^2)^(-1/2) [s] (eq. 12, factor 1)."""
    rate = stiffness / effective_mass - factor * (damping / effective_mass) ** 2
    return math.pi / math.sqrt(rate)


def modified_velocity(after: float, ratio: float) -> float:
    """Return v_i(n) = v_i alpha(n) (eq. 13, second line)."""
    return after * ratio


def modified_shock(before: float, after: float, ratio: float) -> float:
    """Return |(v_0 - v_s alpha(n))/v_0|^2 (eq. 13, third line)."""
    return abs((before - after * ratio) / before) ** 2


def dashpot_force(stiffness: float, deformation: float) -> float:
    """Return F = k dx [N] (eq. 14)."""
    return stiffness * deformation


def pair_accelerations(
    x: Floats, radius: float, stiffness: float, mass: float
) -> tuple[float, float]:
    """Return a_1 and a_2 [m/s2] of two particles at ``x`` (2,) [m] (eq. 15)."""
    first = stiffness / mass * (2 * radius - (x[1] - x[0]))
    return float(first), float(-first)


def first_boundary(x: Floats, radius: float) -> float:
    """Return b_0 [m] of a chain at ``x`` (n,) [m] (eqs. 16 and A7)."""
    n = x.size
    total = sum((-1) ** (i + 1) * (2 * (n - i) + 1) * x[i - 1] for i in range(1, n + 1))
    return float(((-1) ** n * radius + total) / n)


def next_boundary(centre: float, before: float) -> float:
    """Return b_n = x_n + (x_n - b_(n-1)) [m] (eqs. 17 and A1)."""
    return centre + (centre - before)


def energy_of_two_without_stiffness(compression: float) -> float:
    """Return 1/4 4 c_1^2, the last step before 2 U_1 (Discussion)."""
    return 0.25 * 4 * compression**2


def kinetic_energy_of_springs(stiffness: float, springs: int, compression: float) -> float:
    """Return n (1/2 k c_n), in which the square is missing (eq. 18)."""
    return springs * (0.5 * stiffness * compression)


def last_boundary(x: Floats, first: float) -> float:
    """Return sum_i (2 x_i (-1)^(n+1) + b_0 (-1)^n) [m] (eq. A2, last line)."""
    n = x.size
    return float(sum(2 * centre * (-1) ** (n + 1) + first * (-1) ** n for centre in x))


def deformation(centre: float, before: float, radius: float) -> float:
    """Return 2 (r_0 - (x_i - b_(i-1))) [m] (eq. A3)."""
    return 2 * (radius - (centre - before))


def first_deformation(others: Floats) -> float:
    """Return dx_2 - (dx_3 - (dx_4 - ...)) [m] of ``others`` dx_2 to dx_n (eq. A6, last line)."""
    result = 0.0
    for value in others[::-1]:
        result = value - result
    return float(result)


def boundary_of_four(x: Floats) -> float:
    """Return (-x_4 + 3 x_3 - 5 x_2 + 7 x_1)/4 [m] (example of four particles, last line)."""
    return float((-x[3] + 3 * x[2] - 5 * x[1] + 7 * x[0]) / 4)


def imbalance_of_four(x: Floats, first: float, radius: float) -> float:
    """Return left minus right of the example's line with all boundaries put in [m]."""
    left = radius - x[0] + first
    right = radius - x[1] + 2 * x[0] - 2 * first - radius + x[2]
    right += -(2 * x[1] - 2 * x[0] + first) + radius
    right += -x[3] + 2 * x[2] - 2 * x[1] + 2 * x[0] - first
    return float(left - right)


def largest_compression(radius: float, deformed: float) -> float:
    """Return 2 r_0 - dx_i [m], the bound of c_(i,j) (eq. A8)."""
    return 2 * radius - deformed
