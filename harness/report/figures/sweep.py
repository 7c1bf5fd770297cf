"""One quantity over one or two parameters of a sweep."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes

from harness.report.figures.divergence import name_and_unit
from harness.report.figures.style import COLOURS, MARKERS, STYLES, Figure, label, legend_below
from harness.report.figures.style import quantity as axis_name

if TYPE_CHECKING:
    from harness.observables.reference import Points

MOST_NAMED = 8
"""Values of the second parameter that a legend names; more are told by a bar of colours."""

DECADES = 30.0
"""Ratio of the largest to the smallest value from which an axis is logarithmic."""


def sweep_figure(
    frame: pd.DataFrame,
    quantity: str,
    over: list[str],
    title: str = "",
    points: Points | None = None,
) -> Figure:
    """Draw a quantity over the first parameter, a line for each value of the second and engine.

    ``frame`` has a row for each run, with the columns of ``over``, ``quantity`` and ``engine``.
    Measured ``points`` are drawn beside it.
    """
    figure = Figure(figsize=(7.0, 4.4), layout="constrained")
    axes = figure.add_subplot()
    x, second = over[0], over[1] if len(over) > 1 else None
    name, unit = name_and_unit(second or "")
    behind = "" if unit == "1" else f" {unit}"
    values = list(dict.fromkeys(frame[second])) if second else [None]
    engines = list(dict.fromkeys(frame["engine"]))
    for number, engine in enumerate(engines):
        of_engine = frame[frame["engine"] == engine]
        for place, value in enumerate(values):
            own = of_engine if second is None else of_engine[of_engine[second] == value]
            named = engine if second is None else f"{name} = {_text(value)}{behind}, {engine}"
            axes.plot(
                own[x].to_numpy(),
                own[quantity].to_numpy(dtype=float),
                marker=MARKERS[number % len(MARKERS)],
                ls=STYLES[number % len(STYLES)],
                color=_colour(place, len(values)) if second else COLOURS[number % len(COLOURS)],
                label=named,
            )
    if points is not None:
        axes.plot(points.x, points.y, "P", color="0.35", mec="white", ms=9, label=points.name)
    _scale(axes, frame[x])
    across, up = (axis_name(*name_and_unit(column)) for column in (x, quantity))
    label(axes, across, up, title)
    if len(values) <= MOST_NAMED:
        legend_below(figure)
    else:
        _bar(figure, axes, axis_name(name, unit), values)
    return figure


def _colour(place: int, count: int) -> Any:
    """Return a colour of a scale that rises in lightness, its palest end left out."""
    return colormaps["cividis"](0.9 * place / max(1, count - 1))


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)


def _scale(axes: Axes, column: pd.Series[Any]) -> None:
    if not pd.api.types.is_numeric_dtype(column):
        return
    low, high = float(np.min(column)), float(np.max(column))
    if low > 0.0 and high > DECADES * low:
        axes.set_xscale("log")


def _bar(figure: Figure, axes: Axes, name: str, values: list[Any]) -> None:
    """Name the values along a bar, in the order in which they were swept."""
    import matplotlib as mpl

    shades = mpl.colors.ListedColormap([_colour(i, len(values)) for i in range(len(values))])
    bounds = mpl.colors.BoundaryNorm(np.arange(len(values) + 1) - 0.5, len(values))
    bar = figure.colorbar(mpl.cm.ScalarMappable(bounds, shades), ax=axes, label=name)
    shown = np.unique(np.linspace(0, len(values) - 1, MOST_NAMED).round().astype(int))
    bar.set_ticks(list(shown), labels=[_text(values[i]) for i in shown])
