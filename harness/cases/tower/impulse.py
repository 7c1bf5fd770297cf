"""The impulse on the grain against the height of the tower, and the critical angle from it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, NamedTuple, TypedDict, Unpack, get_args

from harness.cases.bench import Bench
from harness.cases.tower.parameters import LAWS, SEARCH, Law, Tower
from harness.cases.tower.runs import Progress, TowerRun, runs_in, solve, timing_of
from harness.cases.tower.windows import (
    Window,
    impulse,
    impulse_until,
    touch_time,
    window_end,
)
from harness.engines.contract import Engine
from harness.errors import EngineError, RequestError
from harness.theory import incline
from harness.theory.chain import Reading, shock_from_impulse_ratio

if TYPE_CHECKING:
    import pandas as pd

READINGS: tuple[Reading, ...] = get_args(Reading)
HEIGHTS = tuple(range(1, 20))  # the source's runs, whose stiffness it calls rigidity 1e4 to 1e6
STIFFNESSES = (1e5, 1e6, 1e7)  # [N/m]
SPEEDS = (2.0, 4.0)  # [m/s]
MARGIN = 1.001  # a longer run has another step, and finds the end of its window a little off


class TableOptions(TypedDict, total=False):
    """Ranges of a table; the source's values where nothing is given."""

    heights: Iterable[int]
    stiffnesses: Iterable[float]  # [N/m]
    speeds: Iterable[float]  # [m/s]
    laws: Iterable[Law]
    windows: Sequence[Window]


@dataclass(frozen=True)
class ImpulseRow:
    """One entry of the impulse table: ``ratio`` is alpha(n) = J(n)/J(1).

    ``window_s``, ``impulse_Ns`` and ``ratio`` are NaN where the window does not exist, as the
    structure window of tall towers.
    """

    height: int
    stiffness: float  # [N/m]
    speed: float  # [m/s]
    law: str
    window: str
    window_s: float  # [s] its end
    impulse_Ns: float  # [N s]
    ratio: float  # [1]


def impulse_table(
    *,
    solver: str | None = None,
    case: Tower | None = None,
    engine: Engine | None = None,
    progress: Progress = lambda *_: None,
    **over: Unpack[TableOptions],
) -> list[ImpulseRow]:
    """Return alpha(n) = J(n)/J(1) [1] for every combination, the source's by default.

    ``over`` are lists of heights, stiffnesses, speeds, laws and windows; ``case`` has the other
    parameters. A window that a tower does not show within 3 t0 leaves NaN in its row. An engine
    runs the heights of one law, stiffness and speed together; without one the exact solver, or
    another ``solver``, runs the towers. ``progress`` is called for each.
    """
    windows = over.get("windows", ("turnaround",))
    over["heights"] = wanted = tuple(over.get("heights", HEIGHTS))
    runner = Runner(solver or "exact", engine, profiles="structure" in windows)
    groups = list(families(case, **over))
    rows: list[ImpulseRow] = []
    done, total = 0, sum(map(len, groups))
    for group in groups:
        impulses = {}
        for run in runner.runs(group):
            impulses[run.tower.height] = _impulses(run, windows, runner)
            done += 1
            progress("towers", done, total)
        first = group[0]
        rows += [
            ImpulseRow(
                height, first.each("stiffness")[0], first.speed, first.law, window, end, value,
                value / impulses[1][window][1],
            )
            for height in wanted
            for window, (end, value) in impulses[height].items()
        ]  # fmt: skip
    return rows


def impulse_angles(
    *,
    reading: Reading = "lost",
    case: Tower | None = None,
    solver: str | None = None,
    engine: Engine | None = None,
    progress: Progress = lambda *_: None,
    **over: Unpack[TableOptions],
) -> pd.DataFrame:
    """Return alpha(n) [1] and theta_c(n) [deg], a row for each combination.

    Arguments are those of :func:`impulse_table`; RK4 is the solver unless another, or an engine, is
    given. ``critical_angle_deg`` is that of ``reading``; both readings have columns too. Window,
    impulse, ratio and angles are NaN where the window does not exist.
    """
    import pandas as pd

    common = case or Tower()
    rows = impulse_table(
        case=common, solver=solver or "rk4", engine=engine, progress=progress, **over
    )
    return pd.DataFrame([_record(row, common, reading) for row in rows])


