"""The figure of a sweep: its first quantity over the first parameter, a line for each other."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from harness.engines.registry import engine_names, engine_title
from harness.errors import HarnessError
from harness.model.base import unit
from harness.report.style import Figure, axis, label
from harness.workflows.points import Points
from harness.workflows.sweep_plan import SweepPlan

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

LOGARITHMIC = 20.0  # ratio of largest to smallest value from which an axis is logarithmic
MARKERS = "osD^v<>p*h"


def sweep_figure(plan: SweepPlan, frame: pd.DataFrame, points: Points | None) -> Figure | None:
    """Return the figure of a sweep's table; None where the quantity was measured in no run."""
    over, (name, column) = plan.request.over, next(iter(plan.columns().items()))
    across = over[0]
    done = frame[frame["status"] == "done"]
    if across not in done or column not in done or done[column].isna().all():
        return None
    figure = Figure(layout="constrained")
    axes = figure.add_subplot()
    second = [over[1]] if len(over) > 1 and over[1] in done else []
    for place, (key, rows) in enumerate(done.groupby(["engine", *second], sort=False)):
        rows = rows.drop_duplicates(across).sort_values(across)
        error = rows.get(plan.uncertainty_column(name))
        axes.errorbar(rows[across], rows[column], yerr=error, ls=":", ms=5, capsize=2,
                      marker=MARKERS[place % len(MARKERS)], label=_label(key, second))  # fmt: skip
    _draw_closed_form(axes, plan, name, across)
    if points is not None:
        axes.errorbar(points.x, points.y, yerr=points.uncertainty, fmt="kx", label=points.name)
    numbers = done[across].map(lambda v: isinstance(v, (int, float)) and v > 0)
    if numbers.all() and done[across].max() >= LOGARITHMIC * done[across].min():
        axes.set_xscale("log")
    x_unit, y_unit = unit(type(plan.case.default), across), plan.case.quantity(name).unit
    label(axes, axis(across, x_unit), axis(name, y_unit), plan.case.name)
    axes.legend()
    return figure


def _draw_closed_form(axes: Axes, plan: SweepPlan, name: str, across: str) -> None:
    curves: dict[tuple[str, ...], dict[Any, float]] = {}
    for point in plan.points:
        if point.parameters is None or across not in point.swept:
            continue
        try:
            value = plan.case.exact(point.parameters).get(name, math.nan)
            x = float(point.swept[across])
        except (HarnessError, ValueError):
            continue
        others = tuple(text for key, text in point.swept.items() if key != across)
        curves.setdefault(others, {})[x] = value
    for place, curve in enumerate(curves.values()):
        xs = sorted(x for x in curve if math.isfinite(curve[x]))
        if xs:
            title = None if place else "closed form"
            axes.plot(xs, [curve[x] for x in xs], "k-", lw=1, zorder=0, label=title)


def _label(key: Any, second: Iterable[str]) -> str:
    engine, *values = key if isinstance(key, tuple) else (key,)
    title = engine_title(engine) if engine in engine_names() else str(engine)
    return ", ".join([title, *(f"{n} = {v}" for n, v in zip(second, values, strict=True))])
