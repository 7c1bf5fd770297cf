"""The frictionless incline as a case."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from harness.cases.contract import Case, LevelName, Measured, Part, Reference, Study, rows_of_parts
from harness.cases.incline.levels import REGRESSION, run_seconds
from harness.cases.incline.runs import read
from harness.cases.incline.searched import InclineSearch, SearchedAngle
from harness.cases.incline.system import NAME, TEMPLATE, Incline, job_of
from harness.comparison.verdicts import Check, Planned
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Job, Output
from harness.engines.traits import Traits
from harness.parameters.law import CONTACTS
from harness.report.sections import Section

if TYPE_CHECKING:
    from harness.cases.incline.angle import CriticalAngle
    from harness.cases.incline.engine_checks import EngineAngle
    from harness.report.film import Film

STEPS = {"plastic": 100.0}
"""Steps per contact time of a preset, where they are not the default."""


class InclineCase(Case[Incline]):
    """A grain on a tilted row of fixed spheres without friction: the critical angle."""

    name = NAME
    group = "incline"
    template = TEMPLATE
    solvers = ("hard-sphere",)
    regression = REGRESSION

    @property
    def presets(self) -> Mapping[str, Incline]:
        """Return a run for each named contact."""
        return {
            name: Incline(contact=contact, steps_per_contact=STEPS.get(name, 50.0))
            for name, contact in CONTACTS.items()
        }

    def derived(self) -> Sequence[Case[InclineSearch]]:
        """Return the critical angle."""
        return (_ANGLE,)

    def job(self, parameters: Incline) -> Job:
        """Return the job of one passage."""
        return job_of(parameters, "passage")

    def read(self, parameters: Incline, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return what became of one passage; raise EngineOutputError for a bad output."""
        return read(parameters, "passage", output, traits.spring).quantities

    def references(self, parameters: Incline, traits: Traits) -> Mapping[str, Reference]:
        """Return the margin of rigid spheres; none for a contact that rebounds."""
        from harness.cases.incline.closed_forms import ONE_SHOCK, rebound
        from harness.theory.chain import SHOCK_WITHOUT_REBOUND
        from harness.theory.incline import passage_margin

        if rebound(parameters.contact) > ONE_SHOCK:
            return {}
        margin = passage_margin(parameters.angle, SHOCK_WITHOUT_REBOUND)
        return {"margin_over_mgd": Reference(margin, "closed form")}

    def solve(self, parameters: Incline, solver: str) -> Measured:
        """Follow the grain over rigid spheres, from event to event."""
        from harness.cases.incline.checks import solve_rigid

        if solver not in self.solvers:
            return super().solve(parameters, solver)
        return solve_rigid(parameters)

    def seconds(self, parameters: Incline, rules: Traits | None, solver: str = "") -> float:
        """Return what one passage is expected to take an engine of these rules [s]."""
        return 0.0 if rules is None else run_seconds(parameters, "passage", rules)

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks of a level; one for each run that an engine refuses."""
        from harness.cases.incline.verification import planned

        return planned(level, engine)

    def verify(self, engine: Engine, study: Study) -> Findings:
        """Hold an engine against the closed form, the reference DEM and itself.

        Of an engine beside the main one the critical angles, against theory and the reference DEM.
        """
        if study.role == "other":
            return self._angles(engine, study)
        from harness.cases.incline.checks import InclineEvidence, Verifying
        from harness.cases.incline.verification import incline_checks
        from harness.theory.incline import critical_angle

        evidence = InclineEvidence(engine.title, critical_angle())
        findings = Findings(self.name, engine.name, evidence=evidence)
        findings.checks += incline_checks(Verifying(engine, study, findings, evidence))
        findings.records[:] = {record.name: record for record in findings.records}.values()
        every = [angle for angles in evidence.by_contact.values() for angle in angles]
        extrapolated = evidence.extrapolated
        findings.published = {
            "closed_form_deg": evidence.closed_form_deg,
            "extrapolated": extrapolated.to_json() if extrapolated else None,
            "critical_angles": [angle.to_json() for angle in (*every, *evidence.routes)],
        }
        return findings

    def verify_own(self, study: Study) -> Findings:
        """Hold the closed forms against second routes, and the adaptive reference DEM.

        At level full also the reference DEM with restitution against rigid spheres.
        """
        from harness.cases.incline.checks import (
            Stiffening,
            restitution_checks,
            rigid_checks,
            theory_checks,
        )

        parts = [Part("closed forms", theory_checks), Part("restitution", restitution_checks)]
        stiffening: list[Stiffening] = []
        if study.level == "full":
            parts.append(Part("rigid spheres", lambda: list(rigid_checks(stiffening))))
        return Findings(self.name, checks=rows_of_parts("theory", parts), evidence=stiffening)

    def _angles(self, engine: Engine, study: Study) -> Findings:
        from harness.cases.incline.engine_checks import angle_checks

        angles: list[EngineAngle] = []
        return _other_engine(engine.name, partial(angle_checks, engine, study, angles), angles)

    def recorded(self, study: Study) -> Mapping[str, Findings]:
        """Return the recorded angles of an engine that is missing."""
        from harness.cases.incline.verification import MFIX, RECORDED_NAME, recorded_checks

        if MFIX not in study.missing:
            return {}
        angles: list[EngineAngle] = []
        run = partial(recorded_checks, study.level, angles)
        return {RECORDED_NAME: _other_engine(RECORDED_NAME, run, angles)}

    def across(self, beside: Mapping[str, Findings]) -> Sequence[Check]:
        """Hold the angles of engines against one another."""
        from harness.cases.incline.engine_checks import across_engines

        return across_engines(
            [angle for findings in beside.values() for angle in findings.evidence]
        )

    def sections(
        self, main: Findings | None, own: Findings, beside: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the contacts with their angles, restitution, and the engines compared."""
        from harness.cases.incline.checks import rigid_section
        from harness.cases.incline.report import contact_sections, engine_sections

        contacts: list[Section] = []
        if main is not None:
            contacts += [*contact_sections(main.evidence), rigid_section(own.evidence or ())]
        angles = [angle for findings in beside.values() for angle in findings.evidence]
        return *contacts, *engine_sections(angles)

    def film(
        self, engine: Engine, parameters: Incline | None = None, frames: int = 120
    ) -> Film | None:
        """Return the film of the grain in steady motion, by default either side of the angle."""
        from harness.cases.incline.film import angles_beside, incline_film
        from harness.theory.incline import critical_angle

        cases = [Incline(angle=angle) for angle in angles_beside(critical_angle(), 0.0)]
        return incline_film(engine, cases if parameters is None else [parameters], frames)


def _other_engine(
    engine: str, run: Callable[[], Sequence[Check]], angles: list[EngineAngle]
) -> Findings:
    """Return the rows of an engine's angles, which ``run`` adds to ``angles``."""
    checks = rows_of_parts(engine, [Part("critical angle", run)], "deg")
    rows = [angle.to_json() for angle in angles]
    return Findings(NAME, engine, checks, evidence=angles, published={"critical_angles": rows})


def _search(case: Incline, **options: Any) -> CriticalAngle:
    from harness.cases.incline.angle import critical_angle

    return critical_angle(case, **options)


CASE = InclineCase()
_ANGLE = SearchedAngle(CASE, InclineSearch, job_of, _search, CASE.solvers)
