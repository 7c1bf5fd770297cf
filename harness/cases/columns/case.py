"""The grain over compliant columns as a case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from harness.cases.columns.parameters import Columns
from harness.cases.columns.runs import read
from harness.cases.columns.template import NAME, TEMPLATE, job_of
from harness.cases.contract import Case, LevelName, Reference, Study
from harness.cases.incline.case import CASE as INCLINE
from harness.cases.parts import rows_of_parts
from harness.comparison.findings import Findings
from harness.engines.contract import Engine, Job, Output
from harness.engines.traits import Traits
from harness.parameters.contact import CONTACTS
from harness.report.sections import Section


class ColumnsCase(Case[Columns]):
    """The incline's grain on columns of n particles, the last one fixed: critical angle.

    The impulse between grain and column, and the waves below, are what the source explains the
    lower angle of thick layers by. Without friction every impulse on the grain stands normal to
    the sphere ahead: the half of the velocity along it survives the shock whatever the column
    does. Stiff columns that damp as the grain's contact does give nothing back, and leave the
    angle of one sphere; elastic ones give part of it back, which can only raise the angle.
    """

    name = NAME
    group = "incline"
    quantities = INCLINE.quantities
    template = TEMPLATE

    @property
    def presets(self) -> Mapping[str, Columns]:
        """Return columns of four particles under each named contact and both laws."""
        found = {
            f"{name}, {law}": Columns(contact=contact, law=law, steps_per_contact=100.0)
            for law in ("overlap", "deformable")
            for name, contact in CONTACTS.items()
        }
        return {"plastic": found.pop("plastic, overlap"), **found}

    def job(self, parameters: Columns) -> Job:
        """Return the job of one passage."""
        return job_of(parameters, "passage")

    def read(self, parameters: Columns, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return what became of one passage; raise EngineOutputError for a bad output."""
        return read(parameters, "passage", output).quantities

    def references(self, parameters: Columns, traits: Traits) -> Mapping[str, Reference]:
        """Return the margin of rigid spheres; none for what rebounds."""
        rebounds = parameters.n > 1 and parameters.inside == "elastic"
        return {} if rebounds else INCLINE.references(parameters, traits)

    def expected_rows(self, level: LevelName, engine: Engine) -> int:
        """Return how many rows a level leaves."""
        from harness.cases.columns.checks import engine_parts

        return sum(part.rows for part in engine_parts(engine))

    def verify(self, engine: Engine, study: Study) -> Findings:
        """Hold an engine against the incline for one particle, and against the reference DEM."""
        from harness.cases.columns.checks import engine_parts

        rows = rows_of_parts(self.name, engine_parts(engine))
        return Findings(self.name, engine.name, rows)

    def verify_own(self, study: Study) -> Findings:
        """Hold the reference DEM against the limit of stiff columns; find the angles."""
        from harness.cases.columns.checks import own_parts
        from harness.cases.columns.evidence import Angles

        angles = Angles()
        rows = rows_of_parts(self.name, own_parts(study, angles), "deg")
        records = {"columns": angles.records()}
        return Findings(self.name, checks=rows, evidence=angles, published=records)

    def sections(
        self, main: Findings | None, own: Findings, beside: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the critical angle against the height of the columns."""
        from harness.cases.columns.sections import sections

        return sections(own.evidence)


CASE = ColumnsCase()
