"""Figures of contact cases: errors over the step, force over overlap."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.impact import overlap_of
from harness.report.figures.style import COLOURS, MARKERS, STYLES, Figure, legend_below, panels

if TYPE_CHECKING:
    from harness.cases.contact_base.study import Climbed


def errors_over_step(climbed: Sequence[Climbed], quantity: str, who: str) -> Figure:
    """Draw the error of a quantity over the steps of a contact, one line a submodel."""
    figure = panels(1, 1, width=8.0, height=4.2)
    axes = figure.axes[0]
    for number, one in enumerate(_one_a_submodel(climbed)):
        reached, expected = one.limits.get(quantity), one.references.get(quantity)
        if reached is None or expected is None:
            continue
        error = np.abs(reached.y - expected.value)
        axes.plot(1.0 / reached.h, np.where(error > 0.0, error, np.nan), **_look(number, one))
    axes.set(xscale="log", yscale="log", xlabel="steps of a contact", ylabel=f"error of {quantity}")
    axes.set_title(who)
    legend_below(figure, columns=3)
    return figure


def force_over_overlap(climbed: Sequence[Climbed], who: str) -> Figure:
    """Draw the normal force over the overlap of each submodel, at the finest step."""
    figure = panels(1, 1, width=8.0, height=4.6)
    axes = figure.axes[0]
    for number, one in enumerate(_one_a_submodel(climbed)):
        overlap, _ = overlap_of(one.trial.parameters, one.motion)
        force = one.motion.force[:, 0, 2]
        look = {**_look(number, one), "marker": None}
        axes.plot(1e6 * overlap, force, **look)
    axes.set(xlabel="overlap (µm)", ylabel="force on the sphere (N)")
    axes.set_title(who)
    legend_below(figure, columns=3)
    return figure


def _one_a_submodel(climbed: Sequence[Climbed]) -> list[Climbed]:
    """Return the first trial of each submodel."""
    return list({one.trial.submodel: one for one in reversed(climbed)}.values())[::-1]


def _look(number: int, one: Climbed) -> dict[str, Any]:
    return {
        "color": COLOURS[number % len(COLOURS)],
        "ls": STYLES[number % len(STYLES)],
        "marker": MARKERS[number % len(MARKERS)],
        "mfc": "none",
        "lw": 1.1,
        "label": one.trial.submodel,
    }
