"""What the source expects of a column of n deformable particles: its critical angle, twice."""

from __future__ import annotations

from functools import cache

from harness.observables.tower import SEARCH, impulse
from harness.parameters.tower import Law, Tower
from harness.solvers.chain import exact
from harness.theory.chain import Reading, shock_from_impulse_ratio
from harness.theory.incline import critical_angle

READINGS: dict[Reading, str] = {
    "lost": "velocity lost",
    "kept": "velocity kept",
}


def impulse_ratio(n: int, law: Law) -> float:
    """Return alpha(n) = J(n)/J(1), turnaround window, k = 1e6 N/m and 2 m/s: the source's."""
    return _impulse(n, law) / _impulse(1, law)


@cache
def source_angles(n: int, law: Law) -> dict[Reading, float]:
    """Return the source's theta_c(n) [deg], by its reading of the impulse ratio."""
    return {
        reading: critical_angle(shock_from_impulse_ratio(impulse_ratio(n, law), reading))
        for reading in READINGS
    }


@cache
def _impulse(n: int, law: Law) -> float:
    tower = Tower(height=n, law=law, stiffness=1e6, speed=2.0)
    return impulse(exact.run(tower, SEARCH * tower.contact_time))
