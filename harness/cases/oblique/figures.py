"""Figures of the oblique impact: tangential velocity ratio over the angle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.curves import scanned
from harness.cases.contact_base.motion import Array
from harness.parameters.contact_scene import ZERO
from harness.report.figures.style import BLACK, COLOURS, STYLES, Figure, legend_below, panels
from harness.report.sections import Line, Plot
from harness.shown import in_words
from harness.theory.oblique import slides_throughout, sliding_impulse
from harness.theory.partial_slip import velocity_ratio

if TYPE_CHECKING:
    from harness.cases.contact_base.study import Climbed
    from harness.cases.oblique.case import Oblique

SHOWN = ("linear_nohistory", "linear_history", "mindlin", "mindlin_rescale")
ANGLES = np.array([*range(5, 61, 5), 70.0, 85.0])
"""[deg] Closer where a law takes turns between sticking and sliding."""
AXES = ("angle to the normal (deg)", "tangential velocity ratio")


def ratio_over_angle(case: ContactCase[Oblique], climbed: Sequence[Climbed], who: str) -> Figure:
    """Draw the ratio that the laws ask for, Coulomb's where all slides, and an engine's limits."""
    figure = panels(1, 1, width=8.0, height=4.4)
    axes = figure.axes[0]
    walls = [one for one in climbed if one.trial.system == "wall" and one.trial.submodel in SHOWN]
    for number, one in enumerate(walls):
        colour = COLOURS[(number + 1) % len(COLOURS)]
        name = in_words(one.trial.submodel)
        axes.plot(ANGLES, _ratios(case, one), color=colour, ls=STYLES[number], label=name)
        reached = one.limits["tangential_ratio"].value
        axes.plot(one.trial.parameters.angle, reached, "o", color=colour, mfc="none")
    angles, slides = sliding(0.3, 1.0)
    axes.plot(angles, slides, color=BLACK, lw=0.8, label="sliding throughout, e = 1")
    axes.set(xlabel=AXES[0], ylabel=AXES[1])
    axes.set_title(f"lines: the laws; circles: {who}")
    legend_below(figure, columns=3)
    return figure


def ratio_plot(case: ContactCase[Oblique], cell: Sequence[Climbed], who: str) -> Plot:
    """Return the ratio of one law over the angle, and an engine's limit."""
    one = cell[0]
    angles, slides = sliding(one.finest.friction or 0.0, one.references["normal_restitution"].value)
    slips = tuple(_partial_slip(one))
    told = "with partial slip by Maw, Barber and Fawcett (1976), " if slips else ""
    return Plot(
        "Velocity ratio over the angle",
        f"{one.trial.system}: the law integrated, {told}Coulomb's formula from the angle on where "
        f"all of the contact slides, and {who} in the limit of a small step.",
        *AXES,
        (
            Line("the law", ANGLES, _ratios(case, one)),
            *slips,
            Line("sliding throughout", angles, slides),
            Line(who, [one.finest.angle], [one.limits["tangential_ratio"].value], marked=True),
        ),
    )


def _partial_slip(one: Climbed) -> Iterator[Line]:
    """Yield the curve of an elastic solid sphere on a wall of its material, where one is."""
    law = one.finest
    solid = law.normal == "hertz" and law.damping == "none" and "mindlin" in law.tangential
    if solid and law.friction and law.poisson_ratio is not None and law.partner == "wall":
        ratios = velocity_ratio(ANGLES, law.friction, law.poisson_ratio)
        yield Line("with partial slip", ANGLES, ratios)


def sliding(friction: float, restitution: float) -> tuple[Array, Array]:
    """Return angles [deg] and velocity ratios where a rigid contact slides to its end."""
    angles = np.linspace(5.0, 89.0, 85)
    incidence = np.tan(np.radians(angles))
    slides = incidence > slides_throughout(friction, restitution)
    ratio = 1.0 - sliding_impulse(friction, restitution, 1.0) / incidence
    return angles[slides], ratio[slides]


def _ratios(case: ContactCase[Oblique], one: Climbed) -> Array:
    found = scanned(case, one, "angle", ANGLES.tolist(), lambda changed: (changed.velocity, ZERO))
    return found["tangential_ratio"]
