"""A recorded quantity over the date of its runs, or over the releases of the engine."""

from __future__ import annotations

import textwrap
from datetime import date, datetime
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib import dates
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.report.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    MARKERS,
    ORANGE,
    PURPLE,
    RED,
    Figure,
    label,
    legend_below,
    quantity,
)

if TYPE_CHECKING:
    import pandas as pd

Against = Literal["date", "version"]
Floats = NDArray[np.float64]

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, BLACK)
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
            told = f"fits {len(names)} quantities, must fit one: {some}"
            raise RequestError(f"--plot: --quantity {told}")
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
        own = np.flatnonzero(versions == release)
        shift = np.linspace(-SPREAD / 2, SPREAD / 2, len(own)) if len(own) > 1 else np.zeros(1)
        x[own] = index + shift
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
    who = [f"{engine}, {how}" for engine, how in zip(frame["engine"], frame["how"], strict=True)]
    for index, name in enumerate(dict.fromkeys(who)):
        own = np.array([other == name for other in who])
        axes.errorbar(
            x[own],
            value[own],
            yerr=np.nan_to_num(error[own]),
            fmt=MARKERS[index % len(MARKERS)],
            color=COLOURS[index % len(COLOURS)],
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
