"""Figures of engines beside one another: critical angles with theory, tower errors with slopes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.cases.tower.step_convergence import StepConvergence
from harness.comparison.engine_evidence import EngineAngle
from harness.report.figures.style import (
    BLACK,
    BLUE,
    COLOURS,
    MARKERS,
    RED,
    STYLES,
    label,
    power,
)

WIDTH_DEG = 0.003
"""Half the shaded band: what the plastic contact may be off the closed form."""

LOOKS = {"clipped": (BLUE, "o"), "attractive": (RED, "s")}
"""Colour and marker of a tail."""


def angles_of_engines(angles: Sequence[EngineAngle], closed_form: float) -> Figure:
    """Draw one row for each engine and contact: its angle, the reference's, and theory.

    All at the stiffness of the first angle, and at its step but for recorded ones. Left all of
    them; right those near the closed form, whose band can be seen there.
    """
    angles = _comparable(angles)
    figure = Figure(figsize=(9.6, 1.5 + 0.34 * len(angles)), layout="constrained")
    whole, near = figure.subplots(1, 2, sharey=True, width_ratios=(1.15, 1))
    for axes in (whole, near):
        axes.axvspan(
            closed_form - WIDTH_DEG,
            closed_form + WIDTH_DEG,
            color="0.82",
            label=f"± {WIDTH_DEG:g} deg",
        )
        axes.axvline(closed_form, color=BLACK, ls="--", lw=1, label="closed form")
        _rows(axes, angles)
        axes.grid(visible=True, axis="x", alpha=0.4)
    whole.set_yticks(range(len(angles)), [_row_name(angle) for angle in angles])
    whole.invert_yaxis()
    first = angles[0]
    at = f"k = {power(first.stiffness)} N/m, {first.steps_per_contact:.3g} steps per contact"
    label(whole, "critical angle (deg)", "", at)
    label(near, "off the closed form (1e-3 deg)", "", "near the closed form")
    span = 3.0 * WIDTH_DEG
    near.set_xlim(closed_form - span, closed_form + span)
    ticks = np.array([-9, -6, -3, 0, 3, 6, 9])
    near.set_xticks(closed_form + 1e-3 * ticks, [f"{tick:+d}" if tick else "0" for tick in ticks])
    _beyond(near, angles, closed_form, span)
    handles, labels = whole.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(
        unique.values(), unique.keys(), loc="outside lower center", ncols=min(5, len(unique))
    )
    return figure


def _comparable(angles: Sequence[EngineAngle]) -> list[EngineAngle]:
    """Return the angles at the first one's stiffness and step, contact by contact."""
    first = angles[0]
    chosen = [
        a
        for a in angles
        if a.stiffness == first.stiffness
        and (a.recorded or a.steps_per_contact == first.steps_per_contact)
    ]
    contacts = list(dict.fromkeys(a.contact for a in chosen))
    return sorted(chosen, key=lambda a: contacts.index(a.contact))


def _rows(axes: Axes, angles: Sequence[EngineAngle]) -> None:
    for row, angle in enumerate(angles):
        colour, marker = LOOKS[angle.rules.tail]
        if not math.isnan(angle.reference_deg):
            axes.plot(
                angle.reference_deg,
                row,
                "D",
                ms=10,
                mfc="none",
                mec=BLACK,
                mew=0.9,
                zorder=2,
                label="reference DEM, same rules",
            )
        axes.errorbar(
            angle.value_deg,
            row,
            xerr=angle.uncertainty_deg,
            fmt=marker,
            color=colour,
            ms=5,
            capsize=3,
            zorder=3,
            label=f"engine, {angle.rules.tail} tail",
        )


def _beyond(axes: Axes, angles: Sequence[EngineAngle], closed_form: float, span: float) -> None:
    """Say at the edge where an angle is that the narrow panel does not hold."""
    for row, angle in enumerate(angles):
        off = angle.value_deg - closed_form
        if abs(off) > span:
            right = off > 0
            axes.annotate(
                f"{1e3 * off:+.0f} →" if right else f"← {1e3 * off:+.0f}",
                (closed_form + math.copysign(0.97 * span, off), row),
                ha="right" if right else "left",
                va="center",
                fontsize=8.5,
                color="0.25",
            )


def _row_name(angle: EngineAngle) -> str:
    steps = f", {angle.steps_per_contact:.3g} steps" if angle.recorded else ""
    return f"{angle.engine}: {angle.contact}{steps}"


def tower_error_against_step(convergences: Sequence[StepConvergence]) -> Figure:
    """Draw the force error of each engine's tower against its step, with guides to the slopes."""
    figure = Figure(figsize=(6.4, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for i, found in enumerate(convergences):
        order = found.l2_order.value
        told = "" if math.isnan(order) else f", order {order:.2f}"
        axes.loglog(
            found.steps_per_contact,
            found.l2_error,
            color=COLOURS[i % 7],
            marker=MARKERS[i % 6],
            ls=STYLES[i % 6],
            ms=8 - min(i, 4),
            lw=1.1,
            mfc="none" if i % 2 else None,
            label=f"{found.solver}{told}",
        )
    steps = np.unique(np.concatenate([found.steps_per_contact for found in convergences]))
    for slope in (1, 2):
        _guide(axes, steps, slope, convergences)
    label(axes, "steps per contact", "L2 error of the grain's force over its peak")
    axes.set_title(_of_tower(convergences[0]), fontsize="medium")
    axes.set_xticks(steps[:: max(1, len(steps) // 5)], minor=False)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:.0f}")
    axes.minorticks_off()
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    return figure


def _guide(
    axes: Axes, steps: np.ndarray, slope: int, convergences: Sequence[StepConvergence]
) -> None:
    """Draw a line of a slope, above all errors at the coarsest step."""
    top = 1.6 * max(float(found.l2_error[0]) for found in convergences)
    line = top * (steps / steps[0]) ** -slope
    axes.loglog(steps, line, color="0.45", ls=(0, (1, 2)), lw=1.2)
    axes.annotate(
        f"slope {slope}",
        (steps[-2], line[-2]),
        ha="center",
        va="center",
        fontsize=9,
        color="0.3",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
    )


def _of_tower(found: StepConvergence) -> str:
    tower = found.reference.tower
    return f"tower, n = {tower.height}, {tower.law} law, k = {power(tower.stiffness)} N/m"
