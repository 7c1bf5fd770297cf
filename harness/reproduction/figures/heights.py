"""The source's figures over height that no verification has: measured angles, structure window."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.cases.tower.figures.impulse import draw_others
from harness.observables.reference import PublishedAngle, ReferencePoints
from harness.report.figures.style import BLUE, ORANGE

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
    figure.legend(loc="outside lower center", fontsize="small")
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
    figure.legend(loc="outside lower center", ncols=2, fontsize="small")
    return figure
