"""Figure of what moved between releases, case by case."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.comparison.releases import ReleaseMatrix, Row
from harness.report.figures.divergence import name_and_unit
from harness.report.figures.style import COLOURS, MARKERS, Figure, label, legend_below

NONE = 1e-18
"""Where a change of exactly 0 is drawn: below one unit in the last place."""

MOST_ROWS = 60
"""Quantities that are drawn; of more, those that moved most by their tolerance."""

DECADES = (1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0)


def changes(found: ReleaseMatrix) -> Figure:
    """Draw the relative change of each quantity against the reference release, and its tolerance.

    No change at all stands at the left edge; what has no value is not drawn.
    """
    rows = _rows(found)
    figure = Figure(figsize=(10.0, 2.0 + 0.2 * max(len(rows), 4)), layout="constrained")
    axes = figure.subplots()
    place = np.arange(len(rows))
    scale = np.array([abs(row.cells[found.reference].value or 0.0) or 1.0 for row in rows])
    width = np.array([row.tolerance for row in rows]) / scale
    axes.scatter(_shown(width), place, marker="|", s=60, color="0.45", label="tolerance", zorder=1)
    others = [i for i in range(len(found.columns)) if i != found.reference]
    for n, i in enumerate(others):
        differences = [row.cells[i].difference for row in rows]
        apart = np.array([np.nan if d is None else abs(d) for d in differences])
        axes.scatter(
            _shown(apart / scale),
            place + 0.24 * (n - (len(others) - 1) / 2),
            marker=MARKERS[n % 6],
            s=15,
            facecolors="none",
            edgecolors=COLOURS[1 + n % 6],
            label=found.columns[i].title,
            zorder=2,
        )
    axes.set_xscale("log")
    axes.set_xlim(NONE / 5, 10.0)
    axes.set_xticks([NONE, *DECADES], ["none", *(f"{decade:.0e}" for decade in DECADES)])
    axes.minorticks_off()
    names = [f"{row.label or row.record}: {name_and_unit(row.quantity)[0]}" for row in rows]
    axes.set_yticks(place, names, fontsize=8.5)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    reference = found.columns[found.reference].title
    label(axes, f"change over the value, against\n{reference}", "")
    legend_below(figure)
    return figure


def _rows(found: ReleaseMatrix) -> list[Row]:
    """Return the quantities that are drawn, in the order of the matrix."""
    rows = [row for row in found.rows if row.cells[found.reference].value is not None]
    if len(rows) <= MOST_ROWS:
        return rows
    most = sorted(range(len(rows)), key=lambda n: _moved(rows[n]), reverse=True)[:MOST_ROWS]
    return [rows[n] for n in sorted(most)]


def _moved(row: Row) -> float:
    """Return the largest change of a quantity, in its tolerance."""
    changes = [abs(cell.difference) for cell in row.cells if cell.difference]
    return max(changes, default=0.0) / (row.tolerance or 1.0)


def _shown(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.maximum(values, NONE)
