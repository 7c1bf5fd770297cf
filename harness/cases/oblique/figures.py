"""The figure of the oblique impact: tangential velocity ratio over the angle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.reference import followed
from harness.parameters.contact_rules import Rules
from harness.report.figures.style import BLACK, COLOURS, STYLES, Figure, legend_below, panels

if TYPE_CHECKING:
    from harness.cases.contact_base.study import Climbed
    from harness.cases.oblique.case import Oblique

SHOWN = ("linear_nohistory", "linear_history", "mindlin", "mindlin_rescale")
ANGLES = np.arange(5.0, 86.0, 5.0)


def ratio_over_angle(case: ContactCase[Oblique], climbed: Sequence[Climbed], who: str) -> Figure:
    """Draw the ratio that the laws ask for, Coulomb's where all slides, and an engine's limits."""
    figure = panels(1, 1, width=8.0, height=4.4)
    axes = figure.axes[0]
    walls = [one for one in climbed if one.trial.system == "wall" and one.trial.submodel in SHOWN]
    for number, one in enumerate(walls):
        colour = COLOURS[(number + 1) % len(COLOURS)]
        ratios = [_ratio(case, one.trial.parameters.replace(angle=float(a))) for a in ANGLES]
        axes.plot(ANGLES, ratios, color=colour, ls=STYLES[number], label=one.trial.submodel)
        reached = one.limits["tangential_ratio"].value
        axes.plot(one.trial.parameters.angle, reached, "o", color=colour, mfc="none")
    mu, e = 0.3, 1.0
    slides = 1.0 - mu * (1.0 + e) / np.tan(np.radians(ANGLES))
    beyond = ANGLES[slides > 5.0 / 7.0]
    axes.plot(beyond, slides[slides > 5.0 / 7.0], color=BLACK, lw=0.8, label="sliding, e = 1")
    axes.set(xlabel="angle to the normal (deg)", ylabel="tangential velocity ratio")
    axes.set_title(f"lines: the laws; circles: {who}")
    legend_below(figure, columns=3)
    return figure


def _ratio(case: ContactCase[Oblique], parameters: Oblique) -> float:
    motion = followed(case.scene(parameters), Rules()).motion
    return case.observed(parameters, motion)["tangential_ratio"]
