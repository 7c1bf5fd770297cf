"""Section Background: the steady-state condition, equation (6), and its angle."""

from __future__ import annotations

import math

from scipy.optimize import brentq

from harness.reproduction import as_printed
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, compare
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle
from harness.theory.energy_map import after_next_shock

_LONG = 2000  # shocks


def fate(angle_deg: float, shock: float) -> bool:
    """Return whether a grain that starts with twice the well's depth still moves in the end."""
    depth = depth_of_well(angle_deg)
    energy = 2 * depth
    for _ in range(_LONG):
        if energy < depth:
            return False
        energy = after_next_shock(energy, angle_deg, shock)
    return True


def fate_angle(shock: float) -> float:
    """Return the smallest angle [deg] at which motion lasts, by bisection of the fate."""
    low, high = 0.0, 30.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fate(middle, shock) else (middle, high)
    return 0.5 * (low + high)


def height(along: float, normal: float, angle_deg: float) -> float:
    """Return the height [d] of a point of the row's own frame once the row is tilted."""
    tilt = math.radians(angle_deg)
    return normal * math.cos(tilt) - along * math.sin(tilt)


def depth_of_well(angle_deg: float) -> float:
    """Return how far a crest stands above the well before it [d], from coordinates.

    Spheres at 0 and 1; the grain's centre is the tip of an equilateral triangle in the
    well and one diameter above the second sphere on the crest.
    """
    crest = height(1.0, 0.0, angle_deg) + 1.0
    return crest - height(0.5, math.sqrt(3) / 2, angle_deg)


def statements(printed: Printed) -> list[Statement]:
    """Return the rows of this part."""
    found = fate_angle(0.25)

    def root(divisor: float) -> float:
        def margin(angle: float) -> float:
            return as_printed.steady_state_margin(angle, 0.25, divisor)

        return float(brentq(margin, 0.5, 29.5))

    as_it_stands = root(printed.well_divisor)
    return [
        compare(
            SOURCES["eq-6"],
            printed=as_it_stands,
            found=found,
            computed=f"root of the last line as printed {as_it_stands:.4f} deg; bisecting the fate "
            f"of the energy map gives {found:.4f} deg, the closed form {critical_angle():.4f} deg",
            corrected=root(2.0),
        ),
        compare(
            SOURCES["text-critical-angle"],
            printed=printed.critical_angle_deg,
            found=found,
            computed=f"bisection of the fate of the energy map at shock 1/4: {found:.4f} deg",
        ),
    ]
