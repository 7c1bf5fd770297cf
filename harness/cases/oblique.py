"""A sphere meets a wall or another sphere at an angle: friction over a whole contact.

The tangential velocity and the spin after the contact. Laws without partial slip, and codes, are
drawn with the whole curve of Maw, Barber and Fawcett (1976).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contact.contact_case import ContactCase, Friction
from harness.cases.contact.impact import impact, relative_velocity
from harness.cases.contact.motion import Array, Motion, reference_motion
from harness.cases.contact.parameters import ContactSystem, Speed, between, check_impact
from harness.cases.contact.report import ContactDisplay
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
from harness.cases.contact.verification import ContactVerification, Evidence
from harness.cases.verification import Study
from harness.comparison.verdicts import finding
from harness.comparison.verification import Findings
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.parameters.scene import ContactScene
from harness.report.sections import Drawing
from harness.report.style import BLACK, COLOURS, MARKERS, STYLES, Figure, legend_below, panels
from harness.shown import in_words
from harness.theory.contact import partial_slip_rebound, stiffness_ratio

LAWS = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
INCIDENCES = np.array([0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0])
FRICTION, POISSON = 0.3, 0.3
DRAWN_STEPS = 400
"""Steps of a contact in the runs of codes that are drawn beside partial slip."""


@dataclass(frozen=True)
class Rebounds:
    """Normalised rebounds (M,) at :data:`INCIDENCES` of a code, and the law that it stated."""

    law: str
    psi: Array = field(repr=False)


@dataclass(frozen=True)
class ObliqueEvidence(Evidence):
    """The trials in an engine, and its rebounds; None where it states no law of Mindlin's."""

    rebounds: Rebounds | None = None


def _elastic(case: ObliqueCase, law: str, psi: float) -> Oblique:
    """Return the impact of an elastic sphere on a wall of its material, 1 m/s along the normal."""
    angle = math.degrees(math.atan(psi * FRICTION / stiffness_ratio(POISSON)))
    return case.default.replace(
        **{**HERTZ, "poisson_ratio": POISSON},
        damping="none",
        tangential=law,
        tangential_damping=0.0,
        friction=FRICTION,
        angle=angle,
        speed=1.0 / math.cos(math.radians(angle)),
        steps_per_contact=DRAWN_STEPS,
    )


def _rebound(psi: float, quantities: Mapping[str, float]) -> float:
    """Return the normalised rebound of the contact point after an impact at incidence psi."""
    slip_ratio = quantities["tangential_ratio"] - quantities["rim_speed_ratio"]
    return psi * slip_ratio / quantities["normal_restitution"]


def expected_rebounds(case: ObliqueCase, law: str) -> Array:
    """Return the normalised rebounds (M,) of a law, by the reference under the default rules."""
    reached = []
    for psi in INCIDENCES:
        parameters = _elastic(case, law, psi)
        values = case.observed(parameters, reference_motion(case.setup(parameters)))
        reached.append(_rebound(psi, values))
    return np.array(reached)


def measured_rebounds(case: ObliqueCase, engine: Engine) -> Rebounds | None:
    """Return the rebounds in an engine, of the first law that it states; NaN for a failed run."""
    for law in LAWS:
        impacts = [_elastic(case, law, psi) for psi in INCIDENCES]
        jobs = [case.job(parameters) for parameters in impacts]
        if not any(engine.refuses(job) for job in jobs):
            break
    else:
        return None
    reached = np.full(len(INCIDENCES), np.nan)
    for place, (parameters, output) in enumerate(zip(impacts, engine.run(jobs), strict=True)):
        if not isinstance(output, EngineError):
            observed = case.observed(parameters, case.motion(parameters, output))
            reached[place] = _rebound(INCIDENCES[place], observed)
    return Rebounds(law, reached)


def partial_slip_figure(laws: Mapping[str, Array], codes: Mapping[str, Rebounds]) -> Figure:
    """Draw Maw's curve, the rebounds of laws as lines, and of codes, by their titles, as marks."""
    figure = panels(1, 1, width=8.0, height=4.4)
    axes = figure.axes[0]
    psi = np.linspace(0.0, INCIDENCES[-1], 121)
    name = "partial slip: Maw, Barber and Fawcett 1976"
    axes.plot(psi, partial_slip_rebound(psi, POISSON), color=BLACK, lw=2.0, label=name)
    for number, (law, reached) in enumerate(laws.items(), 1):
        colour, style = COLOURS[number], STYLES[number]
        axes.plot(INCIDENCES, reached, color=colour, ls=style, label=in_words(law))
    for number, (code, rebounds) in enumerate(codes.items()):
        axes.plot(
            INCIDENCES,
            rebounds.psi,
            MARKERS[number % len(MARKERS)],
            color="0.25",
            mfc="none",
            ms=4.0 + 1.5 * number,
            label=f"{code}, {in_words(rebounds.law)}",
        )
    axes.set(xlabel="normalised incidence", ylabel="normalised rebound")
    legend_below(figure)
    return figure


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
    systems: ClassVar[Told] = {**SYSTEMS, **TWO_MATERIALS}
    two_materials_of = "mindlin"
    submodels = (*Friction.submodels, *RUBBING)
    invariant = submodels
    over_ranks = ("mindlin_rescale/force", "old hooke/history")

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
                parameters.radius * float(motion.angular_velocity[-1, 0, 1]) / along
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

    def run(self, engine: Engine, study: Study) -> Findings:
        """Judge the trials; above level quick run what is drawn beside partial slip, too."""
        findings = super().run(engine, study)
        if study.level != "quick":
            rebounds = study.once(
                (self.case.name, "rebounds", engine.name),
                lambda: measured_rebounds(self.case, engine),
            )
            evidence = findings.evidence
            findings.evidence = ObliqueEvidence(evidence.engine_title, evidence.tried, rebounds)
        return findings

    def run_solvers(self, study: Study) -> Findings:
        """Return how far each law is from the curve, where it is farthest, as findings."""
        if study.level == "quick":
            return super().run_solvers(study)
        expected = partial_slip_rebound(INCIDENCES, POISSON)
        curves = {law: expected_rebounds(self.case, law) for law in LAWS}
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
    """Shows laws and codes beside the curve of partial slip."""

    def drawings(self, solvers: Findings, engines: Mapping[str, Findings]) -> Sequence[Drawing]:
        """Return the rebounds of laws and codes over the incidence, where the laws were run."""
        if not solvers.evidence:
            return ()
        evidences = [findings.evidence for findings in engines.values() if findings.evidence]
        codes = {e.engine_title: e.rebounds for e in evidences if e.rebounds is not None}
        return (
            Drawing(
                "oblique-partial-slip",
                "oblique: laws that stick as a whole beside partial slip",
                "Velocity at the contact after over that before, both over mu times the normal one "
                "and times 2 (1 - nu) / (2 - nu), elastic spheres on a wall of their material, nu "
                "= 0.3. Lines: the laws by the reference; marks: codes. "
                f"{DRAWN_STEPS} steps a contact.",
                lambda: partial_slip_figure(solvers.evidence, codes),
            ),
        )


CASE = ObliqueCase()
