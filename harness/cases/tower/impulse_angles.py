"""From the impulse ratio to the critical angle, in tables."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple, Unpack, get_args

import pandas as pd

from harness.cases.contract import Progress, silent
from harness.cases.tower.impulse_table import HEIGHTS, TableOptions, impulse_table
from harness.cases.tower.run import chosen_solver
from harness.observables.impulse import ImpulseRow
from harness.observables.windows import Window
from harness.parameters.tower import LAWS, Law, Tower
from harness.theory import energy_scaling
from harness.theory.critical_angle import critical_angle
from harness.theory.shock import Reading, shock_from_impulse_ratio

if TYPE_CHECKING:
    from harness.engines.contract import Engine

READINGS: tuple[Reading, ...] = get_args(Reading)


class Way(NamedTuple):
    """One of the ways to a given Gamma; the speed follows."""

    stiffness: float  # [N/m]
    mass: float  # [kg]
    gravity: float  # [m/s2]


WAYS = (Way(1e6, 1.0, 9.81), Way(1e4, 0.01, 1.62), Way(3e7, 40.0, 25.0))


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
    engine: Engine | None = None,
    progress: Progress = silent,
    **over: Unpack[TableOptions],
) -> pd.DataFrame:
    """Return alpha(n) [1] and theta_c(n) [deg], a row for each combination (:func:`impulse_table`).

    Takes what that takes; RK4 is the solver unless another, or an engine, is given.
    ``critical_angle_deg`` is that of ``reading``; both readings stand beside it.
    Window, impulse, ratio and angles are NaN where the window does not exist.
    """
    common, name = case or Tower(), chosen_solver(solver, engine)
    rows = impulse_table(case=common, solver=name, engine=engine, progress=progress, **over)
    return pd.DataFrame([_record(row, common, reading) for row in rows])


def energy_scaling_angles(heights: Iterable[int] = HEIGHTS) -> pd.DataFrame:
    """Return alpha = 1/sqrt(n) [1] and the angles [deg] of both readings, as the source does."""
    rows = []
    for height in heights:
        ratio = energy_scaling.impulse_ratio(height)
        rows.append({"height": height, "impulse_ratio": ratio, **_angles(ratio)})
    return pd.DataFrame(rows)


def impulse_by_gamma(
    gammas: Iterable[float],
    *,
    heights: Sequence[int] = HEIGHTS,
    ways: Iterable[Way] = WAYS[:1],
    laws: Iterable[Law] = LAWS,
    windows: Sequence[Window] = ("turnaround",),
    solver: str | None = None,
) -> pd.DataFrame:
    """Return alpha(n) [1] against Gamma [1], each value reached in different ``ways``.

    Columns as of :func:`impulse_angles`, and mass and gravity of the way. Each
    Gamma must be greater than 0.
    """
    frames = []
    for gamma, way in itertools.product(gammas, ways):
        speed = way.gravity / (gamma * math.sqrt(way.stiffness / way.mass))
        case = Tower(mass=way.mass, gravity=way.gravity)
        frame = impulse_angles(
            heights=heights, stiffnesses=(way.stiffness,), speeds=(speed,), laws=laws,
            windows=windows, solver=solver, case=case,
        )  # fmt: skip
        frames.append(frame.assign(mass_kg=way.mass, gravity_m_per_s2=way.gravity))
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
