"""Draw the figures of the source, and those of the findings, from our own runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle
from matplotlib.ticker import MaxNLocator

from harness.cases.tower.figures import (
    FELT,
    TIME,
    draw_against_stiffness,
    draw_force_and_contacts,
    draw_others,
    draw_scaled_forces,
    force_and_contacts,
    runs_apart,
)
from harness.cases.tower.verification import Curve
from harness.observables.row import Row
from harness.observables.tower import TowerRun, significant_contacts
from harness.report import style
from harness.report.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    RED,
    label,
    legend_below,
    panels,
)
from harness.reproduction.figure_data import VelocitySeries, WindowChoice
from harness.reproduction.schematics import (
    ForceDiagram,
    LayerDrawing,
    Points,
    QuartierSystem,
    TowersInTime,
)

if TYPE_CHECKING:
    from harness.reproduction.run import FindingTables

_LAWS: dict[str, tuple[str, str]] = {"deformable": (BLUE, "o"), "overlap": (ORANGE, "s")}
_ANGLE = "critical angle (deg)"


def thin_layers(published: Row) -> Figure:
    """Draw what others found: a published angle."""
    figure = Figure(figsize=(7.6, 4.0))
    axes = figure.add_subplot()
    draw_others(axes, published)
    axes.set(xlabel="height h/d", ylabel=_ANGLE, xlim=(0, 21), ylim=(0, 12))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.text(
        0.5, 0.75, "no measured points: they are not published with the source",
        transform=axes.transAxes, ha="center", color="0.3",
    )  # fmt: skip
    legend_below(figure, 1)
    return figure


def structure_window(frame: pd.DataFrame, published: Row) -> Figure:
    """Draw the critical angle of the structure window: filled as printed, open read loosely."""
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.add_subplot()
    held = list(frame["held"].unique())
    for (law, reading), part in frame.groupby(["law", "held"], sort=False):
        colour, marker = _LAWS[str(law)]
        literal = reading == held[0]
        look: dict[str, Any] = {"ms": 7} if literal else {"ms": 12, "mfc": "none", "ls": "--"}
        exists = part.dropna()
        axes.plot(
            exists["height"], exists["critical_angle_lost_deg"], marker=marker, color=colour,
            lw=1.2, label=f"{law} law, exact: {reading} held", **look,
        )  # fmt: skip
    draw_others(axes, published)
    heights = sorted(frame["height"].unique())
    axes.set(xlabel="height n (contacts)", ylabel=_ANGLE, ylim=(0, 11.5), xticks=heights)
    axes.set_xlim(heights[0] - 0.3, heights[-1] + 0.3)
    legend_below(figure)
    return figure


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
    label(axes, "stiffness k (N/m)", "error of peak deformation (%)", "two particles")
    legend_below(figure)
    return figure


_LOOKS = ((ORANGE, "--"), (BLUE, "-"))
"""Trapped, and moving on."""


def velocity_series(motions: Sequence[VelocitySeries]) -> Figure:
    """Draw speed against time, a panel a code and step, an angle a line."""
    groups = [(code, list(part)) for code, part in groupby(motions, lambda series: series.label)]
    figure = Figure(figsize=(8.0, 1.2 + 1.75 * len(groups)))
    panels = figure.subplots(len(groups), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, (code, part) in zip(panels, groups, strict=True):
        for series in part:
            colour, line = _LOOKS[series.moving]
            fate = "moves on" if series.moving else "trapped"
            axes.plot(
                series.path.time_s, series.path.speed_m_per_s, line, color=colour, lw=1.1,
                label=f"{series.angle_deg:.2f} deg: {fate}",
            )  # fmt: skip
        axes.set_title(f"{code} per contact time")
        axes.set(ylabel="speed (m/s)", ylim=(0, None))
        axes.legend(loc="lower right", bbox_to_anchor=(1.01, 0.97), ncols=2, borderaxespad=0.2)
    panels[-1].set_xlabel("time (s)")
    panels[-1].margins(x=0.01)
    return figure


def angle_against_mfix_step(findings: FindingTables) -> Figure:
    """Return the critical angle in MFiX's scheme against its step factor, for each stiffness."""
    figure = style.panels(1, 1, 7.4, 4.0)
    axes = figure.axes[0]
    limits = findings.limits.set_index("stiffness_N_per_m")["critical_angle_deg"]
    small: dict[str, Any] = {"fontsize": 8.5}
    for i, (k, frame) in enumerate(findings.mfix.groupby("stiffness_N_per_m")):
        look: dict[str, Any] = {"color": style.COLOURS[i + 1]}
        axes.errorbar(
            frame["factor"], frame["euler_deg"], frame["euler_uncertainty_deg"], ls=style.STYLES[i],
            capsize=2, label=f"k = {style.power(k)} N/m, reference DEM, Euler", **look,
        )  # fmt: skip
        axes.annotate(f"no step: {limits[k]:.3f}", (5600, limits[k]), va="center", **look, **small)
    closed = findings.closed_form_deg
    axes.axhline(closed, color=style.BLACK, linewidth=1, linestyle=(0, (6, 3)))
    above: dict[str, Any] = {"xytext": (0, 3), "textcoords": "offset points"}
    axes.annotate(f"closed form {closed:.4f} deg", (50, closed), **above, **small)
    axes.set_xscale("log")
    axes.set_xlim(42, 14000)
    style.label(axes, "steps in a contact time of MFiX, f", "critical angle (deg)")
    style.legend_below(figure)
    return figure


