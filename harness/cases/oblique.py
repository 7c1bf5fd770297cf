"""A sphere meets a wall or another sphere at an angle: friction over a whole contact.

The tangential velocity and the spin after the contact. Laws without partial slip are drawn with the
whole curve of Maw, Barber and Fawcett (1976).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contact.contact_case import ContactCase, Friction
from harness.cases.contact.impact import impact, relative_velocity
from harness.cases.contact.limits import Evidence, RefinedTrial, Scan
from harness.cases.contact.motion import Array, Motion
from harness.cases.contact.parameters import ContactSystem, Speed, between, check_impact
from harness.cases.contact.report import ANGLES, ContactDisplay, OverAngle, expected_scan
from harness.cases.contact.submodels import (
    HERTZ,
    OBLIQUE,
    ROLLING_UNDAMPED,
    RUBBING,
    SLIDING,
    SYSTEMS,
    TWO_MATERIALS,
    Told,
)
from harness.cases.contact.verification import ContactVerification
from harness.cases.verification import Study
from harness.comparison.verdicts import finding
from harness.comparison.verification import Findings
from harness.parameters.rules import Rules
from harness.parameters.scene import ZERO, ContactScene
from harness.report.sections import Drawing, Section
from harness.report.style import BLACK, COLOURS, STYLES, Figure, legend_below, panels
from harness.shown import in_words
from harness.theory.contact import (
    partial_slip_rebound,
    slides_throughout,
    sliding_impulse,
    stiffness_ratio,
)

LAWS = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
INCIDENCES = np.array([0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0])
FRICTION, POISSON = 0.3, 0.3


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
        references = case.expected(parameters, Rules())
        slip_ratio = references["tangential_ratio"].value - references["rim_speed_ratio"].value
        reached.append(psi * slip_ratio / references["normal_restitution"].value)
    return np.array(reached)


def _figure(curves: Mapping[str, Array]) -> Figure:
    figure = panels(1, 1, width=8.0, height=4.4)
    axes = figure.axes[0]
    psi = np.linspace(0.0, INCIDENCES[-1], 121)
    name = "partial slip: Maw, Barber and Fawcett 1976"
    axes.plot(psi, partial_slip_rebound(psi, POISSON), color=BLACK, lw=2.0, label=name)
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
    ratio=lambda _, rim_ratio: 1.0 - 2.0 / 7.0 * (1.0 - rim_ratio),
)


def ratio_over_angle(
    case: ContactCase[Oblique], trials: Sequence[RefinedTrial], engine_title: str
) -> Figure:
    """Draw the laws' expected ratios, Coulomb's under gross sliding, and an engine's limits."""
    figure = panels(1, 1, width=8.0, height=4.4)
    axes = figure.axes[0]
    walls = [
        refined
        for refined in trials
        if refined.trial.system == "wall" and refined.trial.submodel in SHOWN
    ]
    for number, refined in enumerate(walls):
        colour = COLOURS[(number + 1) % len(COLOURS)]
        name = in_words(refined.trial.submodel)
        axes.plot(ANGLES, _ratios(case, refined), color=colour, ls=STYLES[number], label=name)
        reached = refined.limits["tangential_ratio"].value
        axes.plot(refined.trial.parameters.angle, reached, "o", color=colour, mfc="none")
    angles, slides = sliding(0.3, 1.0)
    axes.plot(angles, slides, color=BLACK, lw=0.8, label="sliding throughout, e = 1")
    axes.set(xlabel=AXES[0], ylabel=AXES[1])
    axes.set_title(f"lines: the laws; circles: {engine_title}")
    legend_below(figure, columns=3)
    return figure


def sliding(friction: float, restitution: float) -> tuple[Array, Array]:
    """Return angles [deg] and velocity ratios where a rigid contact slides to its end."""
    angles = np.linspace(5.0, 89.0, 85)
    incidence = np.tan(np.radians(angles))
    slides = incidence > slides_throughout(friction, restitution)
    ratio = 1.0 - sliding_impulse(friction, restitution, 1.0) / incidence
    return angles[slides], ratio[slides]


def _ratios(case: ContactCase[Oblique], refined: RefinedTrial) -> Array:
    scan = expected_scan(
        case, refined, "angle", ANGLES.tolist(), lambda changed: (changed.velocity, ZERO)
    )
    return scan["tangential_ratio"]


LEAST_ANGLE = 1e-6
"""[deg]: ratios of velocities are known to 1e-16 over its sine, 1e-8."""


