"""The outcome of a run: by its script, or by the ends of the stages of its scene.

Contacts only take energy: a grain that moves back with a negative margin is trapped. LAMMPS's
script judges in its own language; the stages of other engines are judged here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from harness.cases.base import COLUMNS
from harness.cases.incline.routes import allowed_margin, end_of, margin, overlaps, wells_of
from harness.cases.incline.system import Floats, OverRow, Route
from harness.engines.base import Output
from harness.engines.output import STAGES
from harness.errors import EngineOutputError
from harness.model.scene import LOOK

TOUCHING = {"0": False, "1": True}


class Fate(StrEnum):
    """The outcome of a run. Cut off by its time limit it is undecided, never trapped."""

    MOVES_ON = "moves_on"
    TRAPPED = "trapped"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Run:
    """One run, judged. Margins [m g d] are those at the end, and at each crest that was passed."""

    case: OverRow
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


def read(case: OverRow, route: Route, output: Output) -> Run:
    """Return the run in an output: judged by its script, else by the ends of its stages.

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
    return (_judged_by_script if output.results else _judged_by_stages)(case, route, output)


def _judged_by_script(case: OverRow, route: Route, output: Output) -> Run:
    crests, wells = output.rows("crest", 4), wells_of(case, route)
    try:
        fate, touching = Fate(output.text("verdict")), TOUCHING[output.text("touching")]
    except (ValueError, KeyError) as error:
        raise EngineOutputError(f"{output.engine} left an incomplete result ({error})") from None
    if len(crests) > wells or (len(crests) == wells) != (fate is Fate.MOVES_ON):
        raise EngineOutputError(
            f"{output.engine} printed a grain that is {fate} after {len(crests)} crests of {wells}"
        )
    energy, time = output.number("margin_J"), output.number("time_s")
    steps, crest_margins = round(output.number("steps")), crests[:, 2] / case.weight_energy
    return Run(
        case, fate, energy / case.weight_energy, touching, time, steps, crest_margins, output
    )


def _judged_by_stages(case: OverRow, route: Route, output: Output) -> Run:
    """Judge the ends of stages, one in each well from the first on.

    With friction margins have 1 + beta times the energy of the velocity, as of a grain that rolls.
    One that slides over the crest has no other root, and its margin keeps its slope there. A grain
    is trapped by its energy of translation.
    """
    table, wells = output.table(COLUMNS, name=STAGES), wells_of(case, route)
    time, x, y, vx, vy = (table[name][1:] for name in COLUMNS)
    if not 1 <= x.size <= wells:
        raise EngineOutputError(f"{output.engine} left {x.size} ends of stages, of {wells} wells")
    well = np.arange(1, x.size + 1)
    sliding = margin(case, well, (x, y, vx, vy))
    rolling = 0.5 * case.rolling_inertia * case.mass * (vx**2 + vy**2) / case.weight_energy
    margins, beyond = sliding + rolling, x > end_of(case, route, well)
    fate = Fate.UNDECIDED
    if beyond[-1] and x.size == wells:
        fate = Fate.TRAPPED if route == "passage" and margins[-1] < 0.0 else Fate.MOVES_ON
    elif not beyond[-1] and vx[-1] < 0.0:
        below = sliding[-1] < allowed_margin(case) / case.weight_energy
        fate = Fate.TRAPPED if below else Fate.UNDECIDED
    limit = case.time_limit * case.unit_of_time
    if fate is Fate.UNDECIDED and time[-1] < limit * (1.0 - 1e-9) - LOOK * case.step:
        raise EngineOutputError(
            f"{output.engine} left a run that ends at {time[-1]:g} s, undecided, before the time "
            f"limit of {limit:g} s"
        )
    touching = bool(max(*overlaps(case, x[-1], y[-1])) > 0.0)
    steps, last = round(time[-1] / case.step), float(margins[-1])
    return Run(case, fate, last, touching, float(time[-1]), steps, margins[beyond], output)
