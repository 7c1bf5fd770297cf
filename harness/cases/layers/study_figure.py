"""The figure of the study: angle of stop against thickness, with what others expect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from harness.cases.layers.changes import Compared
from harness.cases.layers.conclusion import Found
from harness.cases.source_angles import READINGS, source_angles
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints
from harness.report.figures.style import (
    BLACK,
    COLOURS,
    MARKERS,
    ORANGE,
    SKY,
    Figure,
    legend_below,
)
from harness.theory.critical_angle import critical_angle

ASIDE = 0.04
"""Of a thickness, by which the points of two stiffnesses are set apart so that both are seen."""

BESIDE = 7e-4
"""[1/d] between the limits of places, left of zero, so that all are seen."""


def angle_over_thickness(found: Found, points: ReferencePoints | None) -> Figure:
    """Draw means with intervals and fits, the paper's readings, single grain, bulk, a user's."""
    figure = Figure(figsize=(7.4, 5.6), layout="constrained")
    axes = figure.add_subplot()
    last = max(h for _, h in found.angles)
    fine = np.geomspace(1.0, 1.5 * last, 60)
    for number, stiffness in enumerate(found.stiffnesses):
        look: dict[str, Any] = {"color": COLOURS[1 + number % 4]}
        layers = found.layers(stiffness)
        means = [found.mean(stiffness, h) for h in layers]
        beside = 1.0 + ASIDE * (number - (len(found.stiffnesses) - 1) / 2)
        axes.errorbar(
            [h * beside for h in layers],
            [one.value for one in means],
            [one.half_width for one in means],
            marker=MARKERS[number % 6],
            ls="none",
            capsize=3,
            label=f"layers, k d/(m g) = {stiffness:g}",
            **look,
        )
        fit = found.fits.get(stiffness)
        if fit is not None:
            law = rf"${fit.limit.value:.2f} + {fit.amplitude:.2f}\,h^{{-{fit.exponent.value:.2f}}}$"
            name = f"fit at {stiffness:g}: {law}"
            axes.plot(fine, fit.curve(fine), lw=1.0, label=name, **look)
    heights = list(range(1, max(last, 10) + 1))
    expected = [source_angles(n, "deformable") for n in heights]
    for (reading, words), (style, colour) in zip(
        READINGS.items(), (("--", ORANGE), (":", SKY)), strict=True
    ):
        angles = [one[reading] for one in expected]
        name = f"the paper, n deformable particles, {words}"
        axes.plot(heights, angles, style, marker=".", color=colour, label=name)
    axes.axhline(critical_angle(), color=BLACK, lw=0.9, ls="-.",
                 label=f"single grain on a row, {critical_angle():.4f} deg")  # fmt: skip
    low = PEYNEAU_ROUX.value_deg - PEYNEAU_ROUX.uncertainty_deg
    axes.axhspan(low, low + 2 * PEYNEAU_ROUX.uncertainty_deg, color="0.82", zorder=0,
                 label=f"bulk ({PEYNEAU_ROUX.citation})")  # fmt: skip
    if points is not None:
        name = points.name.replace("$", r"\$")  # a file's name is no formula
        axes.plot(points.heights, points.angles_deg, "*", color=BLACK, ms=9, mfc="none", label=name)
    axes.set(xscale="log", xlabel="layers h, particles n", ylabel="angle of stop (deg)")
    ticks = [tick for tick in (1, 2, 4, 8, 12, 20, 40) if tick <= 2 * last]
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.set_ylim(bottom=0.0)
    legend_below(figure, 2)
    return figure


def angle_over_box(places: Sequence[Compared]) -> Figure:
    """Draw the angle of stop against 1/length of the box, with models through three or more."""
    figure = Figure(figsize=(7.4, 4.6), layout="constrained")
    axes = figure.add_subplot()
    for number, some in enumerate(places):
        values = {1.0 / length: mean for length, mean in some.boxes.items()}
        look: dict[str, Any] = {"color": COLOURS[number % len(COLOURS)]}
        axes.errorbar(
            [*values], [one.value for one in values.values()],
            [one.half_width for one in values.values()],
            marker=MARKERS[number % len(MARKERS)], ls="none", capsize=3, label=some.place, **look,
        )  # fmt: skip
        limit = some.box_limit()
        if limit is not None:
            fine = np.linspace(0.0, max(values), 50)
            for model in limit.kept:
                axes.plot(fine, model.curve(fine), lw=0.8, alpha=0.7, **look)
            aside = BESIDE * (1 + number)
            mean = limit.mean
            axes.errorbar(-aside, mean.value, mean.half_width, capsize=3, lw=1.6, **look)
    axes.set(xlabel="1 / length of the box (1/d)", ylabel="angle of stop (deg)")
    axes.set_xlim(left=-BESIDE * (len(places) + 2))
    axes.axvline(0.0, color="0.6", lw=0.7)
    legend_below(figure, 2)
    return figure
