"""The moment at which two series part: both around it, and their difference with the tolerance."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from harness.comparison.divergence import Comparison
from harness.report.figures.style import BLACK, BLUE, RED, label, panels

AROUND = 0.15
"""Part of the record that is shown on either side of the divergence."""

LOWEST = 1e-20
"""A difference below it is drawn as none."""

UNITS = {
    "x_m": ("position along the row", "m"),
    "y_m": ("position normal to the row", "m"),
    "vx_m_per_s": ("velocity along the row", "m/s"),
    "vy_m_per_s": ("velocity normal to the row", "m/s"),
    "grain_force_N": ("force on the grain", "N"),
    "grain_velocity_m_per_s": ("velocity of the grain", "m/s"),
    "grain_force_over_peak": ("force on the grain", "peak"),
}


def divergence(found: Comparison) -> Figure:
    """Draw run and reference around the moment they part, and their difference over all times."""
    moment = found.divergence
    assert moment is not None
    figure = panels(2, 1, width=7.0, height=2.9)
    above, below = figure.axes
    name, unit = UNITS.get(found.column, (found.column, "1"))
    span = float(found.time[-1] - found.time[0])
    left = max(float(found.time[0]), moment.time - AROUND * span)
    right = min(float(found.time[-1]), moment.time + AROUND * span)
    near = (found.time >= left) & (found.time <= right)
    above.plot(
        found.time[near], found.reference[near], color="0.7", linewidth=5,
        label=found.reference_label,
    )  # fmt: skip
    above.plot(
        found.time[near], found.value[near], color=BLUE, linewidth=1.3, label=found.run_label,
        marker="." if near.sum() < 60 else "",
    )  # fmt: skip
    apart = np.abs(found.difference)
    below.semilogy(
        found.time, np.where(apart > LOWEST, apart, np.nan), color=BLACK, linewidth=1.1,
        marker="." if found.time.size < 200 else "", markersize=3,
        label="difference; gaps where it is 0",
    )  # fmt: skip
    below.axhline(
        found.band, color="0.4", linestyle="--", linewidth=1.2, label=f"tolerance {found.band:.1e}"
    )
    below.axvspan(left, right, color="0.92", zorder=0)
    when = "from the first step" if moment.from_first_step else f"part at {moment.time:.5g} s"
    for axes in (above, below):
        axes.axvline(moment.time, color=RED, linestyle=":", linewidth=1.6, label=when)
        axes.legend(fontsize="small", loc="best")
    label(above, "", f"{name} [{unit}]", f"{found.case}, around the divergence")
    label(below, "time [s]", f"difference [{unit}]", "whole record; shaded: shown above")
    return figure
