"""The frictionless incline as a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from harness.cases.contract import Case, Measured, Reference
from harness.cases.incline.levels import run_seconds
from harness.cases.incline.runs import read
from harness.cases.incline.searched import InclineSearch, SearchedAngle
from harness.cases.incline.system import NAME, TEMPLATE, Incline, job_of
from harness.engines.contract import Job, Output
from harness.engines.traits import Traits
from harness.parameters.law import CONTACTS

if TYPE_CHECKING:
    from harness.cases.incline.angle import CriticalAngle

STEPS = {"plastic": 100.0}
"""Steps per contact time of a preset, where they are not the default."""


class InclineCase(Case[Incline]):
    """A grain on a tilted row of fixed spheres without friction: the critical angle."""

    name = NAME
    group = "incline"
    template = TEMPLATE
    verified_by = "harness.cases.incline.verification:InclineVerification"
    shown_by = "harness.cases.incline.report:InclineDisplay"
    solvers = ("hard-sphere",)

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
        return read(parameters, "passage", output).quantities

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


def _search(case: Incline, **options: Any) -> CriticalAngle:
    from harness.cases.incline.angle import critical_angle

    return critical_angle(case, **options)


CASE = InclineCase()
_ANGLE = SearchedAngle(CASE, InclineSearch, job_of, _search, CASE.solvers)
