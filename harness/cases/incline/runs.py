"""Runs of the incline: the outcome of a script, or of the ends of stages of a scene.

Contacts only take energy: a grain that moves back with a negative margin is trapped. LAMMPS's
script judges in its own language; the stages of other engines are judged here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.cases.base import COLUMNS
from harness.cases.incline.system import Incline, OverRow, Route, end_of, margin, overlaps, wells_of
from harness.engines.base import Output
from harness.engines.output import STAGES
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


class Ends(NamedTuple):
    """The ends of the stages of a run, one in each well from the first on: each (K,), in SI units.

    ``margin`` [m g d] is the energy over the next crest, ``crest`` the x [m] of that crest; a grain
    ``below`` it, that moves back, is trapped: its energy of translation does not reach the crest.
    """

    margin: Floats
    crest: Floats
    touching: NDArray[np.bool_]
    below: NDArray[np.bool_]


def read(
    case: OverRow, route: Route, output: Output, ends_of: Callable[..., Ends] | None = None
) -> Run:
    """Return the run in an output: judged by its script, else by the ends of its stages.

    ``ends_of`` returns the ends by the case, the route, the numbers of the wells and the states
    x, y [m], vx, vy [m/s] there; those of the incline unless given. Raise EngineOutputError for an
    output that is incomplete or has other settings, EngineNaNError for values that are not finite.
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
    if output.results:
        return _judged_by_script(case, route, output)
    return _judged_by_stages(case, route, output, ends_of or incline_ends)


def _judged_by_script(case: OverRow, route: Route, output: Output) -> Run:
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


def _judged_by_stages(
    case: OverRow, route: Route, output: Output, ends_of: Callable[..., Ends]
) -> Run:
    table = output.table(COLUMNS, name=STAGES)
    time, x, y, vx, vy = (table[name][1:] for name in COLUMNS)
    wells = wells_of(case, route)
    if not 1 <= x.size <= wells:
        raise EngineOutputError(f"{output.engine} left {x.size} ends of stages, of {wells} wells")
    ends = ends_of(case, route, np.arange(1, x.size + 1), (x, y, vx, vy))
    beyond, last = x > ends.crest, float(ends.margin[-1])
    fate = Fate.UNDECIDED
    if beyond[-1] and x.size == wells:
        fate = Fate.TRAPPED if route == "passage" and last < 0.0 else Fate.MOVES_ON
    elif not beyond[-1] and vx[-1] < 0.0 and ends.below[-1]:
        fate = Fate.TRAPPED
    limit = case.time_limit * case.unit_of_time
    if fate is Fate.UNDECIDED and time[-1] < limit * (1.0 - 1e-9) - LOOK * case.step:
        raise EngineOutputError(
            f"{output.engine} left a run that ends at {time[-1]:g} s, undecided, before the time "
            f"limit of {limit:g} s"
        )
    steps, crests = round(time[-1] / case.step), ends.margin[beyond]
    return Run(
        case, fate, last, bool(ends.touching[-1]), float(time[-1]), steps, crests, output
    )  # fmt: skip


def incline_ends(case: Incline, route: Route, well: Floats, state: tuple[Floats, ...]) -> Ends:
    """Return the ends of stages of a grain over the incline's row.

    With friction margins have 1 + beta times the energy of the velocity, as of a grain that rolls.
    One that slides over the crest has no other root, and its margin keeps its slope there.
    """
    x, y, vx, vy = state
    rolling = 0.5 * case.rolling_inertia * case.mass / case.weight_energy * (vx**2 + vy**2)
    touching = np.maximum(*overlaps(case, x, y)) > 0.0
    sliding = margin(case, well, state)
    return Ends(sliding + rolling, end_of(case, route, well), touching, sliding < 0.0)
