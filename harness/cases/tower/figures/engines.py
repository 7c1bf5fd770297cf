"""The figure of engines beside one another: the error of their towers against the step."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.cases.tower.step_convergence import StepConvergence
from harness.report.figures import style


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
            color=style.COLOURS[i % 7],
            marker=style.MARKERS[i % 6],
            ls=style.STYLES[i % 6],
            ms=8 - min(i, 4),
            lw=1.1,
            mfc="none" if i % 2 else None,
            label=f"{found.solver}{told}",
        )
    steps = np.unique(np.concatenate([found.steps_per_contact for found in convergences]))
    for slope in (1, 2):
        _guide(axes, steps, slope, convergences)
    style.label(axes, "steps per contact", "L2 error of the grain's force over its peak")
    axes.set_title(_of_tower(convergences[0]), fontsize="medium")
    style.few_ticks(axes, steps.tolist())
    style.legend_below(figure, 3)
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
    return f"tower, n = {tower.height}, {tower.law} law, k = {style.power(tower.stiffness)} N/m"
