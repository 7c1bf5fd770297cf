"""Figures of the incline: an angle's runs, its extrapolation, its course over friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.incline.closed_form import angle_or_nan, rigid_angle
from harness.cases.incline.runs import Fate
from harness.report.style import (
    BLACK,
    BLUE,
    COLOURS,
    GREEN,
    MARKERS,
    Figure,
    axis,
    label,
    legend_below,
    panels,
    power,
)
from harness.theory.incline import INERTIA, Shape, rolling_friction

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from harness.cases.incline.angle import ExtrapolatedAngle
    from harness.cases.incline.search import CriticalAngle


def runs_of_an_angle(angle: CriticalAngle) -> Figure:
    """Draw the margin of each run over its angle, in steady motion its fate."""
    figure, frame = panels(1, 1, 6.4, 3.9), angle.to_frame()
    (axes,) = figure.axes
    if angle.method == "passage":
        values, y = frame["margin"], axis("energy over the next crest", "m g d")
        axes.axhline(0.0, color="0.6", lw=0.8)
    else:
        fates = [str(fate) for fate in Fate]
        values, y = frame["motion"].map(fates.index), "fate of the grain"
        axes.set_yticks(range(len(fates)), [fate.replace("_", " ") for fate in fates])
    axes.plot(frame["angle_deg"], values, "o", color=BLUE, mfc="none", label="runs")
    low, high = angle.value - angle.uncertainty, angle.value + angle.uncertainty
    axes.axvspan(low, high, color=GREEN, alpha=0.25, label="uncertainty")
    axes.axvline(angle.value, color=BLACK, ls="--", lw=1, label="critical angle")
    label(axes, axis("tilt", "deg"), y, f"{angle.output.provenance.label}, {angle.method}")
    legend_below(figure, 3)
    return figure


def extrapolation(angle: ExtrapolatedAngle) -> Figure:
    """Draw the critical angle over the step, and its limits over the stiffness."""
    figure = panels(1, 2, 3.8, 3.9)
    over_step, over_stiffness = figure.axes
    for number, (stiffness, limit) in enumerate(angle.at_stiffness.items()):
        colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
        name, fine = f"k = {power(stiffness)} N/m", np.linspace(0.0, limit.h.max(), 50)
        over_step.errorbar(
            limit.h, limit.y, limit.errors, fmt=marker, color=colour, label=name, capsize=2
        )
        over_step.plot(fine, limit.curve(fine), color=colour, lw=0.9)
        over_step.plot(0.0, limit.value, marker, color=colour, mfc="white", clip_on=False)
    over_step.locator_params(axis="x", nbins=5, steps=[1, 2, 5, 10])
    label(over_step, "1 / steps per contact time", "critical angle (deg)", "step to zero")
    _over_stiffness(over_stiffness, angle)
    expected, _ = rigid_angle(angle.angles[0].case)
    for axes in figure.axes:
        axes.axhline(expected, color=BLACK, ls="--", lw=1, label=f"theory {expected:.5f} deg")
    legend_below(figure, 3)
    return figure


def _over_stiffness(axes: Axes, angle: ExtrapolatedAngle) -> None:
    rigid = angle.rigid
    name = f"{angle.angles[0].output.provenance.engine}, step to zero"
    axes.errorbar(1.0 / rigid.h, rigid.y, rigid.errors, fmt="o", color=BLUE, capsize=2, label=name)
    fine = np.geomspace(rigid.h.min() / 30.0, rigid.h.max(), 100)
    order = f"fit, observed order {rigid.order:.2f}"
    axes.plot(1.0 / fine, rigid.curve(fine), color=BLUE, lw=0.9, label=order)
    low, high = rigid.value - rigid.uncertainty, rigid.value + rigid.uncertainty
    text = f"limit {rigid.value:.5f} ± {rigid.uncertainty:.5f} deg"
    axes.axhspan(low, high, color=GREEN, alpha=0.25, label=text)
    axes.set_xscale("log")
    label(axes, "stiffness k (N/m)", "critical angle (deg)", "then stiffness to infinity")


def over_friction(
    points: Mapping[str, Sequence[tuple[float, float]]],
    shape: Shape = "sphere",
    half_angle_deg: float = 30.0,
) -> Figure:
    """Draw the critical angle over friction: theory as a line, (friction, angle [deg]) as points.

    The panel below has the differences from theory.
    """
    figure = Figure(figsize=(7.2, 5.0), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    most = max(mu for series in points.values() for mu, _ in series)
    frictions = np.concatenate([np.linspace(0.0, 0.06, 61), np.linspace(0.065, most, 80)])
    angles = [angle_or_nan(float(mu), shape, half_angle_deg) for mu in frictions]
    top.plot(frictions, angles, color=BLACK, lw=1.2, label="theory, rigid grain")
    for number, (name, series) in enumerate(points.items(), 1):
        look = {"marker": MARKERS[number % 6], "color": COLOURS[number % 7], "mfc": "none"}
        x, y = (np.array(column) for column in zip(*series, strict=True))
        top.plot(x, y, ls="", label=name, **look)
        expected = [angle_or_nan(float(mu), shape, half_angle_deg) for mu in x]
        bottom.plot(x, 1e3 * (y - expected), ls="", **look)
    bottom.axhline(0.0, color=BLACK, lw=1)
    bound = rolling_friction(half_angle_deg, INERTIA[shape])
    if bound <= most:
        top.axvline(bound, color="0.5", ls=":", label=f"rolls without slip from {bound:.4f} on")
    label(top, "", "critical angle (deg)")
    label(bottom, "friction coefficient", "less theory\n(1e-3 deg)")
    legend_below(figure, 3)
    return figure
