"""Figures of tower runs in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from harness.observables.tower import TowerRun
from harness.report.figures.style import COLOURS, STYLES, label, named, panels

_TIME = "time [t0]"

FELT_FORCE = 1e-6
FELT = "contacts (1e-6 peak)"
"""Contacts that press with more than this part of the peak; fainter ones are rounding's."""


def felt_contacts(run: TowerRun) -> NDArray[np.float64]:
    """Return the contacts of the grain's chain that are worth showing (M,), of a run with profiles.

    All that carry a force, of one without.
    """
    if run.profiles is None:
        return run.contacts
    return run.contacts_above(FELT_FORCE * float(run.grain_force.max()))


def velocity_and_deformation(runs: Sequence[TowerRun]) -> Figure:
    """Draw velocity (above) and deformation (below) of every particle, one column a run.

    The runs need profiles. The source's figure has two and three particles.
    """
    figure = panels(2, len(runs))
    for column, run in enumerate(runs):
        above, below = figure.axes[column], figure.axes[len(runs) + column]
        assert run.profiles is not None
        velocities, deformations = run.profiles.velocities, 1e3 * run.deformations
        for i in range(run.tower.particles):
            look: dict[str, Any] = {"color": COLOURS[i % 7], "linestyle": STYLES[i % 6]}
            name = "grain" if i == 0 else f"particle {i + 1}"
            above.plot(run.time_over_t0, velocities[:, i], label=name, **look)
            below.plot(run.time_over_t0, deformations[:, i], label=name, **look)
        title = f"{run.tower.particles} particles: {named(run.tower.law, run.solver)}"
        label(above, _TIME, "velocity [m/s]", title)
        label(below, _TIME, "deformation [mm]")
        above.legend(fontsize="small")
        below.legend(fontsize="small")
    return figure


def force_and_contacts(runs: Sequence[TowerRun]) -> Figure:
    """Draw force on the grain and contacts in its chain against t/t0, one row a run."""
    figure = panels(len(runs), 1, width=6.5, height=2.2)
    peak = max(float(run.grain_force.max()) for run in runs)
    for row, run in enumerate(runs):
        axes = figure.axes[row]
        axes.plot(
            run.time_over_t0, run.grain_force / peak, color=COLOURS[1],
            label=f"force, {named(run.tower.law, run.solver)}",
        )  # fmt: skip
        title = f"{run.tower.particles} particles"
        label(axes, _TIME if row == len(runs) - 1 else "", "force [peak of all]", title)
        steps = axes.twinx()
        steps.step(
            run.time_over_t0, felt_contacts(run), where="post", color=COLOURS[2], linestyle="--",
            linewidth=1.1, label="contacts",
        )  # fmt: skip
        steps.set_ylabel(FELT)
        steps.yaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_ylim(-0.03, 1.08)
        steps.set_ylim(bottom=-0.03 * steps.get_ylim()[1])
        lines = [*axes.get_lines(), *steps.get_lines()]
        axes.legend(lines, [str(line.get_label()) for line in lines], fontsize="small", loc=1)
    return figure


def collapse(runs: Sequence[TowerRun]) -> Figure:
    """Draw the force on the grain over its scale v0 sqrt(k m) against t/t0, all runs in one."""
    figure = panels(1, 1, width=6.5, height=3.6)
    axes = figure.axes[0]
    for i, run in enumerate(runs):
        tower = run.tower
        scale = tower.speed * tower.omega * tower.each("mass")[0]
        axes.plot(
            run.time_over_t0, run.grain_force / scale, color=COLOURS[i % 7],
            linestyle=STYLES[i % 6], linewidth=2.6 - 0.35 * (i % 6),
            label=f"k = {tower.each('stiffness')[0]:.0e} N/m, v0 = {tower.speed:g} m/s, "
            f"Gamma = {tower.gamma:.2g}",
        )  # fmt: skip
    first = runs[0]
    title = f"{first.tower.particles} particles: {named(first.tower.law, first.solver)}"
    label(axes, _TIME, "force on the grain [v0 sqrt(k m)]", title)
    axes.legend(fontsize="small")
    return figure


def energy_drift_in_time(runs: Sequence[TowerRun]) -> Figure:
    """Draw the deviation of the total energy, over the energy of the start, against t/t0."""
    figure = panels(1, 1, width=6.5, height=3.6)
    axes = figure.axes[0]
    for i, run in enumerate(runs):
        scale = 0.5 * run.tower.each("mass")[0] * run.tower.speed**2
        drift = abs(run.energy - run.energy[0]) / scale
        name = f"{named(run.tower.law, run.solver)}, {run.tower.particles} particles"
        if run.step is not None:
            name += f", {run.tower.contact_period / run.step:.0f} steps per contact"
        axes.semilogy(
            run.time_over_t0[1:], drift[1:].clip(1e-17), color=COLOURS[i % 7],
            linestyle=STYLES[i % 6], linewidth=1.2, label=name,
        )  # fmt: skip
    label(axes, _TIME, "energy drift [1]")
    axes.legend(fontsize="small")
    return figure
