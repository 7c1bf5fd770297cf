"""Hold the closed forms against second routes, and the adaptive reference DEM against one."""

from __future__ import annotations

import math
from collections.abc import Callable

from scipy.optimize import brentq

from harness.cases.incline.parameters import Incline
from harness.cases.incline.routes import Start
from harness.cases.incline.runs import follow
from harness.cases.incline.tolerances import ADAPTIVE_RESTITUTION, CLOSED_FORM
from harness.comparison.verdicts import Check, Kind, failed_run, judge
from harness.engines.reference.engine import Reference
from harness.errors import EngineError
from harness.parameters.contact import Contact
from harness.theory import energy_map
from harness.theory.critical_angle import STATIC_ANGLE_DEG, critical_angle, no_flight_bound
from harness.theory.dashpot import restitution_unclipped
from harness.theory.shock import SHOCK_WITHOUT_REBOUND, shock_from_restitution

MANY_SHOCKS = 200

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None, tail="attractive")


def theory_checks() -> list[Check]:
    """Return the self-checks of the theory of the incline."""
    closed = critical_angle()
    pairs = [
        ("theory: root of E* = C", _root(_excess), closed),
        ("theory: iterated recursion", _by_iteration(), closed),
        ("theory: root of the passage margin", _root(_margin), closed),
        ("theory: shock from e = 0", critical_angle(shock_from_restitution(0.0)), closed),
        ("theory: no energy left is the static angle", critical_angle(0.0), STATIC_ANGLE_DEG),
        ("theory: no loss, no critical angle", critical_angle(1.0), 0.0),
        ("theory: contact force vanishes", _root(_contact_force), no_flight_bound()),
    ]
    return [
        judge(name, Kind.ANALYTIC, value, expected, CLOSED_FORM) for name, value, expected in pairs
    ]


def _root(function: Callable[[float], float]) -> float:
    """Return the angle [deg] at which a function of it vanishes."""
    return float(brentq(function, 1.0, 29.0, xtol=1e-13))


def _excess(angle: float) -> float:
    """Return the steady energy less the depth of a well."""
    return energy_map.steady_energy(angle, SHOCK_WITHOUT_REBOUND) - energy_map.well_depth(angle)


def _margin(angle: float) -> float:
    return energy_map.passage_margin(angle, SHOCK_WITHOUT_REBOUND)


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


def _contact_force(angle: float) -> float:
    """Return the weight along the last normal less what bends the steady path (m g = d = 1)."""
    before = energy_map.steady_energy(angle, SHOCK_WITHOUT_REBOUND)
    speed_squared = 2.0 * (before + energy_map.gain_per_crest(angle))
    return math.cos(math.radians(30.0 + angle)) - speed_squared


def restitution_checks() -> list[Check]:
    """Hold a head-on collision of the adaptive reference against the closed form."""
    name = "reference DEM: restitution head-on, adaptive"
    case = Incline(angle=0.0, contact=HEAD_ON, gravity=1e-12)
    start = Start(0.0, case.diameter * (1.0 + 1e-6), 0.0, -1.0)
    try:
        path = follow(Reference("adaptive"), case, start, 3.0 * case.contact_time, every=150)
    except EngineError as error:
        return [failed_run(name, Kind.ANALYTIC, error)]
    return [
        judge(
            name,
            Kind.ANALYTIC,
            float(path.vy_m_per_s[-1]),
            restitution_unclipped(HEAD_ON.zeta),
            ADAPTIVE_RESTITUTION,
        )
    ]
