"""Figures of tower runs in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.observables.significant_contacts import significant_contacts
from harness.observables.tower import TowerRun
from harness.report.figures.style import COLOURS, STYLES, label, legend_below, named, panels, power

TIME = "time (t0)"

FELT = "contacts of the grain"


def velocity_and_deformation(runs: Sequence[TowerRun]) -> Figure:
    """Draw velocity (above) and deformation (below) of every particle, one column a run.

    The runs need profiles. The source's figure has two and three particles.
    """
    figure = panels(2, len(runs))
    for column, run in enumerate(runs):
        above, below = figure.axes[column], figure.axes[len(runs) + column]
        velocities, deformations = run.known_profiles.velocities, 1e3 * run.deformations
        for i in range(run.tower.particles):
            look: dict[str, Any] = {"color": COLOURS[i % 7], "linestyle": STYLES[i % 6]}
            name = "grain" if i == 0 else f"particle {i + 1}"
            above.plot(run.time_over_t0, velocities[:, i], label=name, **look)
            below.plot(run.time_over_t0, deformations[:, i], label=name, **look)
        title = f"{run.tower.particles} particles: {named(run.tower.law, run.solver)}"
        label(above, TIME, "velocity (m/s)", title)
        label(below, TIME, "deformation (mm)")
    legend_below(figure, 3)
    return figure


def force_and_contacts(
    runs: Sequence[TowerRun], peak: float | None = None, of: str = "the largest"
) -> Figure:
    """Draw force on the grain and contacts in its chain against t/t0, one row a run.

    The force is in units of ``peak`` [N], the largest of these runs if not given;
    ``of`` is what the axis calls it.
    """
    figure = panels(len(runs), 1, width=6.5, height=2.2)
    scale = max(float(run.grain_force.max()) for run in runs) if peak is None else peak
    for row, run in enumerate(runs):
        axes = figure.axes[row]
        draw_force_and_contacts(axes, run, scale)
        title = f"{run.tower.particles} particles"
        label(axes, TIME if row == len(runs) - 1 else "", f"force over\n{of}", title)
    legend_below(figure, 3)
    return figure


def draw_force_and_contacts(axes: Axes, run: TowerRun, scale: float) -> None:
    """Draw force over ``scale`` [N] and, on twin axes, the grain's contacts."""
    axes.plot(
        run.time_over_t0, run.grain_force / scale, color=COLOURS[1],
        label=f"force, {named(run.tower.law, run.solver)}",
    )  # fmt: skip
    steps = axes.twinx()
    steps.step(
        run.time_over_t0, significant_contacts(run), where="post", color=COLOURS[2], linestyle="--",
        linewidth=1.1, label="contacts",
    )  # fmt: skip
    steps.set_ylabel(FELT)
    steps.grid(visible=False)
    steps.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylim(-0.03, 1.08)
    steps.set_ylim(bottom=-0.03 * steps.get_ylim()[1])


def collapse(runs: Sequence[TowerRun]) -> Figure:
    """Draw the force on the grain over its scale v0 sqrt(k m) against t/t0, all runs in one."""
    figure = panels(1, 1, width=6.5, height=3.6)
    axes = figure.axes[0]
    draw_scaled_forces(axes, runs)
    axes.set_xlabel(TIME)
    legend_below(figure, 1)
    return figure


def draw_scaled_forces(axes: Axes, runs: Sequence[TowerRun]) -> None:
    """Draw the forces on the grain over v0 sqrt(k m), named by what the runs differ in."""
    for run, look in zip(runs, runs_apart(len(runs)), strict=True):
        tower = run.tower
        scale = tower.speed * tower.omega * tower.each("mass")[0]
        axes.plot(
            run.time_over_t0, run.grain_force / scale, **look,
            label=f"k = {power(tower.each('stiffness')[0])} N/m, v0 = {tower.speed:g} m/s, "
            f"Gamma = {tower.gamma:.2g}",
        )  # fmt: skip
    first = runs[0]
    title = f"{first.tower.particles} particles: {named(first.tower.law, first.solver)}"
    label(axes, "", "force on the grain (v0 sqrt(k m))", title)


def runs_apart(count: int) -> list[dict[str, Any]]:
    """Return looks of lines that lie on each other: later ones are thinner, so all are seen."""
    return [
        {"color": COLOURS[i % 7], "linestyle": STYLES[i % 6], "linewidth": 2.6 - 0.35 * (i % 6)}
        for i in range(count)
    ]


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
    label(axes, TIME, "relative energy drift")
    legend_below(figure, 1)
    return figure
