"""The schematics of the source, to scale: the Quartier system, its forces, its layers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle

from harness.report.figures.style import BLACK, BLUE, GREEN, PURPLE, RED, legend_below
from harness.reproduction.figure_data.schematics import ForceDiagram, Layers, Points, QuartierSystem

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
    for number, sphere in enumerate(_touched(system.spheres, well)):
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


def layers(arranged: Sequence[Layers]) -> Figure:
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


def _touched(spheres: Points, grain: Points) -> list[Points]:
    return [s for s in spheres if abs(float(np.hypot(*(s - grain))) - 1) < 1e-9]


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
