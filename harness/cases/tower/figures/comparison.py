"""Figures that hold tower runs against each other: codes, laws, steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.cases.tower.comparison import DIVERGENCE, SeriesComparison
from harness.cases.tower.figures.runs import FELT, TIME
from harness.cases.tower.step_convergence import Order, StepConvergence
from harness.observables.significant_contacts import significant_contacts
from harness.observables.tower import Floats, TowerRun
from harness.report.figures import style

_LOWEST = 1e-17  # [1] a difference below it is drawn as none


def same_law(comparisons: Sequence[SeriesComparison]) -> Figure:
    """Draw the force of several codes against one reference, and below how far they are apart.

    All are of the same tower and reference. The dotted line bounds what
    interpolation to common times adds.
    """
    figure = style.panels(2, 1, width=7.0, height=3.1)
    above, below = figure.axes
    reference = comparisons[0].reference
    _force(above, reference, comparisons[0].force.scale, color="0.75", linewidth=5)
    for i, found in enumerate(comparisons):
        look: dict[str, Any] = {"color": style.COLOURS[i % 7], "linestyle": style.STYLES[i % 6]}
        told = f": largest difference {found.force.peak:.1e}"
        _force(above, found.run, found.force.scale, told, linewidth=1.2, **look)
        difference = np.abs(found.force_difference)
        below.semilogy(
            found.time / reference.tower.contact_time,
            np.where(difference > _LOWEST, difference, np.nan),
            linewidth=1.1, **look,
        )  # fmt: skip
    bound = max(found.force.interpolation_error for found in comparisons)
    if bound > 0:
        name = f"bound of what interpolation adds, {bound:.0e}"
        below.axhline(bound, color="0.4", linestyle=(0, (1, 2)), linewidth=1.2, label=name)
    tower = reference.tower
    style.label(above, "", "force over its peak", f"{tower.particles} particles, {tower.law} law")
    style.label(
        below, TIME, "difference over the peak", f"from {_code(reference)}; gaps where it is 0"
    )
    below.sharex(above)
    style.legend_below(figure, 1)
    return figure


def different_law(comparisons: Sequence[SeriesComparison]) -> Figure:
    """Draw force (left) and contacts in the grain's chain (right) under two laws, one row a height.

    Each comparison holds a run under one law against one under the other, by the
    same code.
    """
    figure = style.panels(len(comparisons), 2, width=5.4, height=2.3)
    for row, found in enumerate(comparisons):
        force, contacts = figure.axes[2 * row : 2 * row + 2]
        for i, run in enumerate((found.reference, found.run)):
            look: dict[str, Any] = {"color": style.COLOURS[1 + i], "linestyle": style.STYLES[i]}
            _force(force, run, found.force.scale, **look)
            contacts.step(run.time_over_t0, significant_contacts(run), where="post", **look)
        parted = "never part" if found.divergence_time is None else _parted(found)
        last = row == len(comparisons) - 1
        title = f"{found.run.tower.particles} particles, L2 difference {found.force.l2:.2g}, "
        name = f"force over the peak\n({found.reference.tower.law} law)"
        style.label(force, TIME if last else "", name, title + parted)
        style.label(contacts, TIME if last else "", FELT)
        contacts.yaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))
    style.legend_below(figure)
    return figure


def error_against_step(convergences: Sequence[StepConvergence]) -> Figure:
    """Draw the largest force error (left) and its mean over time (right) against the step.

    The legend tells the measured orders with their 95 % intervals; open marks are errors
    that rounding or interpolation hide, and that enter no order.
    """
    figure = style.panels(1, 2, width=5.2, height=4.6)
    peak, l2 = figure.axes
    for i, found in enumerate(convergences):
        _errors(peak, found, found.peak_error, found.peak_order, i)
        _errors(l2, found, found.l2_error, found.l2_order, i)
    style.label(peak, "steps per contact", "largest force error over the peak")
    style.label(l2, "steps per contact", "L2 force error over the peak")
    steps = sorted({float(n) for found in convergences for n in found.steps_per_contact})
    for axes in (peak, l2):
        style.few_ticks(axes, steps)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17))
    return figure


def _force(axes: Axes, run: TowerRun, scale: float, told: str = "", **look: Any) -> None:
    """Draw the force of a run over ``scale`` [N]."""
    name = style.named(run.tower.law, _code(run)) + told
    axes.plot(run.time_over_t0, run.grain_force / scale, label=name, **look)


def _errors(axes: Axes, found: StepConvergence, errors: Floats, order: Order, i: int) -> None:
    """Draw one code's errors and the line of its order."""
    tower, told = found.reference.tower, found.peak_error > found.floor
    name = f"{style.named(tower.law, found.solver)}, {tower.particles} particles"
    look: dict[str, Any] = {
        "color": style.COLOURS[i % 7],
        "marker": style.MARKERS[i % 6],
        "linestyle": "none",
    }
    axes.loglog(
        found.steps_per_contact[told], errors[told], label=f"{name}: {_order(order)}", **look
    )
    hidden = errors[~told].clip(_LOWEST)
    axes.loglog(found.steps_per_contact[~told], hidden, fillstyle="none", **look)
    if np.isfinite(order.value):
        steps, logs = found.steps_per_contact[told], np.log(errors[told])
        line = np.exp(logs.mean() - order.value * (np.log(steps) - np.log(steps).mean()))
        axes.loglog(
            steps, line, color=style.COLOURS[i % 7], linestyle=style.STYLES[i % 6], linewidth=1
        )


def _order(order: Order) -> str:
    if not np.isfinite(order.value):
        return "no order"
    return f"order {order.value:.2f} ({order.interval[0]:.2f} to {order.interval[1]:.2f})"


def _code(run: TowerRun) -> str:
    """Return a code and its step."""
    if run.step is None:
        return run.solver
    return f"{run.solver}, {run.tower.contact_period / run.step:.0f} steps per contact"


def _parted(found: SeriesComparison) -> str:
    assert found.divergence_time is not None
    at = found.divergence_time / found.reference.tower.contact_time
    return f"parted by {DIVERGENCE:g} at {at:.2g} t0"
