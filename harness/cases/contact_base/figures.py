"""Figures of contact cases, a panel for each family of submodels: errors, force over overlap."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.impact import overlap_of
from harness.report.figures.style import COLOURS, MARKERS, STYLES, Figure, few_ticks, panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from harness.cases.contact_base.study import Climbed

COLUMNS = 2
BELOW: dict[str, Any] = {
    "ncols": 2,
    "fontsize": "x-small",
    "loc": "upper center",
    "bbox_to_anchor": (0.5, -0.22),
}
"""Where a panel has its legend: inside it would hide lines."""
OLD = "old"
"""The first word of submodels of an earlier interface."""


def errors_over_step(climbed: Sequence[Climbed], quantity: str, words: str, who: str) -> Figure:
    """Draw the error of a quantity over the steps of a contact, one line a submodel.

    ``words`` name it with its unit.
    """
    figure, placed = _panels(climbed)
    steps = sorted({1.0 / h for one in climbed for x in one.limits.values() for h in x.h})
    for axes, members in placed:
        for number, one in enumerate(members):
            reached, expected = one.limits.get(quantity), one.references.get(quantity)
            if reached is not None and expected is not None:
                error = np.abs(reached.y - expected.value)
                error[error == 0.0] = np.nan
                axes.plot(1.0 / reached.h, error, **_look(number, one), marker=MARKERS[number % 6])
        axes.set(
            xscale="log", yscale="log", xlabel="steps of a contact", ylabel=f"error of {words}"
        )
        few_ticks(axes, steps, most=4)
        axes.legend(**BELOW)
    figure.suptitle(who, fontsize="medium", x=0.01, ha="left")
    return figure


def force_over_overlap(climbed: Sequence[Climbed], who: str) -> Figure:
    """Draw the normal force over the overlap of each submodel, at the finest step."""
    figure, placed = _panels(climbed)
    for axes, members in placed:
        for number, one in enumerate(members):
            overlap, _ = overlap_of(one.trial.parameters, one.motion)
            touching = overlap > -0.05 * overlap.max()
            force = one.motion.force[touching, 0, 2]
            axes.plot(1e6 * overlap[touching], force, **_look(number, one))
        axes.set(xlabel="overlap (µm)", ylabel="force on the sphere (N)")
        axes.legend(**BELOW)
    figure.suptitle(who, fontsize="medium", x=0.01, ha="left")
    return figure


def _panels(climbed: Sequence[Climbed]) -> tuple[Figure, list[tuple[Axes, list[Climbed]]]]:
    """Return axes for each family of submodels, the first word of their names."""
    families: dict[str, list[Climbed]] = {}
    for one in {one.trial.submodel: one for one in reversed(climbed)}.values():
        families.setdefault(re.split(r"[ ,_/]", one.trial.submodel)[0], []).insert(0, one)
    names = list(families)[::-1]
    columns = min(COLUMNS, len(names))
    figure = panels(-(-len(names) // columns), columns, width=8.0 / columns, height=3.3)
    for axes in figure.axes[len(names) :]:
        axes.remove()
    placed = []
    for name, axes in zip(names, figure.axes, strict=True):
        axes.set_title("earlier styles" if name == OLD else name)
        placed.append((axes, families[name]))
    return figure, placed


def _look(number: int, one: Climbed) -> dict[str, Any]:
    return {
        "color": COLOURS[number % len(COLOURS)],
        "ls": STYLES[number % len(STYLES)],
        "mfc": "none",
        "lw": 1.2,
        "label": one.trial.submodel.replace("_", " "),
    }
