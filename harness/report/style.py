"""How the figures look: colours that survive colour blindness, line styles that survive grey."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as AnyFigure
from matplotlib.ticker import LogFormatterSciNotation
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from harness.shown import power as power
from harness.shown.figure import Figure as Figure
from harness.shown.figure import house_style as house_style
from harness.shown.figure import label as label
from harness.shown.figure import quantity as quantity

# Okabe and Ito (2008), ordered so that neighbours differ in grey too
BLACK, RED, BLUE, GREEN, PURPLE, ORANGE, SKY = (
    "#000000",
    "#D55E00",
    "#0072B2",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
)
COLOURS = (BLACK, RED, BLUE, GREEN, PURPLE, ORANGE, SKY)
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MARKERS = ("o", "s", "^", "D", "v", "x")


def panels(rows: int, columns: int, width: float = 4.2, height: float = 3.0) -> Figure:
    """Return a figure with ``rows`` by ``columns`` axes, sizes in inches for each."""
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    figure.subplots(rows, columns, squeeze=False)
    return figure


def legend_below(figure: AnyFigure, columns: int = 2, axes: Sequence[Axes] | None = None) -> None:
    """Put one legend below all panels, each name once: inside a panel it would hide lines."""
    placed: dict[str, Any] = {}
    for ax in axes or figure.axes:
        for handle, name in zip(*ax.get_legend_handles_labels(), strict=True):
            placed.setdefault(name, handle)
    figure.legends.clear()
    if placed:
        place: dict[str, Any] = {"loc": "outside lower center", "fontsize": "small"}
        figure.legend([*placed.values()], [*placed], ncols=columns, **place)


MOST_TICKS = 6


def few_ticks(axes: Axes, values: Sequence[float]) -> None:
    """Mark some of sorted values on a logarithmic axis x, written in full."""
    chosen = list(values)[:: max(1, -(-len(values) // MOST_TICKS))]
    axes.set_xticks(chosen, [f"{value:.0f}" for value in chosen])
    axes.minorticks_off()


class PowersOfTen(LogFormatterSciNotation):
    """Numbers on a logarithmic axis in Unicode: mathtext parses each of them for milliseconds."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the text at a place of the axis, 10⁻³ or 2×10⁻³; empty for none."""
        text = super().__call__(x, pos)
        match = re.search(r"(?:(\d+)\\times)?(\d+)\^\{(-?\d+)\}", text)
        if match is None:
            return text
        factor, base, exponent = match.groups()
        return f"{factor + '×' if factor else ''}{base}{exponent.translate(SUPERSCRIPTS)}"


def plain_powers(figure: AnyFigure) -> None:
    """Have the logarithmic axes of a figure write their numbers without mathtext."""
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        if getattr(axis.get_transform(), "base", None) != 10.0:
            continue
        if type(axis.get_major_formatter()) is LogFormatterSciNotation:
            axis.set_major_formatter(PowersOfTen())
        if type(axis.get_minor_formatter()) is LogFormatterSciNotation:
            axis.set_minor_formatter(PowersOfTen())


def lay_out(figure: AnyFigure) -> None:
    """Place the axes of a figure, measuring the words about each of them once.

    Constrained layout solves twice and measures for each pass, which is most of what it costs:
    words hardly change with the size of their axes. Axes that keep a shape are measured twice.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    measured = [axes for axes in figure.axes if axes.get_aspect() == "auto"]
    for axes in measured:
        axes.get_tightbbox = _measured_once(axes)  # type: ignore[method-assign]
    engine.execute(figure)
    for axes in measured:
        del axes.get_tightbbox
    figure.set_layout_engine("none")


def _measured_once(axes: Axes) -> Callable[..., Bbox | None]:
    """Return what gives the box about axes and their words, the words as far out as at first."""
    measure = axes.get_tightbbox
    margins: list[NDArray[np.float64]] = []

    def box(*args: Any, **options: Any) -> Bbox | None:
        if not margins:
            extent = measure(*args, **options)
            if extent is None:
                return None
            margins.append(np.subtract(extent.extents, axes.bbox.extents))
        return Bbox.from_extents(*np.add(axes.bbox.extents, margins[0]))

    return box


def named(law: str, solver: str) -> str:
    """Return model and solver for a legend."""
    return f"{law} law, {solver}"
