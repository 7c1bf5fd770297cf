"""What a run, a search and an extrapolation of the incline return.

A run is judged by a script or by the ends of stages of a scene. Contacts only take energy: a grain
that moves back with a negative margin is trapped. LAMMPS's script judges in its own language; the
stages of other engines are judged here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.cases.base import COLUMNS
from harness.cases.incline.closed_form import rigid_angle
from harness.cases.incline.system import (
    Incline,
    OverRow,
    Route,
    end_of,
    friction_text,
    margin,
    overlaps,
    wells_of,
)
from harness.engines.base import Output
from harness.engines.output import STAGES
from harness.errors import EngineOutputError
from harness.model.scene import LOOK
from harness.report.content import Plottable, power, value_text
from harness.results.series import Limit, limit
from harness.theory.incline import sticking_friction

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from harness.report.figures import Figure

Floats = NDArray[np.float64]
TOUCHING = {"0": False, "1": True}
STEP_EXPONENTS, STIFFNESS_EXPONENTS = (1.0,), (1.0, 1.5)
SLIDING_EXPONENTS = (0.5, 1.0)  # of the stiffness, where shocks slide


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


# ---- the critical angle at one stiffness and step


@dataclass(frozen=True, repr=False)
class CriticalAngle(Plottable):
    """A critical angle [deg] at one stiffness and step.

    ``uncertainty`` [deg] is the range of a single start, and of the search. ``mean_error`` [deg] is
    the error of the value as a mean over starts within a step. Neither contains the error of a
    finite stiffness or step. ``monotone`` is False where an angle above a moving one was trapped.
    ``runs`` are those of the search: angle [deg], phase, motion, margin [m g d].
    """

    value: float
    uncertainty: float
    mean_error: float
    method: Route
    case: Incline
    output: Output = field(repr=False)  # of the last run
    runs: tuple[dict[str, Any], ...] = ()
    monotone: bool = True
    note: str = ""
    steps: int = 0

    def to_json(self) -> dict[str, Any]:
        """Return the result, JSON-ready, SI units and degrees in the keys."""
        case = self.case
        friction = {"friction": case.friction, "grain_diameter_m": case.grain, "shape": case.shape}
        return {
            "critical_angle_deg": self.value,
            "uncertainty_deg": self.uncertainty,
            "method": self.method,
            "stiffness_N_per_m": case.stiffness,
            "steps_per_contact": case.steps_per_contact,
            "contact": case.contact.name,
            "restitution": case.contact.restitution,
            "damping_ratio": case.contact.zeta,
            "tail": case.contact.tail,
            "effective_mass": case.contact.effective_mass,
            "diameter_m": case.diameter,
            "density_kg_per_m3": case.density,
            "gravity_m_per_s2": case.gravity,
            **({} if case.is_plain else friction),
            **({"wells": case.wells} if self.method == "steady" else {}),
            "monotone": self.monotone,
            "note": self.note,
            "runs": len(self.runs),
            "steps": self.steps,
            **asdict(self.output.provenance),
        }

    def to_frame(self) -> pd.DataFrame:
        """Return the runs behind the value as a table, sorted by angle."""
        import pandas as pd

        return pd.DataFrame(self.runs).sort_values("angle_deg")

    def summary(self) -> dict[str, str]:
        """Return the angle, the case and what measured it."""
        case = self.case
        return {
            "critical angle": value_text(self.value, self.uncertainty, "deg"),
            "case": f"incline, {case.contact.name} contact, k = {power(case.stiffness)} N/m, "
            f"{case.steps_per_contact:g} steps per contact time{friction_text(case)}",
            "method": f"{self.method}, {len(self.runs)} runs",
            "engine": self.output.provenance.label,
            **({"note": self.note} if self.note else {}),
        }

    def draw(self) -> Figure:
        """Draw the margin of each run over its angle, in steady motion its fate."""
        from harness.report.figures import BLACK, BLUE, GREEN, axis, label, legend_below, panels

        figure, frame = panels(1, 1, 6.4, 3.9), self.to_frame()
        (axes,) = figure.axes
        if self.method == "passage":
            values, y = frame["margin"], axis("energy over the next crest", "m g d")
            axes.axhline(0.0, color="0.6", lw=0.8)
        else:
            fates = [str(fate) for fate in Fate]
            values, y = frame["motion"].map(fates.index), "fate of the grain"
            axes.set_yticks(range(len(fates)), [fate.replace("_", " ") for fate in fates])
        axes.plot(frame["angle_deg"], values, "o", color=BLUE, mfc="none", label="runs")
        low, high = self.value - self.uncertainty, self.value + self.uncertainty
        axes.axvspan(low, high, color=GREEN, alpha=0.25, label="uncertainty")
        axes.axvline(self.value, color=BLACK, ls="--", lw=1, label="critical angle")
        label(axes, axis("tilt", "deg"), y, f"{self.output.provenance.label}, {self.method}")
        legend_below(figure, 3)
        return figure


# ---- step to zero, stiffness to infinity


@dataclass(frozen=True, repr=False)
class ExtrapolatedAngle(Plottable):
    """The critical angle of rigid spheres from an engine, with the angles behind it.

    ``at_stiffness`` has the limit in the step at each stiffness [N/m], ``rigid`` the limit of
    those in the inverse stiffness.
    """

    angles: tuple[CriticalAngle, ...]
    at_stiffness: dict[float, Limit]
    rigid: Limit

    @property
    def value(self) -> float:
        """Return the extrapolated critical angle [deg]."""
        return self.rigid.value

    @property
    def uncertainty(self) -> float:
        """Return its uncertainty [deg]."""
        return self.rigid.uncertainty

    def to_json(self) -> dict[str, Any]:
        """Return the result, JSON-ready; stiffness and step are null: extrapolated."""
        return {
            **self.angles[0].to_json(),
            "critical_angle_deg": self.value,
            "uncertainty_deg": self.uncertainty,
            "extrapolated": True,
            "stiffness_N_per_m": None,
            "steps_per_contact": None,
            "runs": sum(len(angle.runs) for angle in self.angles),
            "steps": sum(angle.steps for angle in self.angles),
            "order_in_stiffness": self.rigid.order,
            "order_in_stiffness_interval": list(self.rigid.order_interval),
            "limits": [
                {
                    "stiffness_N_per_m": stiffness,
                    "critical_angle_deg": at.value,
                    "uncertainty_deg": at.uncertainty,
                    "order_in_step": at.order,
                    "order_in_step_interval": list(at.order_interval),
                }
                for stiffness, at in self.at_stiffness.items()
            ],
            "ladder": self.to_frame().to_dict(orient="records"),
        }

    def to_frame(self) -> pd.DataFrame:
        """Return the angles as a table: stiffness, steps per contact, angle, uncertainty."""
        import pandas as pd

        names = ("stiffness_N_per_m", "steps_per_contact", "critical_angle_deg", "uncertainty_deg")
        return pd.DataFrame([{name: a.to_json()[name] for name in names} for a in self.angles])

    def summary(self) -> dict[str, str]:
        """Return the angle, the contact, the stiffnesses, the expected angle and the engine."""
        first, stiffnesses = self.angles[0], [*self.at_stiffness]
        expected, model = rigid_angle(first.case)
        return {
            "critical angle": value_text(self.value, self.uncertainty, "deg"),
            "case": f"incline, {first.case.contact.name} contact{friction_text(first.case)}, step "
            "to zero, then stiffness to infinity",
            "ladder": f"{len(self.angles)} angles, k = {power(min(stiffnesses))} to "
            f"{power(max(stiffnesses))} N/m",
            "theory": f"{expected:.5f} deg ({model})",
            "engine": first.output.provenance.label,
        }

    def draw(self) -> Figure:
        """Draw the critical angle over the step, and its limits over the stiffness."""
        from harness.report.figures import BLACK, COLOURS, MARKERS, label, legend_below, panels

        figure = panels(1, 2, 3.8, 3.9)
        over_step, over_stiffness = figure.axes
        for number, (stiffness, at) in enumerate(self.at_stiffness.items()):
            colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
            name, fine = f"k = {power(stiffness)} N/m", np.linspace(0.0, at.h.max(), 50)
            over_step.errorbar(
                at.h, at.y, at.errors, fmt=marker, color=colour, label=name, capsize=2
            )
            over_step.plot(fine, at.curve(fine), color=colour, lw=0.9)
            over_step.plot(0.0, at.value, marker, color=colour, mfc="white", clip_on=False)
        over_step.locator_params(axis="x", nbins=5, steps=[1, 2, 5, 10])
        label(over_step, "1 / steps per contact time", "critical angle (deg)", "step to zero")
        self._draw_over_stiffness(over_stiffness)
        expected, _ = rigid_angle(self.angles[0].case)
        for axes in figure.axes:
            axes.axhline(expected, color=BLACK, ls="--", lw=1, label=f"theory {expected:.5f} deg")
        legend_below(figure, 3)
        return figure

    def _draw_over_stiffness(self, axes: Axes) -> None:
        from harness.report.figures import BLUE, GREEN, label

        rigid = self.rigid
        name = f"{self.angles[0].output.provenance.engine}, step to zero"
        axes.errorbar(
            1.0 / rigid.h, rigid.y, rigid.errors, fmt="o", color=BLUE, capsize=2, label=name
        )
        fine = np.geomspace(rigid.h.min() / 30.0, rigid.h.max(), 100)
        order = f"fit, observed order {rigid.order:.2f}"
        axes.plot(1.0 / fine, rigid.curve(fine), color=BLUE, lw=0.9, label=order)
        low, high = rigid.value - rigid.uncertainty, rigid.value + rigid.uncertainty
        text = f"limit {rigid.value:.5f} ± {rigid.uncertainty:.5f} deg"
        axes.axhspan(low, high, color=GREEN, alpha=0.25, label=text)
        axes.set_xscale("log")
        label(axes, "stiffness k (N/m)", "critical angle (deg)", "then stiffness to infinity")


def extrapolate(angles: Sequence[CriticalAngle]) -> ExtrapolatedAngle:
    """Return the limit of angles over stiffnesses and steps.

    Raise RequestError for fewer than three steps at a stiffness or fewer than four stiffnesses.
    """

    def stiffness(angle: CriticalAngle) -> float:
        return angle.case.stiffness

    def step_limit(group: Sequence[CriticalAngle]) -> Limit:
        steps = [1.0 / angle.case.steps_per_contact for angle in group]
        values, errors = [a.value for a in group], [a.mean_error for a in group]
        return limit(steps, values, errors, STEP_EXPONENTS)

    ordered = sorted(angles, key=lambda a: (stiffness(a), a.case.steps_per_contact))
    limits = {k: step_limit(list(group)) for k, group in groupby(ordered, key=stiffness)}
    values = [at.value for at in limits.values()]
    errors = [at.uncertainty for at in limits.values()]
    exponents = SLIDING_EXPONENTS if _shocks_slide(angles[0].case) else STIFFNESS_EXPONENTS
    rigid = limit([1.0 / k for k in limits], values, errors, exponents)
    return ExtrapolatedAngle(tuple(ordered), limits, rigid)


def _shocks_slide(case: Incline) -> bool:
    """Return whether the friction of a case is too small for the shock of a rolling grain."""
    half = math.degrees(case.half_angle)
    return 0.0 < case.friction < sticking_friction(half, case.inertia)
