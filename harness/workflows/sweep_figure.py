"""The figure of a sweep: its first quantity over the first parameter, and measured points."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from harness.engines.registry import engine_title
from harness.errors import HarnessError, RequestError
from harness.files import Writer
from harness.model.base import unit
from harness.model.scene import Floats
from harness.report.figures import Figure, axis, house_style, label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from harness.workflows.sweeps import Sweep

LOGARITHMIC = 20.0  # ratio of largest to smallest value from which an axis is logarithmic
MARKERS = "osD^v<>p*h"
UNDATED = {"svg": {"Date": None}, "png": {"Software": None}, "pdf": {"CreationDate": None}}


@dataclass(frozen=True)
class Points:
    """Measured points of a user, with the name of their file."""

    name: str
    x: Floats
    y: Floats
    uncertainty: Floats | None = None


def sweep_figure(sweep: Sweep, points: Points | None = None) -> Figure | None:
    """Return the figure of a sweep; None where the quantity was measured in no run."""
    over, (name, column) = sweep.request.swept, next(iter(sweep.columns.items()))
    frame, across = sweep.to_frame(), over[0]
    done = frame[frame["status"] == "done"]
    if across not in done or column not in done or done[column].isna().all():
        return None
    figure = Figure(layout="constrained")
    axes = figure.add_subplot()
    second = [parameter for parameter in over[1:2] if parameter in done]
    for place, (key, rows) in enumerate(done.groupby(["engine", *second], sort=False)):
        rows = rows.drop_duplicates(across).sort_values(across)
        engine, *values = key
        others = [f"{n} = {v}" for n, v in zip(second, values, strict=True)]
        axes.errorbar(rows[across], rows[column], yerr=rows.get(f"uncertainty_{name}"),
                      ls=":", ms=5, capsize=2, marker=MARKERS[place % len(MARKERS)],
                      label=", ".join([engine_title(str(engine)), *others]))  # fmt: skip
    _draw_closed_form(axes, sweep, name, across)
    if points is not None:
        axes.errorbar(points.x, points.y, yerr=points.uncertainty, fmt="kx", label=points.name)
    numbers = pd.to_numeric(done[across], errors="coerce")
    if (numbers > 0).all() and numbers.max() >= LOGARITHMIC * numbers.min():
        axes.set_xscale("log")
    x_unit, y_unit = unit(type(sweep.case.default), across), sweep.case.quantity(name).unit
    label(axes, axis(across, x_unit), axis(name, y_unit), sweep.case.name)
    axes.legend()
    return figure


def _draw_closed_form(axes: Axes, sweep: Sweep, name: str, across: str) -> None:
    curves: dict[tuple[str, ...], dict[float, float]] = {}
    for point in sweep.points:
        try:
            value = sweep.case.exact(point.parameters).get(name, math.nan)
            x = float(point.swept[across])
        except (HarnessError, AttributeError, KeyError, ValueError):  # refused, or a word
            continue
        others = tuple(text for key, text in point.swept.items() if key != across)
        if math.isfinite(value):
            curves.setdefault(others, {})[x] = value
    for place, curve in enumerate(curves.values()):
        axes.plot(
            *zip(*sorted(curve.items()), strict=True),
            "k-",
            lw=1,
            zorder=0,
            label=None if place else "closed form",
        )


def figure_writer(draw: Callable[[], Any]) -> Writer:
    """Return a function that writes a figure, by its suffix; the same figure is the same file."""

    def write(path: Path) -> None:
        kind = path.suffix.lower().removeprefix(".")
        with house_style():
            draw().savefig(path, format=kind, metadata=UNDATED[kind])

    return write


def read_points(path: Path, x: str, y: str, uncertainties: Sequence[str] = ()) -> Points:
    """Return the points of columns ``x`` and ``y``; their errors from the first such column.

    Raise RequestError in a line for a bad file.
    """
    option = f"--reference {path}"
    if path.exists() and not path.is_file():
        raise RequestError(f"{option}: is no file")
    try:
        frame = pd.read_csv(path, comment="#", skipinitialspace=True, encoding="utf-8-sig")
    except OSError as error:
        raise RequestError(f"{option}: {error.strerror or error}") from None
    except ValueError as error:  # also of pandas, and of text that is not UTF-8
        raise RequestError(f"{option}: is no CSV table ({' '.join(str(error).split())})") from None
    for name in (x, y):
        if name not in frame:
            columns = ", ".join(map(str, frame.columns))
            raise RequestError(f"{option}: has no column {name!r}, but {columns}")
    if frame.empty:
        raise RequestError(f"{option}: has no rows")
    uncertainty = next((name for name in uncertainties if name in frame), "")
    names = (x, y, uncertainty) if uncertainty else (x, y)
    numbers = {name: pd.to_numeric(frame[name], errors="coerce") for name in names}
    for name, values in numbers.items():
        for row in np.flatnonzero(~np.isfinite(values)):
            value = frame[name].iloc[row]
            raise RequestError(f"{option}, row {row + 2}: {name} = {value!r}: must be a number")
    errors = numbers.get(uncertainty)
    if errors is not None and (errors < 0.0).any():
        raise RequestError(f"{option}: {uncertainty} must not be negative")
    return Points(path.name, *(values.to_numpy(float) for values in numbers.values()))
