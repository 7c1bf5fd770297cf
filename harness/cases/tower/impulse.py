"""The impulse on the grain against the height of the tower, and the critical angle from it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, get_args

from harness.cases.bench import Bench
from harness.cases.tower.parameters import LAWS, SEARCH, Law, Tower
from harness.cases.tower.runs import Progress, TowerRun, make_setup, run_in, solve
from harness.cases.tower.windows import Window, impulse, touch_time, window_end
from harness.engines.base import Engine
from harness.errors import RequestError
from harness.theory import incline
from harness.theory.chain import Reading, shock_from_impulse_ratio

if TYPE_CHECKING:
    import pandas as pd

READINGS: tuple[Reading, ...] = get_args(Reading)
HEIGHTS = tuple(range(1, 20))  # the source's runs, whose stiffness it calls rigidity 1e4 to 1e6
STIFFNESSES = (1e5, 1e6, 1e7)  # [N/m]
SPEEDS = (2.0, 4.0)  # [m/s]
MARGIN = 1.001  # a longer run has another step, and finds the end of its window a little off


def impulse_angles(  # noqa: PLR0913 - the options of a user
    *,
    reading: Reading = "lost",
    case: Tower | None = None,
    solver: str | None = None,
    engine: Engine | None = None,
    progress: Progress = lambda *_: None,
    heights: Iterable[int] = HEIGHTS,
    stiffnesses: Iterable[float] = STIFFNESSES,
    speeds: Iterable[float] = SPEEDS,
    laws: Iterable[Law] = LAWS,
    windows: Sequence[Window] = ("turnaround",),
) -> pd.DataFrame:
    """Return alpha(n) = J(n)/J(1) [1] and theta_c(n) [deg], a row for each combination.

    Heights, stiffnesses [N/m] and speeds [m/s] are the source's unless given; ``case`` has the
    other parameters. An engine runs the heights of one law, stiffness and speed together; without
    one the ``solver`` does, RK4 unless named. ``progress`` is called for each.

    ``critical_angle_deg`` is that of ``reading``; both readings have columns too. ``window_s`` is
    the end of a window; it, impulse, ratio and angles are NaN where a tower does not show the
    window, as the structure window of tall ones.
    """
    import pandas as pd

    runner, rows, heights = Runner(solver or "rk4", engine), [], tuple(heights)
    first_too = dict.fromkeys((1, *heights))  # height 1 first, which others need
    families = [
        (case or Tower()).replace(law=law, stiffness=k, speed=speed, height=1)
        for law, k, speed in itertools.product(laws, stiffnesses, speeds)
    ]
    for number, family in enumerate(families):
        impulses = {}
        for run in runner.runs([family.replace(height=height) for height in first_too]):
            impulses[run.tower.height] = [runner.impulse(run, window) for window in windows]
            done = number * len(first_too) + len(impulses)
            progress("towers", done, len(families) * len(first_too))
        for height, (place, window) in itertools.product(heights, enumerate(windows)):
            end, value = impulses[height][place]
            ratio = value / impulses[1][place][1]
            angles = {name: angle_from_impulse_ratio(ratio, name) for name in READINGS}
            rows.append({
                "height": height,
                "stiffness_N_per_m": family.each("stiffness")[0],
                "speed_m_per_s": family.speed,
                "law": family.law,
                "window": window,
                "impulse_ratio": ratio,
                "critical_angle_deg": angle_from_impulse_ratio(ratio, reading),
                **{f"critical_angle_{name}_deg": angle for name, angle in angles.items()},
                "impulse_Ns": value,
                "window_s": end,
                "gamma": family.gamma,
            })  # fmt: skip
    return pd.DataFrame(rows)


def angle_from_impulse_ratio(ratio: float, reading: Reading = "lost") -> float:
    """Return the critical angle [deg] of an impulse ratio alpha.

    NaN unless 0 < alpha < 2, where the shock of neither reading is one.
    """
    if not 0.0 < ratio < 2.0:
        return math.nan
    return incline.critical_angle(shock_from_impulse_ratio(ratio, reading))


@cache
def source_angles(height: int, law: Law) -> Mapping[Reading, float]:
    """Return the source's theta_c(n) [deg] by its reading: turnaround window, 1e6 N/m and 2 m/s."""
    impulses = [impulse(solve(Tower(height=n, law=law), "exact")) for n in (1, height)]
    ratio = impulses[1] / impulses[0]
    return {reading: angle_from_impulse_ratio(ratio, reading) for reading in READINGS}


@dataclass(frozen=True)
class Runner:
    """Runs towers by a solver, or in an engine where one is given."""

    solver: str
    engine: Engine | None = None

    def runs(self, cases: Sequence[Tower], duration: float = SEARCH) -> Iterator[TowerRun]:
        """Yield the runs of ``cases`` for ``duration`` [t0]; in an engine they are one batch."""
        if self.engine is None:
            yield from (solve(case, self.solver, duration=duration) for case in cases)
        else:
            yield from run_in(Bench(self.engine), *(make_setup(case, duration) for case in cases))

    def covering(self, run: TowerRun, window: Window) -> TowerRun:
        """Return ``run``, or a longer one of the same case that covers ``window``.

        Closest approach and impulse need 3 t0, and more where the window ends later. Raise
        RequestError if the tower does not show that window.
        """
        t0, long = run.tower.contact_time, run
        if long.time[-1] < (touch_time(run) + SEARCH * t0) * (1 - 1e-9):
            (long,) = self.runs([run.tower], touch_time(run) / t0 + SEARCH)
        end = max(window_end(long, name) for name in {window, "turnaround"})
        if end > long.time[-1]:
            (long,) = self.runs([run.tower], end / t0 * MARGIN)
        return long

    def impulse(self, run: TowerRun, window: Window) -> tuple[float, float]:
        """Return the end [s] of a window and the impulse [N s], NaN where there is none."""
        try:
            covered = self.covering(run, window)
        except RequestError:
            return math.nan, math.nan
        return window_end(covered, window), impulse(covered, window)
