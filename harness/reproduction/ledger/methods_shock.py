"""Section Methods: the shock of a deformable base, equation (13)."""

from __future__ import annotations

import math

import numpy as np

from harness.reproduction import as_printed
from harness.reproduction.claims import Statement, compare
from harness.reproduction.source import SOURCES
from harness.theory.critical_angle import critical_angle
from harness.theory.two_spheres import impulse_on_fixed

_RATIOS = np.linspace(0.3, 1.0, 15)
_REACHED = 0.54  # of tall towers, for the numbers in words


def statements() -> list[Statement]:
    """Return the rows of this part."""
    return [_reference_impulse(), _shock(), _direction()]


def _reference_impulse() -> Statement:
    speed, mass = 1.0, 1.0
    ideal = mass * speed  # what stops the normal velocity at e_n = 0
    elastic = impulse_on_fixed(mass, 1e6, speed, 0.0)
    return compare(
        SOURCES["eq-13-reference"],
        printed=elastic,
        found=ideal,
        computed=f"the two-particle run is elastic and gives {elastic:g} m v, the ideal shock, "
        f"which has e_n = 0, {ideal:g} m v: alpha is taken from rebounds and used where there are "
        "none",
    )


def _shock() -> Statement:
    after = 0.5
    falls = [critical_angle(as_printed.modified_shock(1.0, after, a)) for a in (1.0, _REACHED)]
    rises = [critical_angle(as_printed.modified_velocity(after, a) ** 2) for a in (1.0, _REACHED)]
    return compare(
        SOURCES["eq-13"],
        printed=[as_printed.modified_shock(1.0, after, a) for a in _RATIOS],
        found=[as_printed.modified_velocity(after, a) ** 2 for a in _RATIOS],
        computed="energy of the second line's velocity against the third line's shock at e_n = 0, "
        f"alpha from 0.3 to 1: they agree at alpha = 1 only and lead opposite ways, theta_c "
        f"{falls[0]:.2f} to {falls[1]:.2f} deg by the third line, {rises[0]:.2f} to "
        f"{rises[1]:.2f} deg by the second, at alpha = {_REACHED:g}",
    )


def _direction() -> Statement:
    """Hold the third line to what a reduced impulse along the contact normal leaves."""
    before = np.array([math.sqrt(3) / 2, 0.5])  # normal and tangential part
    left = [float((before[0] * (1 - a)) ** 2 + before[1] ** 2) for a in _RATIOS]
    at = float((before[0] * (1 - _REACHED)) ** 2 + before[1] ** 2)
    return compare(
        SOURCES["eq-13-direction"],
        printed=[as_printed.modified_shock(1.0, 0.5, a) for a in _RATIOS],
        found=left,
        computed="the impulse acts along the contact's normal and takes sqrt(3)/2 v' from the "
        "velocity, not the v'/2 by which the speed falls: in vectors, alpha of it leaves "
        f"1/4 + 3/4 (1 - alpha)^2, {at:.3f} in place of "
        f"{as_printed.modified_shock(1.0, 0.5, _REACHED):.3f} at alpha = {_REACHED:g}, and "
        f"theta_c = {critical_angle(at):.2f} deg",
        corrected=[0.25 + 0.75 * (1 - a) ** 2 for a in _RATIOS],
    )
