"""Figure of what moved between releases, case by case."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from harness.comparison.releases import ReleaseMatrix
from harness.report.figures.style import COLOURS, MARKERS, label

FLOOR = 1e-17
"""Where a change of exactly 0 is drawn: below one unit in the last place."""


def changes(found: ReleaseMatrix) -> Figure:
    """Draw the relative change of each quantity against the reference release, and its tolerance.

    No change at all stands at the left edge; what has no value is not drawn.
    """
    rows = [row for row in found.rows if row.cells[found.reference].value is not None]
    figure = Figure(figsize=(7.6, 1.4 + 0.17 * max(len(rows), 4)), layout="constrained")
    axes = figure.subplots()
    height = np.arange(len(rows))
    scale = np.array([abs(row.cells[found.reference].value or 0.0) or 1.0 for row in rows])
    width = np.array([row.tolerance for row in rows]) / scale
    axes.scatter(
        np.maximum(width, FLOOR),
        height,
        marker="|",
        s=60,
        color="0.45",
        label="tolerance",
        zorder=1,
    )
    others = [i for i in range(len(found.columns)) if i != found.reference]
    for n, i in enumerate(others):
        apart = np.array(
            [np.nan if (d := row.cells[i].difference) is None else abs(d) for row in rows]
        )
        axes.scatter(
            np.maximum(apart / scale, FLOOR),
            height + 0.22 * (n - (len(others) - 1) / 2),
            marker=MARKERS[n % 6],
            s=16,
            facecolors="none",
            edgecolors=COLOURS[1 + n % 6],
            label=found.columns[i].title,
            zorder=2,
        )  # fmt: skip
    axes.set_xscale("log")
    axes.set_xlim(FLOOR / 3, None)
    axes.set_yticks(height, [f"{row.case}, {row.quantity}" for row in rows], fontsize=6.5)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    reference = found.columns[found.reference].title
    label(axes, f"change against {reference}, over the value [1]; 0 at {FLOOR:.0e}", "")
    axes.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.4, -0.04), ncols=2)
    return figure
