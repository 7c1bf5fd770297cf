"""What the paper expects of a column of n deformable particles: its critical angle, twice."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from harness.chain import exact
from harness.observables.impulse import impulse
from harness.observables.windows import SEARCH
from harness.parameters.tower import Tower
from harness.theory.critical_angle import critical_angle
from harness.theory.shock import Reading, shock_from_impulse_ratio

PAPER = Tower(law="deformable", stiffness=1e6, speed=2.0, height=1)
"""The paper's run in the middle of its range of stiffness."""


def paper_angles(heights: Sequence[int], reading: Reading) -> list[float]:
    """Return theta_c(n) [deg] of the paper in a reading, by impulses of exact towers."""
    first = _impulse(1)
    ratios = [_impulse(height) / first for height in heights]
    return [critical_angle(shock_from_impulse_ratio(ratio, reading)) for ratio in ratios]


@cache
def _impulse(height: int) -> float:
    tower = PAPER.replace(height=height)
    run = exact.run(tower, SEARCH * tower.contact_time)
    return impulse(run, "turnaround")
