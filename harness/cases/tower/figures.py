"""Draw the tower: runs in time, codes and laws against each other, angles against height.

Pure functions from runs and tables of ``impulse_angles`` to a figure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, MaxNLocator
from numpy.typing import ArrayLike, NDArray

from harness.cases.tower.comparison import Order, SeriesComparison, StepConvergence
from harness.comparison.convergence import slope_order
from harness.observables.reference import ReferencePoints
from harness.observables.row import Row
from harness.observables.tower import Floats, TowerRun, significant_contacts
from harness.report import style
from harness.report.style import COLOURS, MARKERS, STYLES, label, legend_below, named, panels, power

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
    for i, comparison in enumerate(comparisons):
        look: dict[str, Any] = {"color": style.COLOURS[i % 7], "linestyle": style.STYLES[i % 6]}
        suffix = f": largest difference {comparison.force.peak:.1e}"
        _force(above, comparison.run, comparison.force.scale, suffix, linewidth=1.2, **look)
        difference = np.abs(comparison.force_difference)
        below.semilogy(
            comparison.time / reference.tower.contact_time,
            np.where(difference > _LOWEST, difference, np.nan),
            linewidth=1.1, **look,
        )  # fmt: skip
    bound = max(comparison.force.interpolation_error for comparison in comparisons)
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
    for row, comparison in enumerate(comparisons):
        force, contacts = figure.axes[2 * row : 2 * row + 2]
        for i, run in enumerate((comparison.reference, comparison.run)):
            look: dict[str, Any] = {"color": style.COLOURS[1 + i], "linestyle": style.STYLES[i]}
            _force(force, run, comparison.force.scale, **look)
            contacts.step(run.time_over_t0, significant_contacts(run), where="post", **look)
        last = row == len(comparisons) - 1
        name = f"force over the peak\n({comparison.reference.tower.law} law)"
        style.label(force, TIME if last else "", name, _parted(comparison))
        style.label(contacts, TIME if last else "", FELT)
        contacts.yaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))
    style.legend_below(figure)
    return figure


def error_against_step(convergences: Sequence[StepConvergence]) -> Figure:
    """Draw the largest force error (left) and its mean over time (right) against the step.

    The legend has the measured orders with their 95 % intervals; open marks are errors
    below rounding or interpolation, which enter no order.
    """
    figure = style.panels(1, 2, width=5.2, height=4.6)
    peak, l2 = figure.axes
    for i, convergence in enumerate(convergences):
        _errors(peak, convergence, convergence.peak_error, convergence.peak_order, i)
        _errors(l2, convergence, convergence.l2_error, convergence.l2_order, i)
    style.label(peak, "steps per contact", "largest force error over the peak")
    style.label(l2, "steps per contact", "L2 force error over the peak")
    steps = sorted(
        {float(n) for convergence in convergences for n in convergence.steps_per_contact}
    )
    for axes in (peak, l2):
        style.few_ticks(axes, steps)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17))
    return figure


def _force(axes: Axes, run: TowerRun, scale: float, suffix: str = "", **look: Any) -> None:
    """Draw the force of a run over ``scale`` [N]."""
    name = style.named(run.tower.law, _code(run)) + suffix
    axes.plot(run.time_over_t0, run.grain_force / scale, label=name, **look)


def _errors(axes: Axes, convergence: StepConvergence, errors: Floats, order: Order, i: int) -> None:
    """Draw one code's errors and the line of its order."""
    tower, resolved = convergence.reference.tower, convergence.peak_error > convergence.floor
    name = f"{style.named(tower.law, convergence.solver)}, {tower.particles} particles"
    look: dict[str, Any] = {
        "color": style.COLOURS[i % 7],
        "marker": style.MARKERS[i % 6],
        "linestyle": "none",
    }
    axes.loglog(
        convergence.steps_per_contact[resolved],
        errors[resolved],
        label=f"{name}: {_order(order)}",
        **look,
    )
    hidden = errors[~resolved].clip(_LOWEST)
    axes.loglog(convergence.steps_per_contact[~resolved], hidden, fillstyle="none", **look)
    if np.isfinite(order.value):
        steps, logs = convergence.steps_per_contact[resolved], np.log(errors[resolved])
        line = np.exp(logs.mean() - order.value * (np.log(steps) - np.log(steps).mean()))
        axes.loglog(
            steps, line, color=style.COLOURS[i % 7], linestyle=style.STYLES[i % 6], linewidth=1
        )


