"""Make the section on series that left the band about their reference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from harness.comparison.divergence import Comparison
from harness.report.sections import Drawing, Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_DIVERGENCES = 6
"""Figures of divergences that a report shows; the rows name them all."""


def divergence_section(series: Sequence[Comparison]) -> Section:
    """Return the figures of the cases that diverged, each by the column that did so first."""
    return Section(
        "Where series diverge",
        drawings=tuple(
            Drawing(
                f"divergence-{number}",
                f"Divergence: {one.case}",
                f"{one.run_label} against {one.reference_label} around the moment at which they "
                "diverge, and their difference over the whole record with its tolerance.",
                partial(_draw, one),
            )
            for number, one in enumerate(first_to_diverge(series)[:MOST_DIVERGENCES], 1)
        ),
    )


def first_to_diverge(series: Sequence[Comparison]) -> list[Comparison]:
    """Return of each case the column that left its band first."""
    first: dict[str, tuple[float, Comparison]] = {}
    for one in series:
        moment = one.divergence
        if moment is not None and moment.time < first.get(one.case, (math.inf, one))[0]:
            first[one.case] = moment.time, one
    return [one for _, one in first.values()]


def _draw(series: Comparison) -> Figure:
    from harness.report.figures.divergence import divergence

    return divergence(series)
