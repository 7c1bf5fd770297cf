"""Sections of bulk cases: means over seeds as a table, curves of all runs as figures; films."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from harness.cases.bulk.beds import Floats
from harness.cases.bulk.samples import Sample, mean_interval
from harness.report.content import Discs, Drawing, Section, Table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from harness.cases.base import Quantity
    from harness.cases.bulk.base import BulkCase, Setup
    from harness.engines.base import Output

Line = tuple[Sequence[float] | Floats, Sequence[float] | Floats]  # x and z of its points [m]
MEANS = "Means over the runs, with intervals of 95 % (Student). Times are wall times of runs side "
MEANS += "by side: no comparison of speeds."


class Curve(NamedTuple):
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
    """Return a curve of every run, each engine in its colour."""
    from harness.report.figures import COLOURS, panels

    figure = panels(1, 1, 7.0, 2.8)
    (axes,) = figure.axes
    across, up = curve.scale
    for colour, (title, sample) in zip(COLOURS, samples.items(), strict=False):
        for run, columns in enumerate(sample.curves):
            line = across * columns[curve.x], up * columns[curve.y]
            axes.plot(*line, color=colour, lw=0.9, alpha=0.7, label=None if run else title)
    axes.set(xlabel=curve.x_label, ylabel=curve.y_label)
    axes.legend()
    return figure


def plane_section(
    title: str, output: Output, time: Floats, y: float, lines: Sequence[Line],
    radius: Floats | None = None,
) -> Discs:  # fmt: skip
    """Return the discs in which the plane at ``y`` [m] cuts all particles, from time 0 [s] on.

    ``lines`` are walls, each x and z of its points [m]; ``radius`` (N,) [m] unless the output has
    it. Colours are heights at the start of the film.
    """
    table = output.table(("step", "x_m", "y_m", "z_m"))
    after = time >= 0.0
    x, off, z = (table[f"{axis}_m"][after] for axis in "xyz")
    radius = table["radius_m"][0] if radius is None else radius
    cut = np.sqrt(np.maximum(radius**2 - (off - y) ** 2, 0.0))
    points = [np.array(line, dtype=float).T for line in lines]
    walls = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in points])
    height = np.broadcast_to(z[0], x.shape)
    return Discs(title, time[after], x, z, cut, lines=walls, value=height,
                 value_label="height at the start (m)")  # fmt: skip
