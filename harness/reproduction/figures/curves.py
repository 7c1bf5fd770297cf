"""Figures over height, stiffness and time that no verification has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.cases.tower.evidence import Curve
from harness.cases.tower.figures.impulse import draw_others
from harness.cases.tower.figures.peak_error import draw_against_stiffness
from harness.observables.reference import PublishedAngle, ReferencePoints
from harness.report.figures.style import BLUE, ORANGE, label, legend_below, panels
from harness.reproduction.figure_data.velocity_series import VelocitySeries

_LAWS: dict[str, tuple[str, str]] = {"deformable": (BLUE, "o"), "overlap": (ORANGE, "s")}
_ANGLE = "critical angle (deg)"


def thin_layers(published: PublishedAngle, reference: ReferencePoints | None) -> Figure:
    """Draw what others found, against height: a published angle, and points that a user gave."""
    figure = Figure(figsize=(7.6, 4.0))
    axes = figure.add_subplot()
    draw_others(axes, published, reference)
    axes.set(xlabel="height h/d", ylabel=_ANGLE, ylim=(0, 12))
    axes.set_xlim(0, 1.05 * max((20.0, *(reference.heights if reference else ()))))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if reference is None:
        axes.text(
            0.5, 0.75, "no measured points: they are not published with the source",
            transform=axes.transAxes, ha="center", color="0.3",
        )  # fmt: skip
    else:
        axes.set_ylim(top=max(12.0, 1.1 * max(reference.angles_deg)))
    legend_below(figure, 1)
    return figure


def structure_window(
    frame: pd.DataFrame, published: PublishedAngle, reference: ReferencePoints | None
) -> Figure:
    """Draw the critical angle of the structure window: filled as printed, open read loosely."""
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.add_subplot()
    held = list(frame["held"].unique())
    for (law, reading), part in frame.groupby(["law", "held"], sort=False):
        colour, marker = _LAWS[str(law)]
        literal = reading == held[0]
        look: dict[str, Any] = {"ms": 7} if literal else {"ms": 12, "mfc": "none", "ls": "--"}
        exists = part.dropna()
        axes.plot(
            exists["height"], exists["critical_angle_lost_deg"], marker=marker, color=colour,
            lw=1.2, label=f"{law} law, exact: {reading} held", **look,
        )  # fmt: skip
    draw_others(axes, published, reference)
    heights = sorted(frame["height"].unique())
    axes.set(xlabel="height n (contacts)", ylabel=_ANGLE, ylim=(0, 11.5), xticks=heights)
    axes.set_xlim(heights[0] - 0.3, heights[-1] + 0.3)
    legend_below(figure)
    return figure


CLAIM_PER_CENT, CLAIM_STIFFNESS = 0.5, 1e4
"""Half a per cent by 1e4 N/m: what the source reports."""


def error_against_stiffness(curves: Mapping[str, Curve]) -> Figure:
    """Draw errors in per cent over stiffness, with the corner that the source's must stay below."""
    figure = panels(1, 1, width=7.6, height=4.6)
    axes = figure.axes[0]
    draw_against_stiffness(
        axes, {name: (k, [100 * error for error in errors]) for name, (k, errors) in curves.items()}
    )
    axes.plot(
        [CLAIM_STIFFNESS, max(k for stiffness, _ in curves.values() for k in stiffness)],
        [CLAIM_PER_CENT] * 2, color="0.45", lw=3, alpha=0.6,
        label="source: falling, and below 0.5 % from 1e4 N/m on",
    )  # fmt: skip
    label(axes, "stiffness k (N/m)", "error of peak deformation (%)", "two particles")
    legend_below(figure)
    return figure


_LOOKS = ((ORANGE, "--"), (BLUE, "-"))
"""Trapped, and moving on."""


def velocity_series(motions: Sequence[VelocitySeries]) -> Figure:
    """Draw speed against time, a panel a code and step, an angle a line."""
    groups = [(code, list(part)) for code, part in groupby(motions, lambda series: series.label)]
    figure = Figure(figsize=(8.0, 1.2 + 1.75 * len(groups)))
    panels = figure.subplots(len(groups), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, (code, part) in zip(panels, groups, strict=True):
        for series in part:
            colour, line = _LOOKS[series.moving]
            fate = "moves on" if series.moving else "trapped"
            axes.plot(
                series.path.time_s, series.path.speed_m_per_s, line, color=colour, lw=1.1,
                label=f"{series.angle_deg:.2f} deg: {fate}",
            )  # fmt: skip
        axes.set_title(f"{code} per contact time")
        axes.set(ylabel="speed (m/s)", ylim=(0, None))
        axes.legend(loc="lower right", bbox_to_anchor=(1.01, 0.97), ncols=2, borderaxespad=0.2)
    panels[-1].set_xlabel("time (s)")
    panels[-1].margins(x=0.01)
    return figure
