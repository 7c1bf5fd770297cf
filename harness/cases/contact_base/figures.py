"""Figures of contact cases, a panel for each family of submodels: errors, force over overlap."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contact_base.impact import overlap_of
from harness.cases.contact_base.scans import curve, rows_of
from harness.parameters.allowed import unit_in
from harness.parameters.contact_rules import Rules
from harness.report.figures import style
from harness.shown import in_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from harness.cases.contact_base.contact_case import ContactCase
    from harness.cases.contact_base.evidence import Climbed
    from harness.cases.contact_base.scans import Scanned

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


def errors_over_step(climbed: Sequence[Climbed], name: str, words: str, who: str) -> style.Figure:
    """Draw the error of a quantity over the steps of a contact, one line a submodel.

    ``words`` name it with its unit.
    """
    figure, placed = _panels(climbed)
    steps = sorted({1.0 / h for one in climbed for x in one.limits.values() for h in x.h})
    for axes, members in placed:
        for number, one in enumerate(members):
            reached, expected = one.limits.get(name), one.references.get(name)
            if reached is not None and expected is not None:
                error = np.abs(reached.y - expected.value)
                error[error == 0.0] = np.nan
                axes.plot(
                    1.0 / reached.h, error, **_look(number, one), marker=style.MARKERS[number % 6]
                )
        axes.set(
            xscale="log", yscale="log", xlabel="steps of a contact", ylabel=f"error of {words}"
        )
        style.few_ticks(axes, steps, most=4)
        axes.legend(**BELOW)
    figure.suptitle(who, fontsize="medium", x=0.01, ha="left")
    return figure


def force_over_overlap(climbed: Sequence[Climbed], who: str) -> style.Figure:
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


def _panels(climbed: Sequence[Climbed]) -> tuple[style.Figure, list[tuple[Axes, list[Climbed]]]]:
    """Return axes for each family of submodels, the first word of their names."""
    families: dict[str, list[Climbed]] = {}
    for one in {one.trial.submodel: one for one in reversed(climbed)}.values():
        families.setdefault(re.split(r"[ ,_/]", one.trial.submodel)[0], []).insert(0, one)
    names = list(families)[::-1]
    columns = min(COLUMNS, len(names))
    figure = style.panels(-(-len(names) // columns), columns, width=8.0 / columns, height=3.3)
    for axes in figure.axes[len(names) :]:
        axes.remove()
    placed = []
    for name, axes in zip(names, figure.axes, strict=True):
        axes.set_title("earlier styles" if name == OLD else name)
        placed.append((axes, families[name]))
    return figure, placed


def _look(number: int, one: Climbed) -> dict[str, Any]:
    return {
        "color": style.COLOURS[number % len(style.COLOURS)],
        "ls": style.STYLES[number % len(style.STYLES)],
        "mfc": "none",
        "lw": 1.2,
        "label": in_words(one.trial.submodel),
    }


def codes_over_parameter(
    case: ContactCase[Any], codes: Sequence[tuple[str, Sequence[Scanned]]]
) -> style.Figure:
    """Draw what codes found, by their titles, on the law under the default rules."""
    shown = sorted({one.family for _, found in codes for one in found})
    figure = style.panels(1, len(shown), width=8.0 / len(shown), height=4.6)
    x, scan = np.array(case.scan.values), case.scan
    fields = type(case.default).model_fields
    unit = unit_in(fields[scan.parameter].description or "")
    units = {one.name: one.unit for one in case.quantities}
    for axes, family in zip(figure.axes, shown, strict=True):
        here = [(who, one) for who, found in codes for one in found if one.family == family]
        for number, name in enumerate(dict.fromkeys(one.submodel for _, one in here)):
            law = curve(case, rows_of(case, name), Rules())
            axes.plot(
                x,
                law,
                color=style.COLOURS[0],
                ls=style.STYLES[number],
                lw=1.0,
                label=in_words(name),
            )
        for who, one in here:
            number = [title for title, _ in codes].index(who)
            colour = style.COLOURS[1 + number % (len(style.COLOURS) - 1)]
            axes.plot(x, one.expected, color=colour, lw=0.7)
            axes.plot(
                x,
                one.found,
                style.MARKERS[number % len(style.MARKERS)],
                color=colour,
                mfc="none",
                ms=4.0 + 1.5 * number,
                label=f"{who} ({one.apart:.0e})",
            )
        name = in_words(scan.quantity, units[scan.quantity])
        axes.set_ylabel(style.quantity(name, units[scan.quantity]))
        axes.set_xlabel(style.quantity(in_words(scan.parameter), unit))
        axes.legend(fontsize="x-small", ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    return figure
