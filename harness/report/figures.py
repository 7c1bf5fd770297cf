"""Draw the figures that need results alone: divergences, trends, releases and sweeps."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib import colormaps, dates
from matplotlib.axes import Axes
from matplotlib.figure import Figure as AnyFigure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from harness.comparison.releases import ReleaseMatrix, ReleaseRow
from harness.comparison.series import Comparison
from harness.report.style import (
    BLACK,
    BLUE,
    COLOURS,
    GREEN,
    MARKERS,
    ORANGE,
    PURPLE,
    RED,
    Figure,
    house_style,
    label,
    legend_below,
    panels,
    plain_powers,
    power,
    quantity,
)

if TYPE_CHECKING:
    from harness.observables.reference import Points

AROUND = 0.15
"""Part of the record that is shown on either side of the divergence."""

LOWEST = 1e-20
"""A difference below it is drawn as none."""

_UNIT = re.compile(
    r"(?P<name>.+?)_(?P<unit>(?:kg|deg|rad|Ns|Pa|contacts|[mNsJ])(?:_per_[a-zA-Z0-9_]+)?)"
)


def name_and_unit(column: str) -> tuple[str, str]:
    """Return name and unit of a column whose name ends in its unit; ``1`` for one without.

    >>> name_and_unit("vx_m_per_s")
    ('vx', 'm/s')
    """
    match = _UNIT.fullmatch(column)
    if match is None:
        return column.replace("_", " "), "1"
    return match["name"].replace("_", " "), match["unit"].replace("_per_", "/")


def divergence(series: Comparison) -> AnyFigure:
    """Draw run and reference where they diverge, and their difference over all times."""
    moment = series.divergence
    assert moment is not None
    figure = panels(2, 1, width=7.0, height=2.9)
    above, below = figure.axes
    name, unit = name_and_unit(series.column)
    span = float(series.time[-1] - series.time[0])
    start = max(float(series.time[0]), moment.time - AROUND * span)
    end = min(float(series.time[-1]), moment.time + AROUND * span)
    near = (series.time >= start) & (series.time <= end)
    above.plot(
        series.time[near], series.reference[near], color="0.7", linewidth=5,
        label=series.reference_label,
    )  # fmt: skip
    above.plot(
        series.time[near], series.value[near], color=BLUE, linewidth=1.3, label=series.run_label,
        marker="." if near.sum() < 60 else "",
    )  # fmt: skip
    apart = np.abs(series.difference)
    below.semilogy(
        series.time, np.where(apart > LOWEST, apart, np.nan), color=BLACK, linewidth=1.1,
        marker="." if series.time.size < 200 else "", markersize=3,
        label="difference; gaps where it is 0",
    )  # fmt: skip
    below.axhline(
        series.band,
        color="0.4",
        linestyle="--",
        linewidth=1.2,
        label=f"tolerance {series.band:.1e}",
    )
    below.axvspan(start, end, color="0.92", zorder=0)
    when = "from the first step" if moment.from_first_step else f"diverge at {moment.time:.5g} s"
    for axes in (above, below):
        axes.axvline(moment.time, color=RED, linestyle=":", linewidth=1.6, label=when)
    label(above, "", quantity(name, unit), f"{series.case}, around the divergence")
    label(below, "time (s)", quantity("difference", unit), "whole record; shaded: shown above")
    legend_below(figure)
    return figure


Floats = NDArray[np.float64]

SERIES_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, BLACK)
HALF_A_DAY = 0.5
LINE = 90
"""Characters of a name that fit over the axes."""


def trend(frame: pd.DataFrame) -> Figure:
    """Draw one quantity over the date of its runs, with uncertainties and tolerances.

    ``frame`` has a row for each run and the columns
    ``started``, ``engine``, ``engine_version``, ``how``, ``name``, ``unit``,
    ``value``, ``uncertainty``, ``expected``, ``tolerance``, ``verdict``.
    """
    ordered = frame.sort_values("started")
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    x = _by_date(axes, ordered)
    axes.set_xlabel("date of the run (UTC)")
    _around(axes, x)
    _band(axes, x, ordered)
    _points(axes, x, ordered)
    name, unit = str(ordered["name"].iloc[0]), str(ordered["unit"].iloc[0])
    axes.set_ylabel(quantity("value", unit))
    axes.set_title(textwrap.fill(name, LINE))
    legend_below(figure, 5)
    return figure


def _by_date(axes: Axes, frame: pd.DataFrame) -> Floats:
    """Return the start of each run in matplotlib's days, and have the axis show dates."""
    mpl: Any = dates  # its functions have no types
    locator = mpl.AutoDateLocator(maxticks=8)
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(mpl.ConciseDateFormatter(locator))
    return np.asarray(mpl.date2num(frame["started"].to_numpy()), dtype=np.float64)


def _around(axes: Axes, x: Floats) -> None:
    """Leave some room beside the runs, half a day where there is one date alone."""
    margin = 0.04 * float(np.ptp(x)) or HALF_A_DAY
    axes.set_xlim(x.min() - margin, x.max() + margin)


