"""Figures of impulse and critical angle against height, from tables of ``impulse_angles``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from harness.observables.reference import PublishedAngle, ReferencePoints
from harness.report.figures import style

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


def critical_angle_against_height(
    frame: pd.DataFrame,
    *,
    readings: Sequence[str] = ("lost", "kept"),
    solver: str,
    published: PublishedAngle | None = None,
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
    """Draw alpha against Gamma for several heights: colour the height, symbol the way to Gamma."""
    figure, grid = _grid(frame)
    ways = ["stiffness_N_per_m", "mass_kg", "gravity_m_per_s2"]
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
            for j, (_, way) in enumerate(tower.groupby(ways, sort=False)):
                symbol: dict[str, Any] = _WAYS[j % 3] | {"color": style.COLOURS[i % 7]}
                axes.plot(way["gamma"], way["impulse_ratio"], **symbol)
        for j, ((k, m, g), _) in enumerate(part.groupby(ways, sort=False)):
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
    published: PublishedAngle,
    *,
    reference: ReferencePoints | None = None,
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
    draw_others(axes, published, reference)
    axes.set(xlabel=_HEIGHT, ylabel=_ANGLE)
    axes.set_ylim(bottom=0)
    axes.set_xticks(_ticks(scaling, reference))
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
    axes: Axes, published: PublishedAngle | None, reference: ReferencePoints | None
) -> None:
    """Draw the published angle as a band, and reference points."""
    if published is not None:
        low = published.value_deg - published.uncertainty_deg
        name = f"{published.what}, {published.value_deg:g} ± {published.uncertainty_deg:g} deg"
        axes.axhspan(
            low, low + 2 * published.uncertainty_deg, color="0.82", zorder=0,
            label=f"{name}\n({published.citation})",
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
