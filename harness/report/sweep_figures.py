"""Draw a sweep: a quantity over a parameter, what it is expected to be, a user's own points."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from harness.report.figures import name_and_unit
from harness.report.style import (
    BLACK,
    COLOURS,
    MARKERS,
    Figure,
    house_style,
    label,
    plain_powers,
    power,
)
from harness.report.style import quantity as axis_name

if TYPE_CHECKING:
    from harness.observables.reference import Points

MOST_NAMED = 8
"""Values of the second parameter that a legend names; more are told by a bar of colours."""

DECADES = 30.0
"""Ratio of the largest to the smallest value from which an axis is logarithmic."""

SYMBOLS: Mapping[str, str] = {
    "angle": "θ",
    "damping ratio": "ζ",
    "density": "ρ",
    "diameter": "d",
    "friction": "μ",
    "gravity": "g",
    "mass": "m",
    "n": "n",
    "normal stiffness": "k_n",
    "poisson ratio": "ν",
    "radius": "R",
    "restitution": "e",
    "speed": "v",
    "stiffness": "k",
    "tangential stiffness": "k_t",
    "youngs modulus": "E",
}
"""Of parameters, as all figures write them."""

DENSE = 81
"""Points of a line of what is expected, where one costs little."""


@dataclass(frozen=True)
class ReferenceLine:
    """What a quantity is expected to be over the first parameter, ``kind`` as of a reference.

    Of one value of the ``second`` parameter, None for all, and of ``engines`` by their titles,
    none for all.
    """

    kind: str
    x: tuple[Any, ...]
    y: tuple[float, ...]
    second: Any = None
    engines: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Return what a legend calls it."""
        return f"{self.kind} ({', '.join(self.engines)})" if self.engines else self.kind


def is_logarithmic(values: Iterable[Any]) -> bool:
    """Return whether an axis of these values is logarithmic: positive, over many decades."""
    numbers = list(values)
    if any(isinstance(value, (str, bool, np.bool_)) for value in numbers):
        return False
    low, high = float(np.min(numbers)), float(np.max(numbers))
    return low > 0.0 and high > DECADES * low


@house_style()
def sweep_figure(
    frame: pd.DataFrame,
    quantity: str,
    over: Sequence[str],
    title: str = "",
    lines: Sequence[ReferenceLine] = (),
    points: Points | None = None,
) -> Figure:
    """Draw a quantity over the first parameter, a colour for each value of the second.

    ``frame`` has a row for each run, with the columns of ``over``, ``quantity`` and ``engine``,
    and error bars where it has the quantity's ``uncertainty``. An engine has a marker of its own.
    Dashed ``lines`` are what is expected, measured ``points`` are drawn beside.
    """
    figure = Figure(figsize=(7.0, 4.8), layout="constrained")
    axes = figure.add_subplot()
    x, second = over[0], over[1] if len(over) > 1 else None
    values = list(dict.fromkeys(frame[second])) if second else [None]
    engines = list(dict.fromkeys(frame["engine"]))
    colours = _colours(len(values) if second else len(engines))
    unit = name_and_unit(quantity)[1].replace("/", "_per_")
    error = "uncertainty" if unit == "1" else f"uncertainty_{unit}"
    for number, engine in enumerate(engines):
        of_engine = frame[frame["engine"] == engine]
        for place, value in enumerate(values):
            chosen = of_engine if second is None else of_engine[of_engine[second] == value]
            axes.errorbar(
                chosen[x].to_numpy(),
                chosen[quantity].to_numpy(dtype=float),
                yerr=chosen[error].fillna(0.0).to_numpy(dtype=float) if error in chosen else None,
                marker=MARKERS[number % len(MARKERS)],
                mfc="none" if number else None,
                lw=1.0,
                capsize=2.5,
                color=colours[place if second else number],
            )
    lines = [line for line in lines if line.second is None or line.second in values]
    for line in lines:
        colour = BLACK if line.second is None else colours[values.index(line.second)]
        axes.plot(line.x, line.y, ls=DASHES[line.kind], lw=1.3, color=colour, zorder=3)
    if points is not None:
        axes.errorbar(points.x, points.y, yerr=points.errors, color=OWN, **OWN_LOOK)
    _scale(axes, frame[x], frame[quantity])
    across, up = (_axis(column) for column in (x, quantity))
    alone = f", {engines[0]}" if second and len(engines) == 1 else ""
    fixed = "".join(f", {_equal(name, frame[name].iloc[0])}" for name in over[2:])
    label(axes, across, up, f"{title}{fixed}{alone}")
    if len(values) > MOST_NAMED:
        _bar(figure, axes, _axis(second or ""), values, colours)
    _legend(figure, _handles(engines, second, values, colours, lines, points))
    plain_powers(figure)
    return figure


