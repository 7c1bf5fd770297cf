"""Runs of the incline: the outcome of a script or of a path.

Contacts only take energy: a grain that moves back with a negative margin is trapped. LAMMPS's
script judges in its own language; the paths of other engines are judged here, at the looks that
their stages leave or every ``LOOK`` steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.system import (
    Incline,
    Route,
    end_of,
    margin,
    overlaps,
    wells_of,
)
from harness.cases.plane import COLUMNS, path_in
from harness.engines.base import Output
from harness.engines.output import Table
from harness.engines.scene_tables import STAGES
from harness.errors import EngineOutputError
from harness.model.scene import LOOK

Floats = NDArray[np.float64]

TOUCHING = {"0": False, "1": True}
PRINTED_CLOCK = 1e-5  # relative error of a time with six digits


class Fate(StrEnum):
    """The outcome of a run. Cut off by its time limit it is undecided, never trapped."""

    MOVES_ON = "moves_on"
    TRAPPED = "trapped"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Run:
    """One run, judged. Margins [m g d] are those at the end, and at each crest that was passed."""

    case: Incline
    fate: Fate
    margin: float
    touching: bool
    time_s: float
    steps: int
    crest_times_s: Floats
    crest_margins: Floats
    output: Output = field(repr=False)

    @property
    def path(self) -> Table:
        """Return the path of the grain, each column (M,). Raise EngineOutputError without one."""
        return path_in(self.output)

    @property
    def quantities(self) -> dict[str, float]:
        """Return the quantities of the case, by name."""
        return {
            "margin_over_mgd": self.margin,
            "moves_on": float(self.fate is Fate.MOVES_ON),
            "touching": float(self.touching),
            "time_s": self.time_s,
            "steps": float(self.steps),
        }


def read(case: Incline, route: Route, output: Output, every: int | None = None) -> Run:
    """Return the run in an output: judged by its script, else by its path.

    Raise EngineOutputError for an output that is incomplete, contradicts itself or has other
    settings, EngineNaNError for values that are not finite.
    """
    if output.has("route") and output.text("route") != route:
        raise EngineOutputError(f"{output.who} ran another route than {route!r}")
    output.check_numbers(
        {
            "angle_deg": case.angle,
            "mass_kg": case.mass,
            "stiffness_N_per_m": case.stiffness,
            "damping_coefficient_N_s_per_m": case.contact.dashpot(case.stiffness, case.mass),
            "gravity_m_per_s2": case.gravity,
            "step_s": case.step,
        }
    )
    run = _scripted(case, route, output) if output.results else _judged(case, route, output)
    if every is not None:
        _check_path(run, every)
    return run


def _scripted(case: Incline, route: Route, output: Output) -> Run:
    crests, steps = output.rows("crest", 4), round(output.number("steps"))
    try:
        fate, touching = Fate(output.text("verdict")), TOUCHING[output.text("touching")]
    except (ValueError, KeyError) as error:
        raise EngineOutputError(f"{output.who} left an incomplete result ({error})") from None
    run = Run(
        case,
        fate,
        output.number("margin_J") / case.weight_energy,
        touching,
        output.number("time_s"),
        steps,
        crests[:, 1],
        crests[:, 2] / case.weight_energy,
        output,
    )
    _check_consistent(run, wells_of(case, route), crests[:, 0])
    return run


def _check_consistent(run: Run, wells: int, numbers: Floats) -> None:
    """Raise EngineOutputError for a clock or crests that contradict the rest of the result."""
    who, clock, half_step = run.output.who, run.steps * run.case.step, 0.5 * run.case.step
    count, times = numbers.size, run.crest_times_s
    if abs(run.time_s - clock) > half_step + PRINTED_CLOCK * clock:
        raise EngineOutputError(
            f"{who} took {run.steps} steps of {run.case.step:g} s and printed {run.time_s:g} s"
        )
    expected = count == wells if run.fate is Fate.MOVES_ON else count < wells
    if not expected or list(numbers) != list(range(1, count + 1)) or np.any(np.diff(times) <= 0.0):
        raise EngineOutputError(
            f"{who} printed a grain that is {run.fate} after {count} crests of {wells}"
        )
    if count and times[-1] > run.time_s + half_step:
        raise EngineOutputError(f"{who} passed a crest after the end of its run")
    if run.fate is Fate.MOVES_ON and not (
        run.time_s - times[-1] <= half_step
        and math.isclose(run.margin, run.crest_margins[-1], rel_tol=1e-9)
    ):
        raise EngineOutputError(f"{who} printed another time or energy than at its last crest")


def _judged(case: Incline, route: Route, output: Output) -> Run:
    table = _looks(output, case)
    state = [table[name] for name in COLUMNS[1:]]
    fate, row, margins, passed = _fate(case, route, state)
    time, limit = float(table["time_s"][row]), case.time_limit * case.unit_of_time
    if fate is Fate.UNDECIDED and time < limit * (1.0 - 1e-9) - LOOK * case.step:
        raise EngineOutputError(
            f"{output.who} left a path that ends at {time:g} s, undecided, before the time limit "
            f"of {limit:g} s"
        )
    touching = max(float(overlap[row]) for overlap in overlaps(case, *state[:2])) > 0.0
    return Run(
        case,
        fate,
        float(margins[-1]),
        touching,
        time,
        round(time / case.step),
        table["time_s"][passed],
        margins[: len(passed)],
        output,
    )


def _looks(output: Output, case: Incline) -> Table:
    """Return the states of the grain at which it is judged: at the ends of stages, if known."""
    if STAGES in output.tables:
        return output.table(COLUMNS, name=STAGES)
    path = path_in(output)
    looks = np.rint(path["time_s"] / case.step) % LOOK == 0
    return {name: column[looks] for name, column in path.items()}


def _fate(
    case: Incline, route: Route, state: Sequence[Floats]
) -> tuple[Fate, int, Floats, list[int]]:
    """Return the fate, the row that decides it, margins, and the rows of the crests passed.

    Margins are those at each crest, and at the end unless that is a crest. With friction they have
    1 + beta times the energy of the velocity, as of a grain that rolls. One that slides over the
    crest has no other root, and its margin keeps its slope there.
    """
    x, _, vx, vy = state
    rolling = case.inertia * case.mass / case.weight_energy if case.friction else 0.0
    fate, row, passed, margins = Fate.MOVES_ON, 0, list[int](), list[float]()
    for well in range(1, wells_of(case, route) + 1):
        energies = margin(case, well, state)
        beyond = x > end_of(case, route, well)
        decided = np.flatnonzero((beyond | ((vx < 0.0) & (energies < 0.0)))[row:])
        row = row + int(decided[0]) if decided.size else len(x) - 1
        margins.append(float(energies[row] + 0.5 * rolling * (vx[row] ** 2 + vy[row] ** 2)))
        if not decided.size:
            fate = Fate.UNDECIDED
        elif not beyond[row] or (route == "passage" and margins[-1] < 0.0):
            fate = Fate.TRAPPED
        if fate is not Fate.MOVES_ON:
            break
        passed.append(row)
    return fate, row, np.array(margins), passed


def _check_path(run: Run, every: int) -> None:
    """Raise EngineOutputError for a path that lacks samples."""
    times, who, count = run.path["time_s"], run.output.who, run.steps // every + 1
    if times.size != count:
        raise EngineOutputError(f"{who} left {times.size} rows of a series of {count}")
    if times.size > 2 and np.ptp(np.diff(times)) > 1e-6 * times[-1]:
        raise EngineOutputError(f"{who} left a series with samples missing in between")