class Oblique(ContactSystem):
    """An impact at an angle to the normal, in SI units and degrees."""

    speed: Speed = Field(1.0, description="[m/s] of the approach")
    angle: float = Field(45.0, ge=0.0, lt=90.0, description="[deg] to the normal")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        along, _, down = self.velocity
        check_impact(self, "speed", "m/s", -down, lambda speed: speed * self.speed / -down)
        if along:
            why = "0, or more than what rounding leaves of the velocity along the surface"
            between("angle", self.angle, "deg", (LEAST_ANGLE, 90.0), why)

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Return the velocity of the sphere [m/s]: along x and down."""
        angle = math.radians(self.angle)
        return (self.speed * math.sin(angle), 0.0, -self.speed * math.cos(angle))


class ObliqueCase(Friction, ContactCase[Oblique]):
    """A sphere meets a wall or a sphere at an angle: velocity ratios and spin."""

    name = "oblique"
    verified_by = "harness.cases.oblique:ObliqueVerification"
    shown_by = "harness.cases.oblique:ObliqueDisplay"
    sets: ClassVar[Told] = {"usual": SLIDING, **OBLIQUE}
    other_submodels = (*Friction.other_submodels, *ROLLING_UNDAMPED)
    drawn_quantity = "tangential_ratio"
    over_angle = OVER_ANGLE
    systems: ClassVar[Told] = {**SYSTEMS, **TWO_MATERIALS}
    two_materials_of = "mindlin"
    submodels = (*Friction.submodels, *RUBBING)
    invariant = submodels
    over_ranks = ("mindlin_rescale/force", "old hooke/history")
    scan = Scan("tangential_ratio", "angle", (5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 85.0))

    def scene(self, parameters: Oblique) -> ContactScene:
        """Return the impact; samples before and after it."""
        return impact(parameters, parameters.velocity, finely=False)

    def observed(self, parameters: Oblique, motion: Motion) -> Mapping[str, float]:
        """Return ratios of the velocities after to those before; tangential ones at an angle."""
        along, _, down = parameters.velocity
        before, after = relative_velocity(motion)[[0, -1]]
        quantities = {"normal_restitution": float(after[2]) / -down}
        if along > 0.0:
            quantities["tangential_ratio"] = float(after[0]) / along
            quantities["rim_speed_ratio"] = (
                parameters.radius * float(motion.omega[-1, 0, 1]) / along
            )
            impulses = before[0] - after[0], after[2] - before[2]
            quantities["tangential_impulse_ratio"] = float(impulses[0] / impulses[1])
        return quantities

    def sizes(self, parameters: Oblique) -> Mapping[str, float]:
        """Return Coulomb's limit of the impulses' ratio, 1 at most: a larger one is not reached."""
        return {"tangential_impulse_ratio": min(parameters.friction or 1.0, 1.0)}


class ObliqueVerification(ContactVerification):
    """Compares Mindlin's laws, which stick as a whole, with partial slip, too."""

    case: ObliqueCase

    def run_solvers(self, study: Study) -> Findings:
        """Return how far each law is from the curve, where it is farthest, as findings."""
        if study.level == "quick":
            return super().run_solvers(study)
        expected = partial_slip_rebound(INCIDENCES, POISSON)
        curves = {law: _rebounds(self.case, law) for law in LAWS}
        findings = Findings(self.case.name, evidence=curves)
        for law, reached in curves.items():
            at = int(np.abs(reached - expected).argmax())
            findings.checks.append(
                finding(
                    f"{self.case.name}: {law} beside partial slip, normalised rebound",
                    float(reached[at]),
                    float(expected[at]),
                    "",
                    "Maw, Barber and Fawcett (1976): the contact sticks inside and slips outside; "
                    "the law sticks or slips as a whole. Farthest apart at the incidence psi = "
                    f"{INCIDENCES[at]:g} of 0.25 to 6, elastic, nu = {POISSON}",
                )
            )
        return findings


class ObliqueDisplay(ContactDisplay):
    """Shows velocity ratios over the angle, and the curve of partial slip."""

    def drawings(self, evidence: Evidence) -> Sequence[Drawing]:
        """Return the velocity ratio over the angle, and the errors."""
        over_angle = Drawing(
            "oblique-ratio",
            "oblique: velocity ratio over the angle",
            "Tangential velocity after over that before, by law, for a sphere on a wall.",
            lambda: ratio_over_angle(self.case, evidence.refined, evidence.engine_title),
        )
        return (over_angle, *super().drawings(evidence))

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Add the curve of partial slip to the sections of a contact case."""
        sections = super().sections(main, solvers, engines)
        if not solvers.evidence:
            return sections
        slip = Drawing(
            "oblique-partial-slip",
            "oblique: laws that stick as a whole beside partial slip",
            "Velocity at the contact after over that before, both over mu times the normal one and "
            "times 2 (1 - nu) / (2 - nu), elastic spheres on a wall of their material, nu = 0.3.",
            lambda: _figure(solvers.evidence),
        )
        return [replace(section, drawings=(*section.drawings, slip)) for section in sections]


CASE = ObliqueCase()
