"""The report's section on columns: angles, both readings of the source, and what follows."""

from __future__ import annotations

import math
from collections.abc import Sequence

from harness.cases.case_text import Words
from harness.cases.columns.evidence import Angle, Angles
from harness.cases.source_angles import READINGS
from harness.parameters.tower import LAWS
from harness.report.figures.style import (
    BLACK,
    COLOURS,
    MARKERS,
    STYLES,
    Figure,
    label,
    legend_below,
    panels,
    power,
)
from harness.report.sections import Section, Table
from harness.theory.critical_angle import critical_angle as closed_form

WORDS = Words(__file__)


def sections(angles: Angles) -> Sequence[Section]:
    """Return the section of the angles that were found; none without angles."""
    if not angles.found:
        return ()
    drawing = WORDS.drawing("critical-angle-columns", lambda: figure(angles))
    told = finding_in_words(angles)
    return (
        WORDS.section("columns", paragraphs=told, tables=(_table(angles),), drawings=(drawing,)),
    )


def finding_in_words(angles: Angles) -> list[str]:
    """Return what the angles say against the source's, a sentence for each law."""
    told = []
    for law in LAWS:
        high = [a for a in angles.of(law=law, inside="damped") if a.n > 1]
        if not high:
            continue
        least = min(high, key=lambda a: a.value_deg)
        stiffest = max(a.stiffness for a in high)
        off = max(abs(a.value_deg - closed_form()) for a in high if a.stiffness == stiffest)
        lost = min(a.source_deg["lost"] for a in high)
        words = (
            f"{law.capitalize()} law: the lowest angle over damped columns is "
            f"{least.value_deg:.3f} deg (n = {least.n}, k = {power(least.stiffness)} N/m), "
            f"where the source expects {least.source_deg['lost']:.2f} deg; at k = "
            f"{power(stiffest)} N/m all are within {off:.2g} deg of the {closed_form():.4f} deg of "
            f"one sphere. "
        )
        elastic = angles.of(law=law, inside="elastic")
        if elastic:
            low, top = (f(a.value_deg for a in elastic) for f in (min, max))
            words += f"Over elastic columns the angle is {low:.2f} to {top:.2f} deg. "
        every = [*high, *elastic]
        falls = any(a.value_deg - a.uncertainty_deg <= 0.5 * (lost + closed_form()) for a in every)
        told.append(
            words
            + (
                "Some angle falls as far as half way to the source's."
                if falls
                else f"No angle falls even half way to the source's {lost:.2f} deg: that "
                "impulses spread through a column does not lower the critical angle of this grain."
            )
        )
    return told


def _table(angles: Angles) -> Table:
    head = (
        "law",
        "columns",
        "n",
        "k (N/m)",
        "critical angle (deg)",
        *(f"source, {words} (deg)" for words in READINGS.values()),
    )
    rows = tuple(
        (
            angle.law,
            angle.inside,
            str(angle.n),
            power(angle.stiffness),
            _value(angle),
            *(f"{angle.source_deg[reading]:.3f}" for reading in READINGS),
        )
        for angle in angles.found
    )
    caption = "Uncertainties of elastic columns: half the range in which fates change."
    return Table("columns", caption, head, rows, frozenset(range(2, len(head))))


def _value(angle: Angle) -> str:
    digits = max(1, 1 - math.floor(math.log10(max(angle.uncertainty_deg, 1e-9))))
    return f"{angle.value_deg:.{digits}f} ± {angle.uncertainty_deg:.1g}"


def figure(angles: Angles) -> Figure:
    """Draw the angles over n, a panel a law."""
    found = panels(1, 2)
    for axes, law in zip(found.axes, LAWS, strict=True):
        axes.set_title(f"{law} law")
        groups = sorted({(a.inside, a.stiffness) for a in angles.of(law=law)})
        for i, (inside, k) in enumerate(groups):
            group = angles.of(law=law, inside=inside, stiffness=k)
            axes.errorbar(
                [a.n for a in group],
                [a.value_deg for a in group],
                [a.uncertainty_deg for a in group],
                color=COLOURS[1 + i % 6],
                marker=MARKERS[i % 6],
                linestyle="none" if inside == "elastic" else "-",
                label=f"{inside}, k = {power(k)} N/m",
            )
        heights = sorted({a.n: a for a in angles.of(law=law)}.items())
        for (reading, words), style in zip(READINGS.items(), STYLES[1:], strict=False):
            theory = [a.source_deg[reading] for _, a in heights]
            axes.plot(
                [n for n, _ in heights], theory, color=BLACK, ls=style, label=f"source, {words}"
            )
        axes.axhline(closed_form(), color="0.6", lw=0.8, label="one fixed sphere, 10.2078 deg")
        axes.set_xscale("log", base=2)
        axes.set_xticks([n for n, _ in heights], [str(n) for n, _ in heights])
        label(axes, "particles of a column, n", "critical angle (deg)")
    legend_below(found)
    return found
