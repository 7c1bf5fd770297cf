"""The source's figures of the tower in time: collapse, separation, choice of the window."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.comparison.source_figures import TowersInTime, WindowChoice
from harness.observables.felt_contacts import felt_contacts
from harness.observables.tower import TowerRun
from harness.report.figures.chain_runs import (
    FELT,
    TIME,
    draw_force_and_contacts,
    draw_scaled_forces,
    force_and_contacts,
    joint_legend,
    runs_apart,
)
from harness.report.figures.style import BLACK, GREEN, PURPLE, label, named, panels

_WIDTH, _HEIGHT = 7.6, 2.3  # [in] of a row
OF_ALL = "peak of all 19"


def collapse(runs: Sequence[TowerRun]) -> Figure:
    """Draw scaled force (above) and contacts (below) of towers that differ in stiffness."""
    figure = panels(2, 1, width=_WIDTH, height=2.7)
    above, below = figure.axes
    draw_scaled_forces(above, runs)
    for run, look in zip(runs, runs_apart(len(runs)), strict=True):
        below.step(run.time_over_t0, felt_contacts(run), where="post", **look)
    label(below, TIME, FELT)
    below.yaxis.set_major_locator(MaxNLocator(integer=True))
    below.sharex(above)
    return figure


def separation(towers: TowersInTime) -> Figure:
    """Draw force and contacts of each tower, and when its grain first feels the base."""
    figure = force_and_contacts(towers.separated, towers.largest_force, OF_ALL)
    figure.set_figwidth(_WIDTH)
    rows = zip(figure.axes, towers.separated, towers.base_felt, strict=False)
    for axes, run, felt in rows:
        if math.isfinite(felt):
            axes.axvline(felt, color=GREEN, ls=":", lw=1.8, label="base felt")
        twin = figure.axes[len(towers.separated) + list(figure.axes).index(axes)]
        joint_legend(axes, twin)
        told = f"base felt at {felt:.2f} t0" if math.isfinite(felt) else "base not felt"
        axes.set_title(f"{run.tower.particles} particles, {told}", fontsize="medium")
    return figure


def window_selection(choices: Sequence[WindowChoice]) -> Figure:
    """Draw contacts, force and compression, and the largest compression, a row a tower."""
    figure = panels(len(choices), 1, width=_WIDTH, height=2.9)
    for row, choice in enumerate(choices):
        axes, run = figure.axes[row], choice.run
        twin = draw_force_and_contacts(axes, run, float(run.grain_force.max()))
        axes.plot(
            run.time_over_t0, run.compression / run.compression.max(), color=BLACK, lw=1.2,
            ls="-.", label="compression, grain to base",
        )  # fmt: skip
        at = choice.largest_compression
        for time, line, name in (
            (at, "--", f"largest compression, {at:.3f} t0"),
            (2 * at, ":", f"end of the window, {2 * at:.3f} t0"),
        ):
            axes.axvline(time, color=PURPLE, ls=line, lw=1.8, label=name)
        title = f"{run.tower.particles} particles: {named(run.tower.law, run.solver)}"
        last = row == len(choices) - 1
        label(axes, TIME if last else "", "force, compression\n[largest]", title)
        joint_legend(axes, twin, loc="center left", bbox_to_anchor=(1.08, 0.5))
    return figure


def of_all_heights(towers: TowersInTime) -> Figure:
    """Draw force and contacts of the source's four towers, in the largest force of all heights."""
    figure = force_and_contacts(towers.shown, towers.largest_force, OF_ALL)
    figure.set_figwidth(_WIDTH)
    return figure
