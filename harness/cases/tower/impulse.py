"""The impulse on the grain against the height of the tower, and the critical angle from it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, TypedDict, Unpack, get_args

import pandas as pd

from harness.cases.tower.run import SOLVERS, chosen_solver, covering, towers
from harness.cases.verification import Progress, silent
from harness.engines.contract import Engine
from harness.errors import RequestError
from harness.observables.tower import ImpulseRow, TowerRun, Window, impulse_until, window_end
from harness.parameters.tower import LAWS, Law, Tower
from harness.store.cache import EngineChoice, opened
from harness.theory import incline
from harness.theory.chain import Reading, shock_from_impulse_ratio
from harness.theory.incline import critical_angle

# the source's runs, which it calls rigidity 1e4 to 1e6
HEIGHTS = tuple(range(1, 20))
STIFFNESSES = (1e5, 1e6, 1e7)
SPEEDS = (2.0, 4.0)


class TableOptions(TypedDict, total=False):
    """What a table runs over; the source's values where nothing is given."""

    heights: Iterable[int]
    stiffnesses: Iterable[float]
    speeds: Iterable[float]
    laws: Iterable[Law]
    windows: Sequence[Window]


def families(case: Tower | None = None, **over: Unpack[TableOptions]) -> Iterator[list[Tower]]:
    """Yield the towers of each law, stiffness and speed, the height 1 that others need first."""
    heights = dict.fromkeys((1, *over.get("heights", HEIGHTS)))
    for law, k, speed in itertools.product(
        over.get("laws", LAWS), over.get("stiffnesses", STIFFNESSES), over.get("speeds", SPEEDS)
    ):
        family = (case or Tower()).replace(law=law, stiffness=k, speed=speed, height=1)
        yield [family.replace(height=height) for height in heights]


def impulse_table(
    *,
    solver: str | None = None,
    case: Tower | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress = silent,
    **over: Unpack[TableOptions],
) -> list[ImpulseRow]:
    """Return alpha(n) = J(n)/J(1) [1] for every combination, the source's by default.

    ``heights`` [contacts], ``stiffnesses`` [N/m], ``speeds`` [m/s].

    ``over`` are lists of heights, stiffnesses [N/m], speeds [m/s], laws and windows
    (:class:`TableOptions`). ``case`` gives what is not listed: mass, gravity, diameter and so on. A
    window that a tower does not show within 3 t0 leaves NaN in its row. ``solver`` (the exact one
    by default) and ``engine`` are those of :func:`harness.cases.tower.run.tower`; an engine runs
    the heights of one law, stiffness and speed together. ``progress`` is called for each tower.
    """
    name = "exact" if solver is None and engine is None else chosen_solver(solver, engine)
    if isinstance(engine, str) or (engine is None and name not in SOLVERS):
        with opened(engine or name, fresh=fresh) as running:
            return impulse_table(case=case, engine=running, progress=progress, **over)
    windows = over.get("windows", ("turnaround",))
    over["heights"] = wanted = tuple(over.get("heights", HEIGHTS))
    profiles = "structure" in windows  # its end is a contact's, which the grain does not feel
    groups = list(families(case, **over))
    rows: list[ImpulseRow] = []
    done, total = 0, sum(map(len, groups))
    for group in groups:
        impulses = {}
        for run in towers(group, solver=name, profiles=profiles, engine=engine):
            impulses[run.tower.height] = _impulses(run, windows, engine)
            done += 1
            progress("towers", done, total)
        first = group[0]
        k, speed = first.each("stiffness")[0], first.speed
        rows += [
            ImpulseRow(
                height, k, speed, first.law, window, end, value, value / impulses[1][window][1]
            )
            for height in wanted
            for window, (end, value) in impulses[height].items()
        ]
    return rows


def _impulses(
    run: TowerRun, windows: Sequence[Window], engine: Engine | None
) -> dict[Window, tuple[float, float]]:
    """Return each window's end [s] and impulse [N s], NaN where there is none."""
    impulses: dict[Window, tuple[float, float]] = {}
    for window in windows:
        try:
            covered = covering(run, window, engine)
        except RequestError:
            impulses[window] = (math.nan, math.nan)
            continue
        end = window_end(covered, window)
        impulses[window] = end, impulse_until(covered, end)
    return impulses


READINGS: tuple[Reading, ...] = get_args(Reading)


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


def angle_from_impulse_ratio(ratio: float, reading: Reading = "lost") -> float:
    """Return the critical angle [deg] of an impulse ratio alpha.

    NaN unless 0 < alpha < 2, where the shock of neither reading is one.
    """
    if not 0.0 < ratio < 2.0:
        return math.nan
    return critical_angle(shock_from_impulse_ratio(ratio, reading))


def impulse_angles(
    *,
    reading: Reading = "lost",
    case: Tower | None = None,
    solver: str | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress = silent,
    **over: Unpack[TableOptions],
) -> pd.DataFrame:
    """Return alpha(n) [1] and theta_c(n) [deg], a row for each combination (:func:`impulse_table`).

    Takes what that takes; RK4 is the solver unless another, or an engine, is given.
    ``critical_angle_deg`` is that of ``reading``; both readings stand beside it.
    Window, impulse, ratio and angles are NaN where the window does not exist.
    """
    common, name = case or Tower(), chosen_solver(solver, engine)
    rows = impulse_table(
        case=common, solver=name, engine=engine, fresh=fresh, progress=progress, **over
    )
    return pd.DataFrame([_record(row, common, reading) for row in rows])


def energy_scaling_angles(heights: Iterable[int] = HEIGHTS) -> pd.DataFrame:
    """Return alpha = 1/sqrt(n) [1] and the angles [deg] of both readings, as the source does."""
    rows = []
    for height in heights:
        ratio = incline.impulse_ratio(height)
        rows.append({"height": height, "impulse_ratio": ratio, **_angles(ratio)})
    return pd.DataFrame(rows)


def impulse_by_gamma(
    gammas: Iterable[float],
    *,
    heights: Sequence[int] = HEIGHTS,
    ways: Iterable[StatePoint] = STATE_POINTS[:1],
    laws: Iterable[Law] = LAWS,
    solver: str | None = None,
) -> pd.DataFrame:
    """Return alpha(n) [1] against Gamma [1], each value reached at the state points ``ways``.

    Columns as of :func:`impulse_angles`, and mass [kg] and gravity [m/s2]. Each
    Gamma must be greater than 0.
    """
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
    """Return the critical angle of each reading."""
    return {
        f"critical_angle_{reading}_deg": angle_from_impulse_ratio(ratio, reading)
        for reading in READINGS
    }
