"""The source's figures of the tower in time: collapse, separation, choice of the window."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.cases.tower.figures.runs import (
    FELT,
    TIME,
    draw_force_and_contacts,
    draw_scaled_forces,
    force_and_contacts,
    runs_apart,
)
from harness.observables.significant_contacts import significant_contacts
from harness.observables.tower import TowerRun
from harness.report.figures.style import BLACK, GREEN, PURPLE, label, legend_below, panels
from harness.reproduction.figure_data.towers_in_time import TowersInTime
from harness.reproduction.figure_data.windows import WindowChoice

_WIDTH, _HEIGHT = 7.6, 2.3  # [in] of a row
OF_ALL = "the largest of all 19"


def collapse(runs: Sequence[TowerRun]) -> Figure:
    """Draw scaled force (above) and contacts (below) of towers that differ in stiffness."""
    figure = panels(2, 1, width=_WIDTH, height=3.0)
    above, below = figure.axes
    draw_scaled_forces(above, runs)
    for run, look in zip(runs, runs_apart(len(runs)), strict=True):
        below.step(run.time_over_t0, significant_contacts(run), where="post", **look)
    label(below, TIME, FELT)
    below.yaxis.set_major_locator(MaxNLocator(integer=True))
    below.sharex(above)
    legend_below(figure, 1)
    return figure


def separation(towers: TowersInTime) -> Figure:
    """Draw force and contacts of each tower, and when its grain first feels the base."""
    figure = force_and_contacts(towers.separated, towers.largest_force, OF_ALL)
    figure.set_figwidth(_WIDTH)
    above = figure.axes[: len(towers.separated)]
    for axes, run, felt in zip(above, towers.separated, towers.base_felt, strict=True):
        told = "base not felt"
        if math.isfinite(felt):
            axes.axvline(felt, color=GREEN, ls=":", lw=1.8, label="base felt")
            told = f"base felt at {felt:.2f} t0"
        axes.set_title(f"{run.tower.particles} particles, {told}", fontsize="medium")
    legend_below(figure, 3)
    return figure


def window_selection(choices: Sequence[WindowChoice]) -> Figure:
    """Draw contacts, force and compression, and the largest compression, a row a tower."""
    figure = panels(len(choices), 1, width=_WIDTH, height=2.8)
    for row, choice in enumerate(choices):
        axes, run = figure.axes[row], choice.run
        draw_force_and_contacts(axes, run, float(run.grain_force.max()))
        axes.plot(
            run.time_over_t0, run.compression / run.compression.max(), color=BLACK, lw=1.2,
            ls="-.", label="compression, grain to base",
        )  # fmt: skip
        at = choice.largest_compression
        for time, line, name in ((at, "--", "largest compression"), (2 * at, ":", "window's end")):
            axes.axvline(time, color=PURPLE, ls=line, lw=2, label=name)
        title = f"{run.tower.particles} particles: compressed most at {at:.3f} t0"
        last = row == len(choices) - 1
        label(axes, TIME if last else "", "force, compression\nover the largest", title)
    legend_below(figure, 3)
    return figure


def of_all_heights(towers: TowersInTime) -> Figure:
    """Draw force and contacts of the source's four towers, in the largest force of all heights.

    The source scales the force up to the axis of the contacts; here each has an
    axis of its own and one height on the page, which keeps the comparison.
    """
    figure = force_and_contacts(towers.shown, towers.largest_force, OF_ALL)
    figure.set_figwidth(_WIDTH)
    return figure
