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
    from harness.cases.bulk.base import Sample, Setup
    from harness.engines.contract import Output

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


def bulk_section(
    case: str,
    setup: Setup[Any],
    text: str,
    samples: Mapping[str, Sample],
    curves: Sequence[Curve],
    quantities: Sequence[Quantity[Any]],
) -> Section:
    """Return the section of a setup: means of each engine, and the curves of all runs."""
    stem = "-".join((case, *setup.name.replace(",", "").split()))
    drawings = tuple(
        Drawing(
            f"{stem}-{curve.name}",
            curve.title,
            f"A line for each run, {setup.name}. Below: the mean of a code less that of all, with "
            "its standard error."
            if len(samples) > 1
            else f"A line for each run, {setup.name}.",
            partial(curve_figure, curve, samples),
        )
        for curve in curves
    )
    table = Table("Means", means_table(samples, quantities), MEANS)
    return Section(f"{setup.title}, {setup.name}", text, (table,), drawings)


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
    from matplotlib.figure import Figure

    from harness.report.style import COLOURS

    several = len(samples) > 1
    figure = Figure(figsize=(7.0, 5.0 if several else 3.6), layout="constrained")
    ratios = (2, 1) if several else (1,)
    axes = figure.subplots(len(ratios), sharex=True, height_ratios=ratios, squeeze=False)[:, 0]
    lines = {title: _lines(curve, sample) for title, sample in samples.items()}
    ends = [(x[0], x[-1]) for of_engine in lines.values() for x, _ in of_engine]
    x = np.linspace(max(first for first, _ in ends), min(last for _, last in ends), 200)
    heights = {name: np.array([np.interp(x, *line) for line in lines[name]]) for name in lines}
    middle = np.concatenate([*heights.values()]).mean(axis=0)
    for colour, (title, of_engine) in zip(COLOURS, lines.items(), strict=False):
        for seed, line in enumerate(of_engine):
            label = None if seed else title
            axes[0].plot(*line, color=colour, lw=0.9, alpha=0.7, label=label)
        if several:
            _difference(axes[1], x, heights[title] - middle, colour)
    axes[0].set(ylabel=curve.y_label)
    axes[0].legend()
    if several:
        axes[1].set(ylabel="difference from the mean")
    axes[-1].set(xlabel=curve.x_label)
    return figure


def _lines(curve: Curve, sample: Sample) -> list[tuple[Floats, Floats]]:
    across, up = curve.scale
    return [(across * columns[curve.x], up * columns[curve.y]) for columns in sample.curves]


def _difference(axes: Any, x: Floats, values: Floats, colour: str) -> None:
    mean = values.mean(axis=0)
    axes.plot(x, mean, color=colour, lw=1.2)
    if len(values) > 1:
        error = values.std(axis=0, ddof=1) / math.sqrt(len(values))
        axes.fill_between(x, mean - error, mean + error, color=colour, alpha=0.25, lw=0.0)


# ---- films


def plane_section(
    title: str,
    output: Output,
    began: int,
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
    time = (table["step"] - began) * step
    kept = time >= 0.0
    x, off, z = (table[f"{axis}_m"][kept] for axis in "xyz")
    sizes = table["radius_m"][0] if radius is None else radius
    cut = np.sqrt(np.maximum(sizes**2 - (off - y) ** 2, 0.0))
    height = np.broadcast_to(z[0], x.shape)
    pieces = [
        [[xs[i], zs[i]], [xs[i + 1], zs[i + 1]]] for xs, zs in lines for i in range(len(xs) - 1)
    ]
    walls = np.array(pieces, dtype=float).reshape(-1, 2, 2)
    return Discs(
        title,
        time[kept],
        x,
        z,
        cut,
        lines=walls,
        value=height,
        value_label="height at the start (m)",
    )
