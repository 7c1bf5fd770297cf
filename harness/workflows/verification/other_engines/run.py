"""Run the engines one after the other: identify, qualify, critical angles, towers."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field, replace

from harness.cases.drop.qualification import qualify
from harness.cases.incline.across_engines import across_engines
from harness.cases.incline.engine_angles import References
from harness.cases.incline.engine_checks import angle_checks
from harness.cases.tower.engine_checks import tower_checks
from harness.comparison.engine_evidence import EngineEvidence
from harness.comparison.verdicts import Check
from harness.engines.contract import Engine
from harness.engines.registry import engine_class
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.observables.provenance import Provenance
from harness.theory.critical_angle import critical_angle
from harness.workflows.progress import Progress
from harness.workflows.verification.other_engines import identity
from harness.workflows.verification.other_engines.asked import Asked
from harness.workflows.verification.other_engines.extent import EXTENTS, Extent
from harness.workflows.verification.other_engines.recorded_mfix import recorded_checks

Open = Callable[[str], AbstractContextManager[Engine]]
"""Opens an engine by its name, to be closed after use."""

MFIX = "mfix"


@dataclass
class Found:
    """What the engines left: rows, evidence, the notes of named ones that were missing or died."""

    evidence: EngineEvidence
    checks: list[Check] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class _Comparison:
    """One comparison of engines, as they take their turns."""

    asked: Asked
    level: str
    open: Open
    progress: Progress
    found: Found
    references: References

    @property
    def extent(self) -> Extent:
        return EXTENTS[self.level]

    def run(self, name: str, own: Engine | None) -> None:
        """Run one engine, and keep what became of it."""
        traits = engine_class(name).traits
        with ExitStack() as stack:
            try:
                engine = own or stack.enter_context(self.open(name))
                who = engine.identify()
            except (EngineMissingError, RequestError) as error:
                reason = traits.missing(str(error))
                self._without(name, reason, identity.rows_of_missing(name, reason))
            except EngineError as error:
                rows = identity.rows_of_dead(name, error)
                self._without(name, rows[0].note, rows)
            else:
                self._keep(name, self._engine(engine, who))

    def _without(self, name: str, reason: str, rows: list[Check]) -> None:
        """Keep the rows of an engine that cannot be run, and its error if it was named."""
        declared = identity.declared(name, engine_class(name).traits, missing=reason)
        self.found.evidence.declared.append(declared)
        self.found.checks += rows
        if name in self.asked.named:
            self.found.errors.append(f"{name}: {reason}")

    def _keep(self, name: str, rows: list[Check]) -> None:
        """Keep the rows of an engine that ran, and how it died if it was named."""
        self.found.checks += rows
        if name in self.asked.named:
            self.found.errors += [f"{name}: {row.note}" for row in rows if row.engine_died]

    def _engine(self, engine: Engine, who: Provenance) -> list[Check]:
        """Return the rows of an engine: qualification, critical angles, towers."""
        stage, evidence = f"engine {engine.name}", self.found.evidence
        self.progress(stage, 0, 3)
        told = identity.declared(engine.name, engine.traits, who)
        checks = identity.version_row(engine.name, engine.traits, who)
        qualified = qualify(engine)
        checks += qualified.checks
        self.progress(stage, 1, 3)
        if not qualified.holds:
            failures = qualified.failures or "nothing was checked"
            evidence.declared.append(replace(told, unqualified=failures))
            self.progress(stage, 3, 3)
            return [*checks, *identity.rows_of_unqualified(engine.name, failures)]
        evidence.declared.append(told)
        checks += angle_checks(engine, self.extent, self.references, evidence)
        self.progress(stage, 2, 3)
        checks += tower_checks(engine, self.extent, evidence)
        self.progress(stage, 3, 3)
        return checks

    def live(self, name: str) -> bool:
        """Return whether an engine could be used here."""
        standings = {d.engine: d.standing for d in self.found.evidence.declared}
        return standings.get(name) == "qualified"


def engine_checks(
    asked: Asked, level: str, open_one: Open, progress: Progress, own: Engine | None = None
) -> Found:
    """Compare the engines that are asked for; one after the other, so that costs can be told.

    ``own`` is an engine that is open already: it takes the place of the one of its name, and
    is not closed. What goes wrong with one engine is told in its rows; the others go on.
    """
    evidence = EngineEvidence(closed_form_deg=critical_angle())
    found = Found(evidence)
    references = References(EXTENTS[level].phases)
    comparison = _Comparison(asked, level, open_one, progress, found, references)
    for name in asked.engines:
        comparison.run(name, own if own is not None and own.name == name else None)
    if asked.wants(MFIX) and not comparison.live(MFIX):
        found.checks += recorded_checks(level, evidence)
    found.checks += across_engines(evidence)
    return found
