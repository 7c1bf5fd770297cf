"""The critical angle as a result: at one stiffness and step, and of rigid spheres."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from harness.cases.incline.closed_form import rigid_angle
from harness.cases.incline.runs import Fate, Run
from harness.cases.incline.system import Incline, Route
from harness.engines.output import Provenance
from harness.errors import RequestError
from harness.report.content import Plottable, power, value_text
from harness.theory.incline import sticking_friction

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.figures import Figure

Floats = NDArray[np.float64]
STIFFNESS_EXPONENTS = (1.0, 1.5)
SLIDING_EXPONENTS = (0.5, 1.0)  # of the stiffness, where shocks slide
ORDERS = (0.2, 6.0)  # in which an order is searched


def friction_text(case: Incline) -> str:
    """Return friction, size and shape of a grain in words, empty for a plain one."""
    friction, size = case.friction, case.grain / case.diameter
    words = f", friction {friction:g}" if friction else ""
    words += f", grain of {size:g} d" if case.grain != case.diameter else ""
    return words + (", disc" if friction and case.shape == "disc" else "")


@dataclass(frozen=True, repr=False)
class CriticalAngle(Plottable):
    """A critical angle [deg] at one stiffness and step.

    ``uncertainty`` [deg] is the range of a single start, and of the search. ``mean_error`` [deg]
    bounds the error of the value as a mean over starts within a step. Neither contains the error of
    a finite stiffness or step. ``monotone`` is False where an angle above a moving one was trapped.
    ``runs`` are those of the search: angle [deg], phase, motion, margin [m g d].
    """

    value: float
    uncertainty: float
    mean_error: float
    method: Route
    case: Incline
    provenance: Provenance  # of the last run
    runs: tuple[dict[str, Any], ...] = ()
    monotone: bool = True
    note: str = ""
    steps: int = 0

    @classmethod
    def of(cls, runs: Sequence[Run], case: Incline, method: Route, **values: Any) -> CriticalAngle:
        """Return the critical angle to which some runs led."""
        records = tuple(
            {"angle_deg": run.case.angle, "phase": run.case.phase, "motion": str(run.fate),
             "margin": run.margin} for run in runs
        )  # fmt: skip
        steps, provenance = sum(run.steps for run in runs), runs[-1].output.provenance
        return cls(case=case, method=method, provenance=provenance, runs=records, steps=steps,
                   **values)  # fmt: skip

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
            **asdict(self.provenance),
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
            "engine": self.provenance.label,
            **({"note": self.note} if self.note else {}),
        }

    def draw(self) -> Figure:
        """Draw the margin of each run over its angle, in steady motion its fate."""
        from harness.report import figures as look

        figure, frame = look.panels(1, 1, 6.4, 3.9), self.to_frame()
        (axes,) = figure.axes
        if self.method == "passage":
            values, y = frame["margin"], look.axis("energy over the next crest", "m g d")
            axes.axhline(0.0, color="0.6", lw=0.8)
        else:
            fates = [str(fate) for fate in Fate]
            values, y = frame["motion"].map(fates.index), "fate of the grain"
            axes.set_yticks(range(len(fates)), [fate.replace("_", " ") for fate in fates])
        axes.plot(frame["angle_deg"], values, "o", color=look.BLUE, mfc="none", label="runs")
        axes.axvspan(*_range(self), color=look.GREEN, alpha=0.25, label="uncertainty")
        axes.axvline(self.value, color=look.BLACK, ls="--", lw=1, label="critical angle")
        look.label(axes, "tilt (deg)", y, f"{self.provenance.label}, {self.method}")
        look.legend_below(figure, 3)
        return figure


# ---- step to zero, stiffness to infinity


@dataclass(frozen=True, repr=False)
class ExtrapolatedAngle(Plottable):
    """The critical angle [deg] of rigid spheres from an engine, with the angles behind it.

    ``at_stiffness`` has the limit in the step at each stiffness [N/m], ``rigid`` the limit of
    those in the inverse stiffness.
    """

    value: float
    uncertainty: float
    angles: tuple[CriticalAngle, ...]
    at_stiffness: dict[float, Limit]
    rigid: Limit

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
        return pd.DataFrame([angle.to_json() for angle in self.angles])[[*names]]

    def summary(self) -> dict[str, str]:
        """Return the angle, the contact, the stiffnesses, the expected angle and the engine."""
        first, stiffnesses = self.angles[0], [power(k) for k in self.at_stiffness]
        (expected, model), contact = rigid_angle(first.case), first.case.contact.name
        return {
            "critical angle": value_text(self.value, self.uncertainty, "deg"),
            "case": f"incline, {contact} contact{friction_text(first.case)}, step to zero, then "
            "stiffness to infinity",
            "ladder": f"{len(self.angles)} angles, k = {stiffnesses[0]} to {stiffnesses[-1]} N/m",
            "theory": f"{expected:.5f} deg ({model})",
            "engine": first.provenance.label,
        }

    def draw(self) -> Figure:
        """Draw the critical angle over the step, and its limits over the stiffness."""
        from harness.report import figures as look

        figure, first, rigid = look.panels(1, 2, 3.8, 3.9), self.angles[0], self.rigid
        by_step, by_stiffness = figure.axes
        for number, (stiffness, at) in enumerate(self.at_stiffness.items()):
            colour, marker = look.COLOURS[number % 7], look.MARKERS[number % 6]
            by_step.errorbar(at.h, at.y, at.errors, fmt=marker, color=colour, capsize=2,
                             label=f"k = {power(stiffness)} N/m")  # fmt: skip
            fine = np.linspace(0.0, at.h.max(), 50)
            by_step.plot(fine, at.curve(fine), color=colour, lw=0.9)
            by_step.plot(0.0, at.value, marker, color=colour, mfc="white", clip_on=False)
        by_step.locator_params(axis="x", nbins=5, steps=[1, 2, 5, 10])
        by_stiffness.errorbar(1.0 / rigid.h, rigid.y, rigid.errors, fmt="o", capsize=2,
                              label=f"{first.provenance.engine}, step to zero",
                              color=look.BLUE)  # fmt: skip
        fine = np.geomspace(rigid.h.min() / 30.0, rigid.h.max(), 100)
        by_stiffness.plot(1.0 / fine, rigid.curve(fine), color=look.BLUE, lw=0.9,
                          label=f"fit, observed order {rigid.order:.2f}")  # fmt: skip
        text = f"limit {self.value:.5f} ± {self.uncertainty:.5f} deg"
        by_stiffness.axhspan(*_range(self), color=look.GREEN, alpha=0.25, label=text)
        by_stiffness.set_xscale("log")
        expected, y = rigid_angle(first.case)[0], "critical angle (deg)"
        for axes in figure.axes:
            axes.axhline(expected, color=look.BLACK, ls="--", lw=1,
                         label=f"theory {expected:.5f} deg")  # fmt: skip
        look.label(by_step, "1 / steps per contact time", y, "step to zero")
        look.label(by_stiffness, "stiffness k (N/m)", y, "then stiffness to infinity")
        look.legend_below(figure, 3)
        return figure


def _range(angle: CriticalAngle | ExtrapolatedAngle) -> tuple[float, float]:
    return angle.value - angle.uncertainty, angle.value + angle.uncertainty


def extrapolate(angles: Sequence[CriticalAngle]) -> ExtrapolatedAngle:
    """Return the limit of angles over stiffnesses and steps.

    Raise RequestError for fewer than three steps at a stiffness or fewer than four stiffnesses.
    """

    def limit_of(points: Iterable[tuple[float, float, float]], *exponents: float) -> Limit:
        h, values, errors = zip(*points, strict=True)
        return limit(h, values, errors, exponents)

    ordered = sorted(angles, key=lambda a: (a.case.stiffness, a.case.steps_per_contact))
    at_stiffness = {
        k: limit_of(((1.0 / a.case.steps_per_contact, a.value, a.mean_error) for a in group), 1.0)
        for k, group in groupby(ordered, key=lambda a: a.case.stiffness)
    }
    case = angles[0].case
    sticks = sticking_friction(math.degrees(case.half_angle), case.inertia)
    exponents = SLIDING_EXPONENTS if 0.0 < case.friction < sticks else STIFFNESS_EXPONENTS
    limits = ((1.0 / k, at.value, at.uncertainty) for k, at in at_stiffness.items())
    rigid = limit_of(limits, *exponents)
    return ExtrapolatedAngle(rigid.value, rigid.uncertainty, tuple(ordered), at_stiffness, rigid)


# ---- the limit of a series, with its order


@dataclass(frozen=True)
class Limit:
    """The limit of y(h) at h -> 0, with the points and the fit behind it.

    ``uncertainty`` adds the errors of the points, passed on by the fit, and the distance between
    two models: known exponents, and one free order. ``order`` is that free order.
    """

    value: float
    uncertainty: float
    order: float
    order_interval: tuple[float, float]
    h: Floats
    y: Floats
    errors: Floats
    coefficients: Floats
    exponents: Floats

    def curve(self, h: ArrayLike) -> Floats:
        """Return the fitted y at h, in the shape of h."""
        powers = np.asarray(h, dtype=float)[..., None] ** self.exponents
        return np.asarray(self.value + powers @ self.coefficients)


def limit(
    h: ArrayLike, y: ArrayLike, errors: ArrayLike, exponents: Sequence[float] = (1.0,)
) -> Limit:
    """Return the limit of y at h -> 0 from y = L + sum_j c_j h^p_j with known exponents p_j.

    ``h``, ``y`` and ``errors`` (bounds of the error of each y, positive) have the shape (points,).
    Raise RequestError for fewer points than exponents and two.
    """
    h, y, errors = (np.asarray(column, dtype=float) for column in (h, y, errors))
    if len(h) < len(exponents) + 2:
        raise RequestError(
            f"an extrapolation with {len(exponents)} terms needs at least {len(exponents) + 2} "
            f"points, not {len(h)}"
        )
    powers = np.asarray(exponents, dtype=float)
    coefficients, spread = _fit(h, y, errors, powers)
    order, interval = _observed_order(h, y, errors)
    free, _ = _fit(h, y, errors, np.array([order]))
    uncertainty = float(spread + abs(free[0] - coefficients[0]))
    return Limit(float(coefficients[0]), uncertainty, order, interval, h, y, errors,
                 coefficients[1:], powers)  # fmt: skip


def _fit(h: Floats, y: Floats, errors: Floats, powers: Floats) -> tuple[Floats, float]:
    """Return (L, c_1, ...) by weighted least squares, and the bound of the error of L.

    Errors are bounds of a systematic jitter and no standard deviations: they add up in modulus.
    """
    columns = np.column_stack([np.ones_like(h), *(h**p for p in powers)])
    inverse = np.linalg.pinv(columns / errors[:, None]) / errors[None, :]
    return inverse @ y, float(np.abs(inverse[0]) @ errors)


def _observed_order(h: Floats, y: Floats, errors: Floats) -> tuple[float, tuple[float, float]]:
    """Return the order that fits best, and the interval of orders that the errors allow.

    An allowed order misses no point by more than its error, or than the best order does.
    """
    weights = errors**-2 / np.sum(errors**-2)
    level = y @ weights

    def misses(orders: Floats) -> Floats:
        powers = h ** orders[:, None]  # straight lines in h^order, by their centre
        x = powers - (powers @ weights)[:, None]
        slope = ((x * y) @ weights) / ((x * x) @ weights)
        return np.asarray((level + slope[:, None] * x - y) / errors)

    best = minimize_scalar(
        lambda order: float(np.sum(misses(np.array([order])) ** 2)),
        bounds=ORDERS,
        method="bounded",
        options={"xatol": 1e-10},
    )
    order = float(best.x)
    allowed = max(1.0, float(np.abs(misses(np.array([order]))).max()))
    grid = np.linspace(*ORDERS, 400)
    inside = [float(p) for p in grid[np.abs(misses(grid)).max(axis=1) <= allowed]]
    return order, (min([order, *inside]), max([order, *inside]))