DASHES: Mapping[str, Any] = {"closed form": "--", "integrated": (0, (5, 1.5, 1, 1.5))}
"""Of what is expected, by where it comes from."""

OWN = "#555555"
OWN_LOOK: Mapping[str, Any] = {
    "fmt": "P", "ms": 9, "mec": "white", "capsize": 3, "lw": 1.3, "zorder": 4,
}  # fmt: skip
"""Of a user's own points."""


def _handles(
    engines: Sequence[str],
    second: str | None,
    values: Sequence[Any],
    colours: Sequence[Any],
    lines: Sequence[ReferenceLine],
    points: Points | None,
) -> list[Line2D]:
    """Return what a legend names: values by colour, engines by marker, theory, own points."""
    handles = []
    if second and len(values) <= MOST_NAMED:
        marker = MARKERS[0] if len(engines) == 1 else ""
        handles += [
            Line2D([], [], color=colour, marker=marker, label=_equal(second, value))
            for value, colour in zip(values, colours, strict=True)
        ]
    if not second or len(engines) > 1:
        handles += [
            Line2D(
                [], [], marker=MARKERS[number % len(MARKERS)], mfc="none" if number else None,
                lw=0.0 if second else 1.0, color="0.3" if second else colours[number], label=name,
            )
            for number, name in enumerate(engines)
        ]  # fmt: skip
    for name, kind in {line.name: line.kind for line in lines}.items():
        handles.append(Line2D([], [], color=BLACK, ls=DASHES[kind], lw=1.3, label=name))
    if points is not None:
        look: dict[str, Any] = {"marker": "P", "ms": 9, "mec": "white", "lw": 0.0}
        handles.append(Line2D([], [], color=OWN, label=points.name, **look))
    return handles


def _legend(figure: Figure, handles: Sequence[Line2D]) -> None:
    if handles:
        place: dict[str, Any] = {"loc": "outside lower center", "fontsize": "small"}
        figure.legend(handles=handles, ncols=min(4, len(handles)), **place)


def _colours(count: int) -> list[Any]:
    """Return a colour for each: those of all figures, of many a scale that rises in lightness."""
    if count < len(COLOURS):
        return list(COLOURS[1 : count + 1])
    return [colormaps["cividis"](0.9 * place / max(1, count - 1)) for place in range(count)]


def _words(column: str) -> tuple[str, str, str]:
    """Return name, symbol and unit of a column; of one with a symbol its last name."""
    name, unit = name_and_unit(column)
    last = name.rpartition(".")[2]
    return (last, SYMBOLS[last], unit) if last in SYMBOLS else (name, "", unit)


def _axis(column: str) -> str:
    name, symbol, unit = _words(column)
    return axis_name(f"{name} {symbol}" if symbol and symbol != name else name, unit)


def _equal(column: str, value: Any) -> str:
    """Return a parameter and its value, as ``k = 1e5 N/m``."""
    name, symbol, unit = _words(column)
    return f"{symbol or name} = {_text(value)}{'' if unit == '1' else f' {unit}'}"


def _text(value: Any) -> str:
    number = isinstance(value, (int, float, np.integer, np.floating)) and value is not True
    if not number or value is False:
        return str(value)
    size = abs(float(value))
    return power(value) if size and not 1e-3 <= size < 1e4 else f"{value:g}"


def _scale(axes: Axes, across: pd.Series[Any], up: pd.Series[Any]) -> None:
    if is_logarithmic(across):
        axes.set_xscale("log")
        if is_logarithmic(up):
            axes.set_yscale("log")


def _bar(
    figure: Figure, axes: Axes, name: str, values: Sequence[Any], colours: Sequence[Any]
) -> None:
    """Name the values along a bar, in the order in which they were swept."""
    import matplotlib as mpl

    shades = mpl.colors.ListedColormap(list(colours))
    bounds = mpl.colors.BoundaryNorm(np.arange(len(values) + 1) - 0.5, len(values))
    bar = figure.colorbar(mpl.cm.ScalarMappable(bounds, shades), ax=axes, label=name)
    ticks = np.unique(np.linspace(0, len(values) - 1, MOST_NAMED).round().astype(int))
    bar.set_ticks(list(ticks), labels=[_text(values[i]) for i in ticks])