def _band(axes: Axes, x: Floats, frame: pd.DataFrame) -> None:
    """Shade what was expected, give or take the tolerance; it may change from run to run."""
    expected, tolerance = (np.asarray(frame[n], dtype=float) for n in ("expected", "tolerance"))
    if np.isnan(expected).all():
        return
    order = np.argsort(x, kind="stable")
    x, expected, tolerance = x[order], expected[order], tolerance[order]
    # what held at a run holds halfway to its neighbours, and to the ends of the axis
    edges = np.concatenate([axes.get_xlim()[:1], (x[1:] + x[:-1]) / 2, axes.get_xlim()[1:]])
    middle, width = np.append(expected, expected[-1]), np.append(tolerance, tolerance[-1])
    axes.step(edges, middle, where="post", color=BLACK, lw=1.0, ls="--", label="expected")
    if not np.isnan(width).all():
        low, high = middle - width, middle + width
        axes.fill_between(
            edges, low, high, step="post", color="#cccccc", alpha=0.6, lw=0, label="tolerance"
        )


def _points(axes: Axes, x: Floats, frame: pd.DataFrame) -> None:
    value, error = (np.asarray(frame[name], dtype=float) for name in ("value", "uncertainty"))
    engines = [
        f"{engine}, {how}" for engine, how in zip(frame["engine"], frame["how"], strict=True)
    ]
    for index, name in enumerate(dict.fromkeys(engines)):
        of_engine = np.array([other == name for other in engines])
        axes.errorbar(
            x[of_engine],
            value[of_engine],
            yerr=np.nan_to_num(error[of_engine]),
            fmt=MARKERS[index % len(MARKERS)],
            color=SERIES_COLOURS[index % len(SERIES_COLOURS)],
            capsize=3,
            lw=1.2,
            label=name,
        )
    failed = np.asarray(frame["verdict"] == "fail", dtype=bool)
    if failed.any():
        axes.plot(
            x[failed],
            value[failed],
            "o",
            ms=13,
            mfc="none",
            mec=RED,
            mew=1.8,
            label="fails",
            zorder=4,
        )


NONE = 1e-18
"""Where a change of exactly 0 is drawn: below one unit in the last place."""

MOST_ROWS = 60
"""Quantities that are drawn; of more, those that moved most by their tolerance."""

CHANGE_DECADES = (1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0)


def changes(matrix: ReleaseMatrix) -> Figure:
    """Draw the relative change of each quantity against the reference release, and its tolerance.

    No change at all stands at the left edge; what has no value is not drawn.
    """
    rows = _rows(matrix)
    figure = Figure(figsize=(10.0, 2.0 + 0.2 * max(len(rows), 4)), layout="constrained")
    axes = figure.subplots()
    place = np.arange(len(rows))
    scale = np.array([abs(row.cells[matrix.reference].value or 0.0) or 1.0 for row in rows])
    width = np.array([row.tolerance for row in rows]) / scale
    axes.scatter(
        _above_zero(width), place, marker="|", s=60, color="0.45", label="tolerance", zorder=1
    )
    others = [i for i in range(len(matrix.columns)) if i != matrix.reference]
    for n, i in enumerate(others):
        differences = [row.cells[i].difference for row in rows]
        apart = np.array([np.nan if d is None else abs(d) for d in differences])
        axes.scatter(
            _above_zero(apart / scale),
            place + 0.24 * (n - (len(others) - 1) / 2),
            marker=MARKERS[n % 6],
            s=15,
            facecolors="none",
            edgecolors=COLOURS[1 + n % 6],
            label=matrix.columns[i].title,
            zorder=2,
        )
    axes.set_xscale("log")
    axes.set_xlim(NONE / 5, 10.0)
    axes.set_xticks(
        [NONE, *CHANGE_DECADES], ["none", *(f"{decade:.0e}" for decade in CHANGE_DECADES)]
    )
    axes.minorticks_off()
    names = [f"{row.label or row.record}: {name_and_unit(row.quantity)[0]}" for row in rows]
    axes.set_yticks(place, names, fontsize=8.5)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    reference = matrix.columns[matrix.reference].title
    label(axes, f"change over the value, against\n{reference}", "")
    legend_below(figure)
    return figure


def _rows(matrix: ReleaseMatrix) -> list[ReleaseRow]:
    """Return the quantities that are drawn, in the order of the matrix."""
    rows = [row for row in matrix.rows if row.cells[matrix.reference].value is not None]
    if len(rows) <= MOST_ROWS:
        return rows
    most = sorted(range(len(rows)), key=lambda n: _moved(rows[n]), reverse=True)[:MOST_ROWS]
    return [rows[n] for n in sorted(most)]


def _moved(row: ReleaseRow) -> float:
    """Return the largest change of a quantity, in its tolerance."""
    changes = [abs(cell.difference) for cell in row.cells if cell.difference]
    return max(changes, default=0.0) / (row.tolerance or 1.0)


def _above_zero(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.maximum(values, NONE)


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
    same = [name for name in over[2:] if frame[name].nunique(dropna=False) == 1]
    fixed = "".join(f", {_equal(name, frame[name].iloc[0])}" for name in same)
    label(axes, across, up, f"{title}{fixed}{alone}")
    if len(values) > MOST_NAMED:
        _bar(figure, axes, _axis(second or ""), values, colours)
    _legend(figure, _handles(engines, second, values, colours, lines, points))
    plain_powers(figure)
    return figure


DASHES: Mapping[str, Any] = {
    "closed form": "--",
    "integrated": (0, (5, 1.5, 1, 1.5)),
    "equal steps": (0, (5, 1.5, 1, 1.5)),
}
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
    return quantity(f"{name} {symbol}" if symbol and symbol != name else name, unit)


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