def energy_scaling_angles(heights: Iterable[int] = HEIGHTS) -> pd.DataFrame:
    """Return alpha = 1/sqrt(n) [1] and the angles [deg] of both readings, as the source does."""
    import pandas as pd

    rows = []
    for height in heights:
        ratio = incline.impulse_ratio(height)
        rows.append({"height": height, "impulse_ratio": ratio, **_angles(ratio)})
    return pd.DataFrame(rows)


class StatePoint(NamedTuple):
    """Stiffness, mass and gravity that reach a given Gamma; the speed follows."""

    stiffness: float  # [N/m]
    mass: float  # [kg]
    gravity: float  # [m/s2]


STATE_POINTS = (
    StatePoint(1e6, 1.0, 9.81),
    StatePoint(1e4, 0.01, 1.62),
    StatePoint(3e7, 40.0, 25.0),
)


def impulse_by_gamma(
    gammas: Iterable[float],
    *,
    heights: Sequence[int] = HEIGHTS,
    ways: Iterable[StatePoint] = STATE_POINTS[:1],
    laws: Iterable[Law] = LAWS,
    solver: str | None = None,
) -> pd.DataFrame:
    """Return alpha(n) [1] against Gamma [1], each value reached at the state points ``ways``.

    Columns as of :func:`impulse_angles`, and mass [kg] and gravity [m/s2]. Each Gamma must be
    greater than 0.
    """
    import pandas as pd

    frames = []
    for gamma, point in itertools.product(gammas, ways):
        speed = point.gravity / (gamma * math.sqrt(point.stiffness / point.mass))
        case = Tower(mass=point.mass, gravity=point.gravity)
        frame = impulse_angles(
            heights=heights, stiffnesses=(point.stiffness,), speeds=(speed,), laws=laws,
            solver=solver, case=case,
        )  # fmt: skip
        frames.append(frame.assign(mass_kg=point.mass, gravity_m_per_s2=point.gravity))
    return pd.concat(frames, ignore_index=True)


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


def families(case: Tower | None = None, **over: Unpack[TableOptions]) -> Iterator[list[Tower]]:
    """Yield the towers of each law, stiffness and speed, the height 1 that others need first."""
    heights = dict.fromkeys((1, *over.get("heights", HEIGHTS)))
    for law, k, speed in itertools.product(
        over.get("laws", LAWS), over.get("stiffnesses", STIFFNESSES), over.get("speeds", SPEEDS)
    ):
        family = (case or Tower()).replace(law=law, stiffness=k, speed=speed, height=1)
        yield [family.replace(height=height) for height in heights]


@dataclass(frozen=True)
class Runner:
    """Runs towers by a solver, or in an engine where one is given."""

    solver: str
    engine: Engine | None = None
    profiles: bool = False

    def runs(self, cases: Sequence[Tower], duration: float = SEARCH) -> Iterator[TowerRun]:
        """Yield the runs of ``cases`` for ``duration`` [t0]; in an engine they are one batch."""
        if self.engine is None:
            for case in cases:
                yield solve(case, self.solver, duration=duration, profiles=self.profiles)
            return
        timings = [timing_of(case, duration) for case in cases]
        for run in runs_in(Bench(self.engine), cases, timings):
            if isinstance(run, EngineError):
                raise run
            yield run

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


def _impulses(
    run: TowerRun, windows: Sequence[Window], runner: Runner
) -> dict[Window, tuple[float, float]]:
    """Return each window's end [s] and impulse [N s], NaN where there is none."""
    impulses: dict[Window, tuple[float, float]] = {}
    for window in windows:
        try:
            covered = runner.covering(run, window)
        except RequestError:
            impulses[window] = (math.nan, math.nan)
            continue
        end = window_end(covered, window)
        impulses[window] = end, impulse_until(covered, end)
    return impulses


def _record(row: ImpulseRow, common: Tower, reading: Reading) -> dict[str, object]:
    tower = common.replace(stiffness=row.stiffness, speed=row.speed)
    return {
        "height": row.height,
        "stiffness_N_per_m": row.stiffness,
        "speed_m_per_s": row.speed,
        "law": row.law,
        "window": row.window,
        "impulse_ratio": row.ratio,
        "critical_angle_deg": angle_from_impulse_ratio(row.ratio, reading),
        **_angles(row.ratio),
        "impulse_Ns": row.impulse_Ns,
        "window_s": row.window_s,
        "gamma": tower.gamma,
    }


def _angles(ratio: float) -> dict[str, float]:
    return {
        f"critical_angle_{name}_deg": angle_from_impulse_ratio(ratio, name) for name in READINGS
    }
