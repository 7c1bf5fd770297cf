"""Sections of bulk cases: means over seeds as a table, curves of all runs as figures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.bulk.mixing import Floats
from harness.cases.bulk.statistics import mean_interval
from harness.report.content import Discs, Drawing, Section, Table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from harness.cases.base import Quantity
    from harness.cases.bulk.base import BulkCase, Sample, Setup
    from harness.engines.base import Output

Line = tuple[Sequence[float] | Floats, Sequence[float] | Floats]  # x and z of its points [m]
MEANS = "Means over the runs, with intervals of 95 % (Student). Times are wall times of runs side "
MEANS += "by side: no comparison of speeds."


@dataclass(frozen=True)
class Curve:
    """A curve of each run: columns ``x`` and ``y`` in SI units and degrees, with their labels.

    ``scale`` are the units of the axes over those of the columns.
    """

    name: str
    title: str
    x: str
    x_label: str
    y: str
    y_label: str
    scale: tuple[float, float] = (1.0, 1.0)


def bulk_section(case: BulkCase[Any], setup: Setup[Any], samples: Mapping[str, Sample]) -> Section:
    """Return the section of a setup: means of each engine, and the curves of all runs."""
    stem = "-".join((case.name, *setup.name.replace(",", "").split()))
    caption = f"A line for each run, {setup.name}."
    if len(samples) > 1:
        caption += " Below: the mean of a code less that of all, with its standard error."
    drawings = tuple(
        Drawing(f"{stem}-{c.name}", c.title, caption, partial(curve_figure, c, samples))
        for c in case.curves
    )
    table = Table("Means", means_table(samples, case.quantities), MEANS)
    title = f"{case.title}: {setup.system}" if setup.system else case.title
    return Section(f"{title}, {setup.name}", case.text, (table,), drawings)


def means_table(samples: Mapping[str, Sample], quantities: Sequence[Quantity[Any]]) -> pd.DataFrame:
    """Return the mean of each quantity and its interval, a column for each engine."""
    import pandas as pd

    columns: dict[str, list[str]] = {"quantity": [f"{q.name} ({q.unit})" for q in quantities]}
    for title, sample in samples.items():
        columns[title] = [_mean_text(sample.values(quantity.name)) for quantity in quantities]
    return pd.DataFrame(columns)


def _mean_text(values: Floats) -> str:
    if np.isnan(values).any():
        return "not measured"
    low, high = mean_interval(values)
    text = f"{values.mean():.4g}"
    return text if math.isnan(low) else f"{text} ({low:.4g} to {high:.4g})"


def curve_figure(curve: Curve, samples: Mapping[str, Sample]) -> Figure:
    """Return a curve of every run, and below it the differences of the engines' means."""
    from scipy.stats import sem

    from harness.report.style import COLOURS, panels

    figure = panels(2 if len(samples) > 1 else 1, 1, 7.0, 2.8)
    above, *below = figure.axes
    across, up = curve.scale
    lines = {
        title: [(across * columns[curve.x], up * columns[curve.y]) for columns in sample.curves]
        for title, sample in samples.items()
    }
    every = [x for of_engine in lines.values() for x, _ in of_engine]
    x = np.linspace(max(one[0] for one in every), min(one[-1] for one in every), 200)
    heights = {title: np.array([np.interp(x, *line) for line in lines[title]]) for title in lines}
    middle = np.concatenate([*heights.values()]).mean(axis=0)
    for colour, (title, values) in zip(COLOURS, heights.items(), strict=False):
        for run, line in enumerate(lines[title]):
            label = None if run else title
            above.plot(*line, color=colour, lw=0.9, alpha=0.7, label=label)
        for axes in below:
            mean = values.mean(axis=0) - middle
            axes.plot(x, mean, color=colour, lw=1.2)
            if len(values) > 1:
                low, high = mean - sem(values), mean + sem(values)
                axes.fill_between(x, low, high, color=colour, alpha=0.25, lw=0.0)
    above.set(ylabel=curve.y_label)
    above.legend()
    for axes in below:
        axes.set(ylabel="difference from the mean")
    figure.axes[-1].set(xlabel=curve.x_label)
    return figure


def plane_section(
    title: str,
    output: Output,
    start: int,
    step: float,
    y: float,
    lines: Sequence[Line],
    radius: Floats | None = None,
) -> Discs:
    """Return the discs in which the plane at ``y`` [m] cuts all particles, from a step on.

    ``lines`` are walls, each x and z of its points [m]; ``radius`` (N,) [m] unless the output has
    it. Colours are heights at the start of the film.
    """
    table = output.table(("step", "x_m", "y_m", "z_m"))
    time = (table["step"] - start) * step
    kept = time >= 0.0
    x, off, z = (table[f"{axis}_m"][kept] for axis in "xyz")
    radius = table["radius_m"][0] if radius is None else radius
    cut = np.sqrt(np.maximum(radius**2 - (off - y) ** 2, 0.0))
    points = [np.array(line, dtype=float).T for line in lines]
    walls = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in points])
    height = np.broadcast_to(z[0], x.shape)
    return Discs(title, time[kept], x, z, cut, lines=walls, value=height,
                 value_label="height at the start (m)")  # fmt: skip