def angle_against_restitution(findings: FindingTables, engine: str) -> Figure:
    """Return the critical angle against the restitution: two readings, two DEMs."""
    frame = findings.restitution
    figure = style.panels(1, 1, 6.4, 3.9)
    axes = figure.axes[0]
    e = frame["restitution"]
    axes.plot(
        e, frame["kept_deg"], style.STYLES[1], color=style.COLOURS[2], label="theory, velocity kept"
    )
    axes.plot(
        e, frame["lost_deg"], style.STYLES[2], color=style.COLOURS[1], label="theory, velocity lost"
    )
    reference: dict[str, Any] = {"fmt": "o-", "color": style.BLACK, "mfc": style.BLACK, "ms": 4}
    engine_look: dict[str, Any] = {"fmt": "s", "color": style.COLOURS[3], "mfc": "white", "ms": 8}
    for column, name, look in (
        ("reference", "reference DEM, steady motion, k = 1e6 N/m", reference),
        ("engine", f"{engine}, the same", engine_look),
    ):
        measured = frame[frame[f"{column}_deg"].notna()]
        axes.errorbar(
            measured["restitution"], measured[f"{column}_deg"],
            measured[f"{column}_uncertainty_deg"], capsize=2, label=name, **look,
        )  # fmt: skip
    style.label(axes, "restitution e", "critical angle (deg)")
    axes.set_ylim(0, None)
    style.legend_below(figure)
    return figure


_ACROSS, _UP = "across (diameters)", "up (diameters)"
_FIXED: dict[str, Any] = {"facecolor": "#d8d8d8", "edgecolor": "0.45", "lw": 0.9}
_LAYER: dict[str, Any] = {"facecolor": "white", "edgecolor": "0.45", "lw": 0.9}
_CHAIN: dict[str, Any] = {"facecolor": "#bcdcf0", "edgecolor": BLUE, "lw": 1.3}
_GRAIN: dict[str, Any] = {"facecolor": "#fbe3b5", "edgecolor": BLACK, "lw": 1.2}
_FORCE_SCALE = 0.75
"""Diameters for m g, and for sqrt(g d): what leaves room for all arrows."""


def quartier_system(system: QuartierSystem) -> Figure:
    """Draw the row, the path of the grain's centre, and the grain at crest A, well B, crest C."""
    figure = Figure(figsize=(8.0, 4.0))
    axes = figure.add_subplot()
    _spheres(axes, system.spheres, _FIXED)
    for name, centre in system.grains.items():
        line = "-" if name == "B" else "--"
        _spheres(axes, [centre], _GRAIN | {"ls": line, "fill": name == "B"})
        above: dict[str, Any] = {"xytext": (0, 7), "textcoords": "offset points", "ha": "center"}
        axes.annotate(name, _point(centre), weight="bold", **above)
        axes.plot(*centre, "o", color=BLACK, ms=3.5, zorder=4)
    _join(axes, system.path, color=BLUE, lw=1.6, zorder=3, label="path of the grain's centre")
    well = system.grains["B"]
    touched = [s for s in system.spheres if abs(float(np.hypot(*(s - well))) - 1) < 1e-9]
    for number, sphere in enumerate(touched):
        name = "_" if number else "contacts in the well"
        _join(axes, [well, sphere], color=RED, ls=":", lw=1.4, zorder=3, label=name)
    _tilt(axes, system.spheres[0], system.spheres[-1], system.angle_deg)
    _gravity(axes, (float(system.spheres[-1][0]) + 0.4, 1.2))
    _frame(axes, f"the row is tilted by theta = {system.angle_deg:.2f} deg, its critical angle")
    axes.plot([], [], "o", color=BLACK, ms=3.5, label="A, C: crests; B: well")
    legend_below(figure, 3)
    return figure


