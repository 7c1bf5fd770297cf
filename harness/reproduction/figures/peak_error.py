"""The source's figure of the error of the peak deformation against stiffness."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from harness.cases.tower.evidence import Curve
from harness.cases.tower.figures.peak_error import draw_against_stiffness
from harness.report.figures.style import label, panels

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
    label(axes, "stiffness k [N/m]", "error of peak deformation [%]", "two particles")
    figure.legend(loc="outside lower center", ncols=2, fontsize="small")
    return figure
