"""Figures of the incline: an angle's runs, its extrapolation, its course over friction, a path."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from harness.cases.incline.closed_form import angle_or_nan, rigid_angle
from harness.cases.incline.runs import Fate, Run
from harness.report.style import (
    BLACK,
    BLUE,
    COLOURS,
    GREEN,
    MARKERS,
    ORANGE,
    RED,
    Figure,
    axis,
    label,
    legend_below,
    panels,
    power,
)
from harness.theory import incline_friction
from harness.theory.incline_friction import INERTIA, Shape

if TYPE_CHECKING:
    from harness.cases.incline.extrapolation import ExtrapolatedAngle
    from harness.cases.incline.search import CriticalAngle

ANGLE = axis("critical angle", "deg")
FATES = {Fate.MOVES_ON: "moves on", Fate.TRAPPED: "trapped", Fate.UNDECIDED: "undecided"}
Points = Mapping[str, Sequence[tuple[float, float]]]  # (friction, angle [deg]) by series


def runs_of_an_angle(angle: CriticalAngle) -> Figure:
    """Draw the margin of each run over its angle, in steady motion its fate."""
    figure = panels(1, 1, 6.4, 3.9)
    (axes,) = figure.axes
    angles = [run.angle_deg for run in angle.runs]
    if angle.method == "passage":
        values, y = [run.margin for run in angle.runs], axis("energy over the next crest", "m g d")
        axes.axhline(0.0, color="0.6", lw=0.8)
    else:
        kinds = [*FATES]
        values, y = [kinds.index(Fate(run.motion)) for run in angle.runs], "fate of the grain"
        axes.set_yticks(range(len(kinds)), [*FATES.values()])
    axes.plot(angles, values, "o", color=BLUE, mfc="none", label="runs")
    low, high = angle.value - angle.uncertainty, angle.value + angle.uncertainty
    axes.axvspan(low, high, color=GREEN, alpha=0.25, label="uncertainty")
    axes.axvline(angle.value, color=BLACK, ls="--", lw=1, label="critical angle")
    label(axes, axis("tilt", "deg"), y, f"{angle.output.provenance.label}, {angle.method}")
    legend_below(figure, 3)
    return figure


def extrapolation(found: ExtrapolatedAngle) -> Figure:
    """Draw the critical angle over the step, and its limits over the stiffness."""
    figure = panels(1, 2, 3.8, 3.9)
    over_step, over_stiffness = figure.axes
    for number, (stiffness, limit) in enumerate(found.at_stiffness.items()):
        colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
        name = f"k = {power(stiffness)} N/m"
        over_step.errorbar(
            limit.h, limit.y, limit.errors, fmt=marker, color=colour, label=name, capsize=2
        )
        fine = np.linspace(0.0, limit.h.max(), 50)
        over_step.plot(fine, limit.curve(fine), color=colour, lw=0.9)
        over_step.plot(0.0, limit.value, marker, color=colour, mfc="white", clip_on=False)
    over_step.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    label(over_step, "1 / steps per contact time", ANGLE, "step to zero")
    _over_stiffness(over_stiffness, found)
    expected, _ = rigid_angle(found.angles[0].case)
    for axes in figure.axes:
        axes.axhline(expected, color=BLACK, ls="--", lw=1, label=f"theory {expected:.5f} deg")
    legend_below(figure, 3)
    return figure


def _over_stiffness(axes: Axes, found: ExtrapolatedAngle) -> None:
    rigid = found.rigid
    name = f"{found.angles[0].output.provenance.engine}, step to zero"
    axes.errorbar(1.0 / rigid.h, rigid.y, rigid.errors, fmt="o", color=BLUE, capsize=2, label=name)
    fine = np.geomspace(rigid.h.min() / 30.0, rigid.h.max(), 100)
    order = f"fit, observed order {rigid.order:.2f}"
    axes.plot(1.0 / fine, rigid.curve(fine), color=BLUE, lw=0.9, label=order)
    low, high = rigid.value - rigid.uncertainty, rigid.value + rigid.uncertainty
    text = f"limit {rigid.value:.5f} ± {rigid.uncertainty:.5f} deg"
    axes.axhspan(low, high, color=GREEN, alpha=0.25, label=text)
    axes.set_xscale("log")
    label(axes, axis("stiffness k", "N/m"), ANGLE, "then stiffness to infinity")


def over_friction(points: Points, shape: Shape = "sphere", half_angle_deg: float = 30.0) -> Figure:
    """Draw the critical angle over friction: theory as a line, measured angles as points.

    The panel below has the differences from theory.
    """
    figure = Figure(figsize=(7.2, 5.0), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    most = max(mu for series in points.values() for mu, _ in series)
    frictions = np.concatenate([np.linspace(0.0, 0.06, 61), np.linspace(0.065, most, 80)])
    angles = [angle_or_nan(float(mu), shape, half_angle_deg) for mu in frictions]
    top.plot(frictions, angles, color=BLACK, lw=1.2, label="theory, rigid grain")
    for number, (name, series) in enumerate(points.items()):
        look = {"marker": MARKERS[number], "color": (BLUE, RED, ORANGE, GREEN)[number % 4]}
        x, y = (np.array(column) for column in zip(*series, strict=True))
        top.plot(x, y, ls="", mfc="none", label=name, **look)
        expected = [angle_or_nan(float(mu), shape, half_angle_deg) for mu in x]
        bottom.plot(x, 1e3 * (y - expected), ls="", mfc="none", **look)
    bottom.axhline(0.0, color=BLACK, lw=1)
    bound = incline_friction.rolling_friction(half_angle_deg, INERTIA[shape])
    if bound <= most:
        text = f"rolls without slip from {bound:.4f} on"
        top.axvline(bound, color="0.5", ls=":", label=text)
    label(top, "", ANGLE)
    label(bottom, "friction coefficient", axis("less theory\n", "1e-3 deg"))
    legend_below(figure, 3)
    return figure


def path_over_the_bumps(runs: Mapping[str, Run]) -> Figure:
    """Draw paths of the grain's centre over the row, which is drawn level, gravity tilted."""
    figure = panels(1, len(runs), 7.6 / len(runs), 3.0)
    for axes, (name, run) in zip(figure.axes, runs.items(), strict=True):
        case, path = run.case, run.path
        for place in range(-1, 3):
            axes.add_patch(Circle((place, 0), 0.5, facecolor="#e8e8e8", edgecolor="#888888"))
        x, y = (path[column] / case.diameter for column in ("x_m", "y_m"))
        axes.plot(x, y, color=BLUE, lw=1.4)
        axes.add_patch(
            Circle((x[-1], y[-1]), 0.5 * case.grain / case.diameter, fill=False, ec=BLUE)
        )
        tilt = math.radians(case.angle)
        axes.annotate(
            "",
            (-0.3 + 0.4 * math.sin(tilt), 1.7 - 0.4 * math.cos(tilt)),
            xytext=(-0.3, 1.7),
            arrowprops={"arrowstyle": "-|>", "color": BLACK},
        )
        axes.text(-0.38, 1.5, "g", ha="right", style="italic")
        axes.set(xlim=(-0.8, 1.9), ylim=(-0.2, 1.8), aspect="equal")
        label(axes, axis("along the row", "d"), axis("above it", "d"), name)
        axes.grid(visible=False)
    return figure
