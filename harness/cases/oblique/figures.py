"""Figures of the oblique impact: tangential velocity ratio over the angle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.curves import ANGLES, OverAngle, scanned
from harness.cases.contact_base.motion import Array
from harness.parameters.contact_scene import ZERO
from harness.report.figures.style import BLACK, COLOURS, STYLES, Figure, legend_below, panels
from harness.shown import in_words
from harness.theory.oblique import slides_throughout, sliding_impulse

if TYPE_CHECKING:
    from harness.cases.contact_base.evidence import Climbed
    from harness.cases.oblique.case import Oblique

SHOWN = ("linear_nohistory", "linear_history", "mindlin", "mindlin_rescale")
AXES = ("angle to the normal (deg)", "tangential velocity ratio")

OVER_ANGLE = OverAngle(
    quantity="tangential_ratio",
    parameter="angle",
    title="Velocity ratio over the angle",
    y=AXES[1],
    value=lambda _, angle: angle,
    angle=lambda parameters: parameters.angle,
    sent=lambda changed: (changed.velocity, ZERO),
    # the velocity at the contact of solid spheres changes by 7/2 of that of the centre
    ratio=lambda _, left: 1.0 - 2.0 / 7.0 * (1.0 - left),
)


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
