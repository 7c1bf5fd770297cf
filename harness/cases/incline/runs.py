"""Runs of the incline: the outcome of a script or of a path.

Contacts only take energy: a grain that moves back with a negative margin is trapped. LAMMPS's
script judges in its own language; the paths of other engines are judged here, at the looks that
their stages leave or every ``LOOK`` steps.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.system import Incline, Route, end_of, margin, overlaps, wells_of
from harness.cases.plane import COLUMNS, path_in
from harness.engines.base import Output
from harness.engines.output import Table
from harness.engines.scene_tables import STAGES
from harness.errors import EngineOutputError
from harness.model.scene import LOOK

Floats = NDArray[np.float64]
TOUCHING = {"0": False, "1": True}


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
    crest_margins: Floats
    output: Output = field(repr=False)

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


def read(case: Incline, route: Route, output: Output) -> Run:
    """Return the run in an output: judged by its script, else by its path.

    Raise EngineOutputError for an output that is incomplete or has other settings, EngineNaNError
    for values that are not finite.
    """
    if output.has("route") and output.text("route") != route:
        raise EngineOutputError(f"{output.engine} ran another route than {route!r}")
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
    return (_judged_by_script if output.results else _judged_by_path)(case, route, output)


def _judged_by_script(case: Incline, route: Route, output: Output) -> Run:
    crests = output.rows("crest", 4)
    try:
        fate, touching = Fate(output.text("verdict")), TOUCHING[output.text("touching")]
    except (ValueError, KeyError) as error:
        raise EngineOutputError(f"{output.engine} left an incomplete result ({error})") from None
    passed, wells = len(crests), wells_of(case, route)
    if passed > wells or (passed == wells) != (fate is Fate.MOVES_ON):
        raise EngineOutputError(
            f"{output.engine} printed a grain that is {fate} after {passed} crests of {wells}"
        )
    return Run(
        case,
        fate,
        output.number("margin_J") / case.weight_energy,
        touching,
        output.number("time_s"),
        round(output.number("steps")),
        crests[:, 2] / case.weight_energy,
        output,
    )


def _judged_by_path(case: Incline, route: Route, output: Output) -> Run:
    """Return the run of a path.

    With friction margins have 1 + beta times the energy of the velocity, as of a grain that rolls.
    One that slides over the crest has no other root, and its margin keeps its slope there.
    """
    looks = _looks(output, case)
    x, y, vx, vy = state = [looks[name] for name in COLUMNS[1:]]
    rolling = 0.5 * case.rolling_inertia * case.mass / case.weight_energy * (vx**2 + vy**2)
    fate, row, last, passed = Fate.MOVES_ON, 0, 0.0, list[float]()
    for well in range(1, wells_of(case, route) + 1):
        margins = margin(case, well, state)
        beyond = x > end_of(case, route, well)
        decided = np.flatnonzero((beyond | ((vx < 0.0) & (margins < 0.0)))[row:])
        row = row + int(decided[0]) if decided.size else len(x) - 1
        last = float(margins[row] + rolling[row])
        if not decided.size:
            fate = Fate.UNDECIDED
        elif not beyond[row] or (route == "passage" and last < 0.0):
            fate = Fate.TRAPPED
        if fate is not Fate.MOVES_ON:
            break
        passed.append(last)
    time, limit = float(looks["time_s"][row]), case.time_limit * case.unit_of_time
    if fate is Fate.UNDECIDED and time < limit * (1.0 - 1e-9) - LOOK * case.step:
        raise EngineOutputError(
            f"{output.engine} left a path that ends at {time:g} s, undecided, before the time "
            f"limit of {limit:g} s"
        )
    touching = max(float(overlap[row]) for overlap in overlaps(case, x, y)) > 0.0
    steps = round(time / case.step)
    return Run(case, fate, last, touching, time, steps, np.array(passed), output)


def _looks(output: Output, case: Incline) -> Table:
    """Return the states of the grain at which it is judged: at the ends of stages, if there are."""
    if STAGES in output.tables:
        return output.table(COLUMNS, name=STAGES)
    path = path_in(output)
    looks = np.rint(path["time_s"] / case.step) % LOOK == 0
    return {name: column[looks] for name, column in path.items()}
