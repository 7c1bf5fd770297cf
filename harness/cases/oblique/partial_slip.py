"""Mindlin's laws without partial slip beside the whole curve of Maw, Barber and Fawcett (1976)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.contact_base.motion import Array
from harness.cases.contact_base.submodels import HERTZ
from harness.comparison.findings import Findings
from harness.comparison.verdicts import finding
from harness.parameters.contact_rules import Rules
from harness.report.sections import Drawing
from harness.shown import in_words
from harness.theory.partial_slip import rebound, stiffness_ratio

if TYPE_CHECKING:
    from harness.cases.oblique.case import ObliqueCase
    from harness.report.figures.style import Figure

LAWS = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
INCIDENCES = np.array([0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0])
FRICTION, POISSON = 0.3, 0.3


def beside_partial_slip(case: ObliqueCase) -> Findings:
    """Return how far each law is from the curve, where it is farthest, as findings."""
    expected = rebound(INCIDENCES, POISSON)
    curves = {law: _rebounds(case, law) for law in LAWS}
    found = Findings(case.name, evidence=curves)
    for law, reached in curves.items():
        at = int(np.abs(reached - expected).argmax())
        found.checks.append(
            finding(
                f"{case.name}: {law} beside partial slip, normalised rebound",
                float(reached[at]),
                float(expected[at]),
                "",
                "Maw, Barber and Fawcett (1976): the contact sticks inside and slips outside; the "
                f"law sticks or slips as a whole. Farthest apart at the incidence psi = "
                f"{INCIDENCES[at]:g} of 0.25 to 6, elastic, nu = {POISSON}",
            )
        )
    return found


def _rebounds(case: ObliqueCase, law: str) -> Array:
    """Return psi of the rebound of an elastic sphere on a wall, of one material."""
    kappa = stiffness_ratio(POISSON)
    reached = []
    for psi in INCIDENCES:
        angle = math.degrees(math.atan(psi * FRICTION / kappa))
        parameters = case.default.replace(
            **{**HERTZ, "poisson_ratio": POISSON},
            damping="none",
            tangential=law,
            tangential_damping=0.0,
            friction=FRICTION,
            angle=angle,
            speed=1.0 / math.cos(math.radians(angle)),
        )
        told = case.expected(parameters, Rules())
        left = told["tangential_ratio"].value - told["rim_speed_ratio"].value
        reached.append(psi * left / told["normal_restitution"].value)
    return np.array(reached)


def drawn_beside(curves: Mapping[str, Array]) -> Sequence[Drawing]:
    """Return the figure of the rebound over the incidence; nothing without curves."""
    if not curves:
        return ()
    caption = (
        "Velocity at the contact after over that before, both over mu times the normal one and "
        "times 2 (1 - nu) / (2 - nu), elastic spheres on a wall of their material, nu = 0.3."
    )
    title = "oblique: laws that stick as a whole beside partial slip"
    return (Drawing("oblique-partial-slip", title, caption, lambda: _figure(curves)),)


def _figure(curves: Mapping[str, Array]) -> Figure:
    from harness.report.figures.style import BLACK, COLOURS, STYLES, legend_below, panels

    figure = panels(1, 1, width=8.0, height=4.4)
    axes = figure.axes[0]
    psi = np.linspace(0.0, INCIDENCES[-1], 121)
    name = "partial slip: Maw, Barber and Fawcett 1976"
    axes.plot(psi, rebound(psi, POISSON), color=BLACK, lw=2.0, label=name)
    for number, (law, reached) in enumerate(curves.items(), 1):
        axes.plot(
            INCIDENCES,
            reached,
            color=COLOURS[number],
            ls=STYLES[number],
            marker="o",
            mfc="none",
            label=in_words(law),
        )
    axes.set(xlabel="normalised incidence", ylabel="normalised rebound")
    legend_below(figure)
    return figure
