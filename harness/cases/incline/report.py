"""Sections of a report on the incline: its contacts, its angles, its figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from harness.cases.display import Display
from harness.cases.incline import figures
from harness.cases.incline.checks import InclineEvidence, rigid_section
from harness.cases.incline.closed_forms import rebound
from harness.cases.incline.engine_checks import OWN, EngineAngle
from harness.cases.incline.figures import angles_of_engines
from harness.cases.incline.film import incline_film, sampling
from harness.cases.incline.system import Incline, job_of
from harness.cases.text import Words
from harness.parameters.law import CLIPPED, PLASTIC
from harness.report.sections import Drawing, Section, Table
from harness.theory.chain import shock_from_restitution
from harness.theory.incline import critical_angle

if TYPE_CHECKING:
    from harness.comparison.verification import Findings
    from harness.engines.contract import Engine, Job
    from harness.report.film import Film

WORDS = Words(__file__)

REBOUNDS = (0.1, 0.5)
"""Restitutions for which the report gives the closed form."""


class InclineDisplay(Display):
    """Shows contacts with their angles, the engines compared, and the grain in motion."""

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the contacts with their angles, restitution, and the engines compared."""
        contacts: list[Section] = []
        if main is not None:
            contacts += [*contact_sections(main.evidence), rigid_section(solvers.evidence or ())]
        angles = [angle for findings in engines.values() for angle in findings.evidence]
        return *contacts, *engine_sections(angles)

    def film_jobs(self, parameters: Incline, frames: int) -> Sequence[Job]:
        """Return the job of steady motion, with its path."""
        return (job_of(parameters, "steady", sampling(parameters)),)

    def film(self, engine: Engine, parameters: Incline, frames: int) -> Film:
        """Return the film of the grain in steady motion."""
        return incline_film(engine, parameters, frames)


def contact_sections(evidence: InclineEvidence) -> Iterator[Section]:
    """Yield what the main engine's runs show."""
    first: tuple[Drawing, ...] = ()
    if evidence.extrapolated is not None:
        extrapolated, closed, engine_name = (
            evidence.extrapolated,
            evidence.closed_form_deg,
            evidence.engine_title,
        )
        first = (
            WORDS.drawing(
                "critical-angle-extrapolation",
                lambda: figures.extrapolation(extrapolated, closed, engine_name),
            ),
        )
    opening = WORDS.opening("critical-angle-extrapolation", closed=evidence.closed_form_deg)
    yield Section(drawings=first, opening=opening)
    yield WORDS.section(
        "contacts",
        items=contacts_explained(),
        tables=tuple(table for table in (angle_table(evidence),) if table.rows),
        drawings=tuple(_drawings(evidence)),
    )


def engine_sections(angles: Sequence[EngineAngle]) -> Iterator[Section]:
    """Yield the section that compares engines; none without an angle."""
    if angles:
        closed = angles[0].expected
        yield WORDS.section(
            "engines",
            tables=(engine_table(angles),),
            drawings=(
                WORDS.drawing("engines-critical-angle", lambda: angles_of_engines(angles, closed)),
            ),
        )


def contacts_explained() -> tuple[str, ...]:
    """Return one sentence on the bias of each contact, and one on contacts that rebound."""
    readings = "; ".join(
        f"e = {e:g}: {critical_angle(shock_from_restitution(e, 'kept')):.2f} deg where the shock "
        f"is the energy kept, {critical_angle(shock_from_restitution(e, 'lost')):.2f} deg where "
        "it is built from the velocity lost"
        for e in REBOUNDS
    )
    return (
        "source (e = 1e-20, tail kept): the attractive tail holds back the contact that is left, "
        "so the angle rises above the closed form by about k^(-1/2) as the step goes to zero; at "
        "50 steps the tail is mostly skipped and the two errors nearly cancel.",
        "clipped (critical damping, no tail): smooth in the step, but its restitution is exp(-2) "
        f"= {rebound(CLIPPED):.3f}, not 0: the grain hops after each shock, and the angle tends to "
        "one a little above the closed form.",
        f"plastic (damping ratio {PLASTIC.zeta:g}, no tail): no tail and hardly a rebound "
        f"({rebound(PLASTIC):.3f}); first order in the step, nearly first order in 1/k. This is "
        "the e = 0 of the theory.",
        f"With restitution the theory of one shock has two readings ({readings}). A grain bounces "
        "several times within a well until its normal velocity has died, so neither describes it: "
        "measure such a contact by steady motion.",
    )


def angle_table(evidence: InclineEvidence) -> Table:
    """Return the angles of the main engine: a row a contact and stiffness, a column a step."""
    every = [angle for angles in evidence.by_contact.values() for angle in angles]
    steps = sorted({angle.case.steps_per_contact for angle in every})
    cells = {
        (a.case.contact.name, a.case.stiffness, a.case.steps_per_contact): (
            f"{a.value_deg:.4f} ± {a.uncertainty_deg:.1g}"
        )
        for a in every
    }
    keys = sorted({key[:2] for key in cells})
    return Table(
        "Critical angles by contact, stiffness and step",
        f"Critical angle (deg) in {evidence.engine_title} by passage, over the steps per contact "
        f"time; closed form {evidence.closed_form_deg:.5f} deg.",
        ("contact", "k (N/m)", *(f"{n:g} steps" for n in steps)),
        tuple((c, f"{k:.3g}", *(cells.get((c, k, n), "") for n in steps)) for c, k in keys),
    )


def engine_table(angles: Sequence[EngineAngle]) -> Table:
    """Return the angles of engines, less theory and less the reference DEM."""
    rows = [
        (
            angle.who,
            angle.contact.name,
            f"{angle.stiffness:.3g}",
            f"{angle.steps_per_contact:.3g}",
            f"{angle.value:.5f} ± {angle.uncertainty:.1g}",
            _signed(angle.difference),
            "" if angle.who == OWN else _signed(angle.off_reference_deg),
            _number(angle.microseconds_per_step, ".2g"),
            f"{angle.contact.tail}, {angle.contact.mass_text}",
            angle.evidence,
        )
        for angle in angles
    ]
    closed = angles[0].expected
    return WORDS.table("Critical angles", rows, closed=closed)


def _drawings(evidence: InclineEvidence) -> Iterator[Drawing]:
    """Yield the figures for which there is evidence."""
    closed, engine_name = evidence.closed_form_deg, evidence.engine_title
    if evidence.by_contact:
        yield WORDS.drawing(
            "contacts-side-by-side",
            lambda: figures.contacts_side_by_side(evidence.by_contact, closed),
        )
    if evidence.motions:
        yield WORDS.drawing(
            "speed-against-time",
            lambda: figures.speed_against_time(evidence.motions, engine_name),
            who=engine_name,
        )
        yield WORDS.drawing(
            "path-over-the-bumps", lambda: figures.path_over_the_bumps(evidence.motions)
        )
    if evidence.recursion is not None:
        recursion = evidence.recursion
        yield WORDS.drawing(
            "energy-after-each-shock",
            lambda: figures.energy_after_each_shock(recursion, engine_name),
        )


def _signed(value: float) -> str:
    return "0" if value == 0.0 else _number(value, "+.2g")


def _number(value: float, form: str) -> str:
    return "" if math.isnan(value) else format(value, form)
