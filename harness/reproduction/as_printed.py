"""The numbers of Harper, Dufek and Breard, arXiv 2409.13633, as printed, right or wrong.

Nothing here is used for physics: the ledger holds them against routes of its own. The
formulas stand in ``source.toml``.
"""

from __future__ import annotations

from dataclasses import dataclass


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
