"""The closed forms held against second routes: root finding and direct iteration."""

from __future__ import annotations

import math

from scipy.optimize import brentq

from harness.cases.incline.tolerances import CLOSED_FORM
from harness.comparison.verdicts import Check, Kind, judge
from harness.theory import energy_map
from harness.theory.critical_angle import STATIC_ANGLE_DEG, critical_angle, no_flight_bound
from harness.theory.shock import SHOCK_WITHOUT_REBOUND, shock_from_restitution

MANY_SHOCKS = 200


def theory_checks() -> list[Check]:
    """Return the self-checks of the theory of the incline."""
    closed = critical_angle()
    pairs = [
        ("theory: root of E* = C", _root_of_steady_state(), closed),
        ("theory: iterated recursion", _by_iteration(), closed),
        ("theory: root of the passage margin", _root_of_margin(), closed),
        ("theory: shock from e = 0", critical_angle(shock_from_restitution(0.0)), closed),
        ("theory: no energy left is the static angle", critical_angle(0.0), STATIC_ANGLE_DEG),
        ("theory: no loss, no critical angle", critical_angle(1.0), 0.0),
        ("theory: contact force vanishes", _root_of_contact_force(), no_flight_bound()),
    ]
    return [
        judge(name, Kind.ANALYTIC, value, expected, CLOSED_FORM) for name, value, expected in pairs
    ]


def _root_of_steady_state() -> float:
    shock = SHOCK_WITHOUT_REBOUND
    return float(
        brentq(
            lambda a: energy_map.steady_energy(a, shock) - energy_map.well_depth(a),
            1.0,
            29.0,
            xtol=1e-13,
        )
    )


def _root_of_margin() -> float:
    shock = SHOCK_WITHOUT_REBOUND
    return float(brentq(lambda a: energy_map.passage_margin(a, shock), 1.0, 29.0, xtol=1e-13))


def _by_iteration() -> float:
    """Bisect on the fate of a grain whose energy is taken from shock to shock."""
    trapped, moving = 1.0, 29.0
    while moving - trapped > 1e-12:
        angle = (trapped + moving) / 2
        if _keeps_moving(angle):
            moving = angle
        else:
            trapped = angle
    return (trapped + moving) / 2


def _keeps_moving(angle: float) -> bool:
    depth = energy_map.well_depth(angle)
    energy = 1.0
    for _ in range(MANY_SHOCKS):
        energy = energy_map.after_next_shock(energy, angle, SHOCK_WITHOUT_REBOUND)
        if energy < depth:
            return False
    return True


def _root_of_contact_force() -> float:
    """Return where the weight along the last normal just bends the steady path (m g = d = 1)."""

    def force(angle: float) -> float:
        before = energy_map.steady_energy(angle, SHOCK_WITHOUT_REBOUND)
        speed_squared = 2.0 * (before + energy_map.gain_per_crest(angle))
        return math.cos(math.radians(30.0 + angle)) - speed_squared

    return float(brentq(force, 1.0, 29.0, xtol=1e-13))