def force_diagrams(diagrams: Sequence[ForceDiagram]) -> Figure:
    """Draw weight, contact force and velocity of the grain in the well, before and after."""
    figure = Figure(figsize=(8.0, 4.2))
    for axes, diagram in zip(figure.subplots(1, len(diagrams)), diagrams, strict=True):
        state = diagram.state
        _spheres(axes, [state.sphere, diagram.other], _FIXED)
        _spheres(axes, [state.grain], _GRAIN | {"facecolor": "none"})
        for sphere, line in ((state.sphere, "-"), (diagram.other, "--")):
            _join(axes, [state.grain, sphere], color="0.35", ls=line, lw=1.1)
        _arrow(axes, state.grain, state.weight, RED, "m g")
        _arrow(axes, state.grain, state.contact_force, BLUE, "$F_c$")
        if diagram.velocity_before is not None:
            _arrow(axes, state.grain, diagram.velocity_before, PURPLE, "v'", dashed=True)
        name = "v'" if diagram.velocity_before is None else "v"
        _arrow(axes, state.grain, state.velocity, GREEN, name)
        _frame(axes, diagram.name)
        middle = (state.sphere + diagram.other) / 2
        axes.set(xlim=(middle[0] - 1.05, middle[0] + 1.25), ylim=(-1.0, 1.75))
    looks = {
        "weight m g": (RED, "-"), "contact force": (BLUE, "-"), "velocity": (GREEN, "-"),
        "velocity before": (PURPLE, "--"), "contact": ("0.35", "-"),
        "other contact": ("0.35", "--"),
    }  # fmt: skip
    for name, (colour, line) in looks.items():
        figure.axes[0].plot([], [], color=colour, ls=line, label=name)
    legend_below(figure, 3)
    unit = f"arrows: {_FORCE_SCALE:g} d is m g, and sqrt(g d)"
    figure.legends[0].set_title(unit)
    return figure


def layers(arranged: Sequence[LayerDrawing]) -> Figure:
    """Draw layers on the fixed row, and the chain that goes on along the grain's contact."""
    figure = Figure(figsize=(8.0, 4.6))
    for axes, part in zip(figure.subplots(1, len(arranged)), arranged, strict=True):
        _spheres(axes, part.fixed, _FIXED)
        _spheres(axes, part.mobile, _LAYER)
        _spheres(axes, part.chain, _CHAIN)
        _spheres(axes, [part.grain], _GRAIN)
        _join(axes, [part.grain, *part.chain], marker="o", color=BLUE, ms=3, lw=1.3, zorder=4)
        _frame(axes, f"n = {part.layers} layers, {part.name}: {part.height:.2f} d high")
        axes.margins(0.03)
    looks = {"grain": _GRAIN, "layers": _LAYER, "fixed": _FIXED, "chain of its contact": _CHAIN}
    handles = [Circle((0, 0), 1, **look) for look in looks.values()]
    figure.legend(handles, list(looks), loc="outside lower center", ncols=len(looks))
    return figure


def _spheres(axes: Axes, centres: Sequence[Points] | Points, look: dict[str, Any]) -> None:
    for centre in centres:
        axes.add_patch(Circle(_point(centre), 0.5, zorder=2, **look))
    axes.autoscale_view()


def _join(axes: Axes, points: Sequence[Points] | Points, **look: Any) -> None:
    axes.plot(*np.array(points).T, **look)


def _point(position: Points) -> tuple[float, float]:
    return float(position[0]), float(position[1])


def _arrow(
    axes: Axes, tail: Points, vector: Points, colour: str, name: str, *, dashed: bool = False
) -> None:
    tip = tail + _FORCE_SCALE * vector
    axes.annotate(
        "", _point(tip), xytext=_point(tail), zorder=5,
        arrowprops={
            "arrowstyle": "-|>", "color": colour, "lw": 1.8, "shrinkA": 0, "shrinkB": 0,
            "ls": "--" if dashed else "-",
        },
    )  # fmt: skip
    beyond = tip + 0.13 * vector / np.hypot(*vector)
    axes.text(*_point(beyond), name, color=colour, ha="center", va="center", zorder=6)


def _tilt(axes: Axes, first: Points, last: Points, angle_deg: float) -> None:
    """Draw the line of centres, a level one, and the angle between them."""
    reach = 2.4
    level = first + np.array([1.15 * reach, 0.0])
    for end, line in ((last, "-"), (level, "--")):
        _join(axes, [first, end], color="0.35", lw=1, ls=line, zorder=3)
    centre = _point(first)
    axes.add_patch(Arc(centre, 2 * reach, 2 * reach, theta1=-angle_deg, theta2=0, zorder=3))
    axes.text(centre[0] + reach + 0.06, centre[1] - 0.2, "theta", va="center", zorder=4)


def _gravity(axes: Axes, at: tuple[float, float]) -> None:
    axes.annotate(
        "", (at[0], at[1] - 0.5), xytext=at, arrowprops={"arrowstyle": "-|>", "color": BLACK}
    )
    axes.text(at[0] + 0.06, at[1] - 0.25, "g", style="italic", va="center")


def _frame(axes: Axes, title: str) -> None:
    axes.set(aspect="equal", xlabel=_ACROSS, ylabel=_UP)
    axes.set_title(title)
    axes.grid(visible=False)


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
        base = "base not felt"
        if math.isfinite(felt):
            axes.axvline(felt, color=GREEN, ls=":", lw=1.8, label="base felt")
            base = f"base felt at {felt:.2f} t0"
        axes.set_title(f"{run.tower.particles} particles, {base}", fontsize="medium")
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
    figure = force_and_contacts(towers.by_height, towers.largest_force, OF_ALL)
    figure.set_figwidth(_WIDTH)
    return figure
