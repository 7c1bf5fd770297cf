"""Draw the figures that need results alone: divergences, history, releases and sweeps."""

from __future__ import annotations

import re
import textwrap
from datetime import date, datetime
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pandas as pd
from matplotlib import dates
from matplotlib.axes import Axes
from matplotlib.figure import Figure as AnyFigure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from harness.comparison.releases import ReleaseMatrix, ReleaseRow
from harness.comparison.series import Comparison
from harness.errors import RequestError
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
    label,
    legend_below,
    panels,
    quantity,
)

if TYPE_CHECKING:
    import pandas as pd


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


Against = Literal["date", "version"]
Floats = NDArray[np.float64]

SERIES_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, BLACK)
SPREAD = 0.5
"""Width over which the runs of one release are spread, in time order; releases are 1 apart."""

HALF_A_DAY = 0.5
LINE = 90
"""Characters of a name that fit over the axes."""


def recorded(frame: pd.DataFrame, against: Against = "date") -> Figure:
    """Draw one quantity of runs over date or release, or how many of their rows failed.

    Raise RequestError where ``frame`` holds no quantity that was measured, or several.
    """
    frame = frame[~frame["cached"]]  # a kept result handed out again is no measurement
    if "name" in frame:
        names = sorted(frame["name"].unique())
        if not names:
            raise RequestError("--plot: no run in the history measured this --quantity")
        if len(names) > 1:
            some = ", ".join(map(repr, names[:3]))
            problem = f"fits {len(names)} quantities, must fit one: {some}"
            raise RequestError(f"--plot: --quantity {problem}")
        return quantity_history(frame, against)
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    if not frame.empty:
        x = _by_date(axes, frame)
        axes.plot(x, frame["failed"].to_numpy(), "o", mfc="none")
        _around(axes, x)
    axes.set_ylim(-0.5, max([1, *frame["failed"]]) + 0.5)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    label(axes, "date of the run (UTC)", "rows that failed")
    return figure


def quantity_history(frame: pd.DataFrame, against: Against) -> Figure:
    """Draw one quantity with its uncertainties and the tolerance that it was held to.

    ``frame`` has a row for each run and the columns of the history:
    ``started``, ``engine``, ``engine_version``, ``how``, ``name``, ``unit``,
    ``value``, ``uncertainty``, ``expected``, ``tolerance``, ``verdict``.
    """
    ordered = frame.sort_values("started")
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    if against == "date":
        x = _by_date(axes, ordered)
        axes.set_xlabel("date of the run (UTC)")
        _around(axes, x)
    else:
        x, releases = _by_release(ordered)
        axes.set_xticks(range(len(releases)), releases)
        axes.set_xlim(-0.5, len(releases) - 0.5)
        axes.set_xlabel("release of the engine")
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


def release_order(version: str) -> tuple[date, str]:
    """Return what sorts releases such as ``22 Jul 2025 - Update 4`` by date, then by update.

    Others come first, by their text.
    """
    day, _, update = version.partition(" - ")
    try:
        return datetime.strptime(day.strip(), "%d %b %Y").date(), update
    except ValueError:
        return date.min, version


def _by_release(frame: pd.DataFrame) -> tuple[Floats, list[str]]:
    """Return where each run stands, and the label of each release, in their order."""
    versions = frame["engine_version"].astype(str)
    releases = sorted(set(versions), key=release_order)
    x = np.empty(len(frame))
    for index, release in enumerate(releases):
        of_release = np.flatnonzero(versions == release)
        shift = (
            np.linspace(-SPREAD / 2, SPREAD / 2, len(of_release))
            if len(of_release) > 1
            else np.zeros(1)
        )
        x[of_release] = index + shift
    return x, [release.replace(" - ", "\n") for release in releases]


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
    axes.scatter(_shown(width), place, marker="|", s=60, color="0.45", label="tolerance", zorder=1)
    others = [i for i in range(len(matrix.columns)) if i != matrix.reference]
    for n, i in enumerate(others):
        differences = [row.cells[i].difference for row in rows]
        apart = np.array([np.nan if d is None else abs(d) for d in differences])
        axes.scatter(
            _shown(apart / scale),
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


def _shown(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.maximum(values, NONE)
