"""Figure of where two series diverge, and of their difference with its tolerance."""

from __future__ import annotations

import re

import numpy as np
from matplotlib.figure import Figure

from harness.comparison.divergence import Comparison
from harness.report.figures.style import BLACK, BLUE, RED, label, legend_below, panels, quantity

AROUND = 0.15
"""Part of the record that is shown on either side of the divergence."""

LOWEST = 1e-20
"""A difference below it is drawn as none."""

_UNIT = re.compile(r"(?P<name>.+?)_(?P<unit>(?:kg|deg|rad|Ns|[mNsJ])(?:_per_[a-zA-Z0-9_]+)?)")


def name_and_unit(column: str) -> tuple[str, str]:
    """Return name and unit of a column whose name ends in its unit; ``1`` for one without.

    >>> name_and_unit("vx_m_per_s")
    ('vx', 'm/s')
    """
    found = _UNIT.fullmatch(column)
    if found is None:
        return column.replace("_", " "), "1"
    return found["name"].replace("_", " "), found["unit"].replace("_per_", "/")


def divergence(found: Comparison) -> Figure:
    """Draw run and reference where they diverge, and their difference over all times."""
    moment = found.divergence
    assert moment is not None
    figure = panels(2, 1, width=7.0, height=2.9)
    above, below = figure.axes
    name, unit = name_and_unit(found.column)
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
    when = "from the first step" if moment.from_first_step else f"diverge at {moment.time:.5g} s"
    for axes in (above, below):
        axes.axvline(moment.time, color=RED, linestyle=":", linewidth=1.6, label=when)
    label(above, "", quantity(name, unit), f"{found.case}, around the divergence")
    label(below, "time (s)", quantity("difference", unit), "whole record; shaded: shown above")
    legend_below(figure)
    return figure
