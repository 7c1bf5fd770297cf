"""Figure of the critical angles of engines beside one another, with theory."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.cases.incline.engine_angle import EngineAngle
from harness.cases.incline.tolerances import ENGINES_PLASTIC
from harness.report.figures.style import BLACK, BLUE, RED, label, legend_below, power

WIDTH_DEG = ENGINES_PLASTIC.absolute
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
    legend_below(figure, 5)
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