def _order(order: Order) -> str:
    if not np.isfinite(order.value):
        return "no order"
    if order.interval[0] <= 0.0:
        return "does not converge"
    return f"order {order.value:.2f} ({order.interval[0]:.2f} to {order.interval[1]:.2f})"


def _code(run: TowerRun) -> str:
    """Return a code and its step."""
    if run.step is None:
        return run.solver
    return f"{run.solver}, {run.tower.contact_period / run.step:.0f} steps per contact"


def _parted(comparison: SeriesComparison) -> str:
    """Return when two forces part, and how far they are apart on the mean."""
    particles = f"{comparison.run.tower.particles} particles"
    if comparison.divergence_time is None:
        return f"{particles}: both laws give the same force"
    at = comparison.divergence_time / comparison.reference.tower.contact_time
    return f"{particles}: forces part at {at:.2g} t0, by {comparison.force.l2:.2g} of the peak (L2)"


def tower_error_against_step(convergences: Sequence[StepConvergence]) -> Figure:
    """Draw the force error of each engine's tower against its step, with guides to the slopes."""
    figure = Figure(figsize=(6.4, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for i, convergence in enumerate(convergences):
        order = convergence.l2_order
        suffix = f", order {order.value:.2f}" if order.interval[0] > 0.0 else ""
        axes.loglog(
            convergence.steps_per_contact,
            convergence.l2_error,
            color=style.COLOURS[i % 7],
            marker=style.MARKERS[i % 6],
            ls=style.STYLES[i % 6],
            ms=8 - min(i, 4),
            lw=1.1,
            mfc="none" if i % 2 else None,
            label=f"{convergence.solver}{suffix}",
        )
    steps = np.unique(
        np.concatenate([convergence.steps_per_contact for convergence in convergences])
    )
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
    top = 1.6 * max(float(convergence.l2_error[0]) for convergence in convergences)
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


def _of_tower(convergence: StepConvergence) -> str:
    tower = convergence.reference.tower
    return f"tower, n = {tower.height}, {tower.law} law, k = {style.power(tower.stiffness)} N/m"


_RUN = ["stiffness_N_per_m", "speed_m_per_s"]
_HEIGHT, _GAMMA = "height n (contacts)", "Gamma = m g / (v0 sqrt(k m))"
_ALPHA, _ANGLE = "impulse ratio alpha = J(n) / J(1)", "critical angle (deg)"
_ENDS = 2.0  # of alpha, where the shock of either reading ends
_WAYS: tuple[dict[str, Any], ...] = (
    {"marker": "o", "ms": 10, "mfc": "none", "ls": "none"},
    {"marker": "+", "ms": 10, "ls": "none"},
    {"marker": ".", "ms": 4, "ls": "none"},
)
READINGS = {
    "lost": "velocity lost, sqrt(shock) = 1 - alpha/2",
    "kept": "velocity kept, sqrt(shock) = alpha/2",
}


def ratio_against_height(frame: pd.DataFrame, solver: str) -> Figure:
    """Draw alpha(n) of every run (the source's impulse figure), a panel for each law and window."""
    figure, grid = _grid(frame)
    for (_, part), axes in grid:
        for look, run in _runs(part):
            axes.plot(run["height"], run["impulse_ratio"], **look)
        axes.axhline(1, color="0.6", lw=0.8, zorder=0)
    _finish(figure, grid, _ALPHA, solver)
    return figure


def angle_over_contacts(frame: pd.DataFrame, published: Row) -> Figure:
    """Draw theta_c over the contacts of one run: both laws, both readings, one grain's theory."""
    figure = Figure(figsize=(7.2, 4.1))
    axes = figure.add_subplot()
    for number, (law, run) in enumerate(frame.sort_values("height").groupby("law")):
        look: dict[str, Any] = {"color": COLOURS[1 + number], "marker": MARKERS[number]}
        fills: dict[str, dict[str, Any]] = {"lost": {}, "kept": {"mfc": "white", "ls": ":"}}
        for reading, fill in fills.items():
            column = f"critical_angle_{reading}_deg"
            name = f"{law} law, velocity {reading}"
            axes.plot(run["height"], run[column], label=name, **look, **fill)
    single = float(frame.loc[frame["height"] == 1, "critical_angle_lost_deg"].iloc[0])
    axes.axhline(
        single, color=COLOURS[0], ls="--", lw=1, label=f"one contact, theory {single:.2f} deg"
    )
    draw_others(axes, published, None)
    axes.set_xticks(_ticks(frame))
    axes.set_ylim(bottom=0)
    label(axes, _HEIGHT, _ANGLE)
    legend_below(figure, 2)
    return figure


def critical_angle_against_height(
    frame: pd.DataFrame,
    *,
    readings: Sequence[str] = ("lost", "kept"),
    solver: str,
    published: Row | None = None,
    reference: ReferencePoints | None = None,
) -> Figure:
    """Draw theta_c(n) of every run, a panel for each law and window, with what others found.

    With two readings, symbols are filled for the first and open for the second.
    """
    figure, grid = _grid(frame)
    for (_, part), axes in grid:
        for number, reading in enumerate(readings):
            fill: dict[str, Any] = {"mfc": "white"} if number else {}
            for look, run in _runs(part):
                name = "_" if number else look["label"]
                column = f"critical_angle_{reading}_deg"
                axes.plot(run["height"], run[column], **look | fill | {"label": name})
            grey: dict[str, Any] = {"marker": "o", "color": "0.4", "ls": "none"}
            axes.plot([], [], label=f"reading: {READINGS[reading]}", **grey, **fill)
        draw_others(axes, published, reference)
    _finish(figure, grid, _ANGLE, solver)
    for (_, part), axes in grid:
        axes.set_ylim(bottom=0)  # only now: a limit that is set ends the scaling of a shared axis
        axes.set_xticks(_ticks(part, reference))
    return figure


def collapse_on_gamma(frame: pd.DataFrame, solver: str, heights: Sequence[int]) -> Figure:
    """Draw alpha against Gamma: colours for heights, symbols for stiffness, mass and gravity."""
    figure, grid = _grid(frame)
    varied = ["stiffness_N_per_m", "mass_kg", "gravity_m_per_s2"]
    for (_, part), axes in grid:
        for i, height in enumerate(heights):
            tower = part[part["height"] == height].sort_values("gamma")
            look: dict[str, Any] = {
                "color": style.COLOURS[i % 7],
                "ls": style.STYLES[i % 6],
                "lw": 1.1,
            }
            line = tower.drop_duplicates("gamma")
            axes.plot(line["gamma"], line["impulse_ratio"], label=f"n = {height}", **look)
            for j, (_, points) in enumerate(tower.groupby(varied, sort=False)):
                symbol: dict[str, Any] = _WAYS[j % 3] | {"color": style.COLOURS[i % 7]}
                axes.plot(points["gamma"], points["impulse_ratio"], **symbol)
        for j, ((k, m, g), _) in enumerate(part.groupby(varied, sort=False)):
            name = f"k = {style.power(k)} N/m, m = {m:g} kg, g = {g:g} m/s2"
            axes.plot([], [], **_WAYS[j % 3] | {"color": "0.3", "label": name})
        axes.axhline(1, color="0.6", lw=0.8, zorder=0)
        axes.set(xscale="log", yscale="log")
        axes.yaxis.set_major_locator(FixedLocator([0.25, 0.5, 1, 2, 4]))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter("")
    _finish(figure, grid, _ALPHA, solver, _GAMMA)
    return figure


def map_over_gamma(frame: pd.DataFrame, solver: str, marked: Sequence[float] = ()) -> Figure:
    """Draw alpha over Gamma and height as a heat map, one scale for all panels.

    The scale ends at 2, beyond which alpha makes no critical angle. ``marked``
    values of Gamma are pointed at, as those of the source's runs.
    """
    figure, grid = _grid(frame)
    lowest = min(0.5, float(frame["impulse_ratio"].min()))
    for (names, part), axes in grid:
        table = part.pivot_table("impulse_ratio", "height", "gamma", dropna=False)
        gammas, heights = table.columns.to_numpy(float), table.index.to_numpy(float)
        mesh = axes.pcolormesh(
            gammas, heights, table.to_numpy(), cmap="cividis", shading="nearest",
            vmin=lowest, vmax=_ENDS,
        )  # fmt: skip
        for number, gamma in enumerate(marked):
            axes.axvline(gamma, color="white", ls=":", lw=1.2)
            if not number:  # white is seen on the map only
                axes.plot([], [], color="0.3", ls=":", lw=1.2, label="Gamma of the source's runs")
        axes.set(xscale="log", xlabel=_GAMMA, ylabel=_HEIGHT, yticks=_ticks(part))
        axes.set_title(_title(*names, solver), fontsize="medium")
        axes.label_outer()
        axes.grid(visible=False)
    figure.colorbar(mesh, ax=figure.axes, label=_ALPHA, extend="max")
    style.legend_below(figure)
    return figure


def energy_scaling(
    scaling: pd.DataFrame,
    published: Row,
    *,
    largest: int = 10,
) -> Figure:
    """Draw theta_c(n) for alpha = 1/sqrt(n); the source ends it at ``largest`` particles."""
    figure = Figure(figsize=(7.2, 5.2), layout="constrained")
    axes = figure.subplots()
    for reading, colour, marker in (("lost", style.BLUE, "o"), ("kept", style.ORANGE, "s")):
        heights, angles = scaling["height"], scaling[f"critical_angle_{reading}_deg"]
        inside = heights <= largest
        name = f"alpha = 1/sqrt(n), reading: {READINGS[reading]}"
        axes.plot(heights[inside], angles[inside], color=colour, marker=marker, label=name)
        beyond = heights >= largest
        axes.plot(heights[beyond], angles[beyond], color=colour, ls=":", label="_")
        at_end = angles[heights == largest]
        if reading == "lost" and not at_end.empty:
            value = float(at_end.iloc[0])
            name = f"its angle at {largest} particles, {value:.2f} deg (the source's cut-off)"
            axes.axhline(value, color=style.BLACK, ls="--", lw=1, label=name)
    axes.axvline(largest, color="0.5", ls="-.", lw=1, label=f"{largest} particles")
    draw_others(axes, published)
    axes.set(xlabel=_HEIGHT, ylabel=_ANGLE)
    axes.set_ylim(bottom=0)
    axes.set_xticks(_ticks(scaling))
    style.legend_below(figure, 1)
    return figure


Panels = list[tuple[tuple[tuple[str, str], pd.DataFrame], Axes]]


def _grid(frame: pd.DataFrame) -> tuple[Figure, Panels]:
    """Return a figure with a column for each law and a row for each window, with their parts."""
    laws, windows = frame["law"].unique(), frame["window"].unique()
    size = (max(5.0 * len(laws), 8.6), 3.4 * len(windows) + 1.0)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(len(windows), len(laws), squeeze=False, sharex=True, sharey=True)
    panels: Panels = []
    for row, window in enumerate(windows):
        for column, law in enumerate(laws):
            part = frame[(frame["law"] == law) & (frame["window"] == window)]
            panels.append((((law, window), part), grid[row, column]))
    return figure, panels


def _finish(figure: Figure, grid: Panels, y: str, solver: str, x: str = _HEIGHT) -> None:
    """Name axes and panels, and put one legend below all of them."""
    for (names, part), axes in grid:
        axes.set_title(_title(*names, solver), fontsize="medium")
        axes.set(xlabel=x, ylabel=y)
        axes.label_outer()
        if x == _HEIGHT:
            axes.set_xticks(_ticks(part))
    style.legend_below(figure, axes=[grid[0][1]])


def _runs(part: pd.DataFrame) -> list[tuple[dict[str, Any], pd.DataFrame]]:
    """Return each run with its look: colour and line the stiffness, symbol the speed.

    Later runs have smaller symbols, so that runs that coincide are all seen.
    """
    stiffnesses, speeds = (list(part[name].unique()) for name in _RUN)
    runs = []
    for i, ((k, v), run) in enumerate(part.groupby(_RUN, sort=False)):
        kind = stiffnesses.index(k)
        gamma = run["gamma"].iloc[0]
        look = {
            "color": (style.BLUE, style.GREEN, style.RED, *style.COLOURS)[kind % 10],
            "ls": style.STYLES[kind % 6],
            "lw": 1.1,
            "marker": style.MARKERS[speeds.index(v) % 5],
            "ms": max(3.0, 8.5 - i),
            "label": f"k = {style.power(k)} N/m, v0 = {v:g} m/s, Gamma = {gamma:.2g}",
        }
        runs.append((look, run))
    return runs


def draw_others(
    axes: Axes, published: Row | None, reference: ReferencePoints | None = None
) -> None:
    """Draw the published angle as a band, and reference points."""
    if published is not None:
        low = published.value - published.uncertainty
        name = f"{published.name}, {published.value:g} ± {published.uncertainty:g} deg"
        axes.axhspan(
            low, low + 2 * published.uncertainty, color="0.82", zorder=0,
            label=f"{name}\n({published.who})",
        )  # fmt: skip
    if reference is not None:
        name = reference.name.replace("$", r"\$")  # a file's name is no formula
        axes.plot(
            reference.heights, reference.angles_deg, "*", color=style.BLACK, ms=9, mfc="none",
            label=f"reference: {name} (h/d)",
        )  # fmt: skip


def _ticks(part: pd.DataFrame, reference: ReferencePoints | None = None) -> list[int]:
    """Return about ten heights, the first among them, as far as the points go."""
    first, last = int(part["height"].min()), int(part["height"].max())
    if reference is not None:
        last = max(last, int(max(reference.heights)))
    return list(range(first, last + 1, max(1, math.ceil((last - first) / 10))))


def _title(law: str, window: str, solver: str) -> str:
    return f"{law} law, {window} window, {solver}"


def measured_order(sizes: ArrayLike, errors: ArrayLike) -> tuple[float, float]:
    """Return the slope of log error against log size, and half its 95 % interval."""
    slope, (low, high) = slope_order(sizes, errors)
    return slope, (high - low) / 2


def sampled_peak_error(omega_step: ArrayLike) -> NDArray[np.float64]:
    """Return the largest relative error of a peak read off samples [1], ``(omega h)^2 / 4``.

    The largest sample is up to half a step off the top of the wave, whose
    frequency is sqrt(2) omega for two free particles.
    """
    return np.asarray(1 - np.cos(np.sqrt(0.5) * np.asarray(omega_step, dtype=float)))


def peak_error(
    by_step: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    by_stiffness: Mapping[str, tuple[Sequence[float], Sequence[float]]],
) -> Figure:
    """Draw relative errors of the peak deformation of two particles under RK4.

    ``by_step`` maps a name to (steps in units of 1/omega, errors), and its
    legend has the measured order; ``by_stiffness`` maps a name to (stiffness
    [N/m], errors). With the step in units of the contact time stiffness does not
    matter at all, and with one step in seconds the error of the largest sample
    grows as k h^2. The source reports one that falls with k: that is not the
    error of RK4, but would take steps that shrink faster than k^(-1/2).
    """
    figure = panels(1, 2, width=5.2, height=3.8)
    step_axes, stiffness_axes = figure.axes
    for i, (name, (steps, errors)) in enumerate(by_step.items()):
        slope, half = measured_order(steps, errors)
        step_axes.loglog(
            steps, errors, color=COLOURS[i % 7], marker=MARKERS[i % 6], linestyle="none",
            markersize=4, label=f"{name}: order {slope:.2f} ± {half:.2f}",
        )  # fmt: skip
    span = np.sort(np.concatenate([np.asarray(steps) for steps, _ in by_step.values()]))
    step_axes.loglog(
        span, sampled_peak_error(span), color="0.4", linewidth=1, label="bound of a sample, (ωh)²/4"
    )
    label(step_axes, "step (1/omega)", "relative error of peak deformation", "two particles, RK4")
    draw_against_stiffness(stiffness_axes, by_stiffness)
    label(
        stiffness_axes,
        "stiffness (N/m)",
        "relative error of peak deformation",
        "two particles, RK4",
    )
    legend_below(figure)
    return figure


def draw_against_stiffness(
    axes: Axes, by_stiffness: Mapping[str, tuple[Sequence[float], Sequence[float]]]
) -> None:
    """Draw named errors against stiffness [N/m], both axes logarithmic."""
    for i, (name, (stiffness, errors)) in enumerate(by_stiffness.items()):
        axes.loglog(
            stiffness, errors, color=COLOURS[i % 7], marker=MARKERS[i % 6],
            linestyle=STYLES[i % 6], markersize=4, label=name,
        )  # fmt: skip
