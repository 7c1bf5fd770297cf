"""The source's velocity figure: LAMMPS, with the recorded MFiX runs below it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from matplotlib.figure import Figure

from harness.report.figures.style import BLUE, ORANGE
from harness.reproduction.figure_data.velocity_series import VelocitySeries

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
