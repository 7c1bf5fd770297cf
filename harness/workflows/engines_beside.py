"""Engines beside the main one: each is identified, qualifies, and is held against theory."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from typing import Any

from harness.cases.contract import Case, Study
from harness.cases.parts import failed_part
from harness.cases.qualification import announce, qualify
from harness.cases.registry import all_cases
from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.engines import DeclaredEngine
from harness.comparison.findings import Findings
from harness.comparison.verdicts import Check, Kind
from harness.engines.contract import Engine
from harness.engines.registry import engine_class
from harness.engines.traits import Traits
from harness.errors import EngineMissingError, RequestError
from harness.observables.provenance import Provenance
from harness.store.entries import tell_stderr
from harness.workflows.engine_rows import NO_TRAITS, declared, untested, version_rows
from harness.workflows.engine_selection import EngineSelection


@dataclass
class Beside:
    """What engines beside the main one left.

    ``checks`` are all rows in order, those of the findings among them; ``errors`` tell what
    happened to engines that were asked for by name and are missing or died.
    """

    declared: list[DeclaredEngine] = field(default_factory=list)
    findings: dict[str, dict[str, Findings]] = field(default_factory=dict)
    checks: list[Check] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)
    kinds: dict[str, type[Engine]] = field(default_factory=dict)
    """The classes of engines that ran, by the name that they give themselves."""

    @property
    def records(self) -> list[BaselineRecord]:
        """Return the records of all engines."""
        found = (one for by_case in self.findings.values() for one in by_case.values())
        return [record for one in found for record in one.records]

    def qualified(self, name: str) -> bool:
        """Return whether an engine's results were used."""
        return any(one.engine == name and one.summary == "qualified" for one in self.declared)


@dataclass(frozen=True)
class EnginesBeside:
    """One comparison of engines, which take their turns, so that their costs can be told apart.

    ``main`` is an engine that is open already: it takes the place of the one of its name, and is
    not closed.
    """

    asked: EngineSelection
    cases: Sequence[Case[Any]]
    study: Study
    main: Engine | None
    found: Beside = field(default_factory=Beside)
    steps: dict[str, float] = field(default_factory=dict)
    """That a case took in the engines so far, by its name: what the next is expected to take."""

    def run(self) -> Beside:
        """Run the engines, add what was recorded with missing ones, and hold all together."""
        if not self.asked.engines:
            return self.found
        for name in self.asked.engines:
            self._one(name)
        self._recorded()
        for case in self.cases:
            self._across(case)
        return self.found

    def _one(self, name: str) -> None:
        """Run one engine, and keep what became of it."""
        traits = NO_TRAITS
        with ExitStack() as stack:
            try:
                traits = engine_class(name).traits
                engine, who = self._opened(name, stack)
            except (EngineMissingError, RequestError) as error:
                reason = traits.missing(str(error))
                rows = untested(name, [*self._qualifying, *self._judging], reason)
                self._without(name, traits, reason, rows)
            except Exception as error:
                rows = [failed_part(f"{name}: identification", error, kind=Kind.ANALYTIC)]
                self._without(name, traits, rows[0].note, rows)
            else:
                self.found.kinds[engine.name] = engine_class(name)
                self._keep(name, self._engine(engine, who))

    def _opened(self, name: str, stack: ExitStack) -> tuple[Engine, Provenance]:
        if self.main is not None and self.main.name == name:
            return self.main, self.main.identify()
        assert self.study.open_engine is not None
        engine = stack.enter_context(self.study.open_engine(name))
        return engine, engine.identify()

    def _without(self, name: str, traits: Traits, reason: str, rows: list[Check]) -> None:
        """Keep the rows of an engine that cannot be run, and its error if it was named."""
        self.found.declared.append(declared(name, traits, missing=reason))
        self.found.checks += rows
        if name in self.asked.named:
            self.found.errors.append(f"{name}: {reason}")

    def _keep(self, name: str, rows: list[Check]) -> None:
        """Keep the rows of an engine that ran, and how it died if it was named."""
        self.found.checks += rows
        if name in self.asked.named:
            died = [f"{name}: {row.note}" for row in rows if row.engine_died]
            self.found.errors += dict.fromkeys(died)

    def _engine(self, engine: Engine, who: Provenance) -> list[Check]:
        """Return the rows of an engine: version, qualification, then case by case."""
        name, stages = engine.name, 1 + len(self._judging)
        self.study.progress(f"engine {name}", 0, stages)
        told = declared(name, engine.traits, who)
        checks = version_rows(name, engine.traits, who)
        read = getattr(engine, "read", 0)
        failures, rows = self._qualification(engine)
        # of one whose runs are kept nobody knows how many are left to be made
        kept = getattr(engine, "read", 0) > read
        seconds_per_step = 0.0 if kept else engine.pace.seconds_per_step
        checks += rows
        self.found.declared.append(replace(told, unqualified=failures))
        self.study.progress(f"engine {name}", 1, stages)
        if failures:
            self.study.progress(f"engine {name}", stages, stages)
            return [*checks, *untested(name, self._judging, f"it did not qualify: {failures}")]
        for done, case in enumerate(self._judging, 2):
            steps = self.steps.get(case.name, 0.0) / engine.workers
            announce(engine, f"the {case.name}", steps * seconds_per_step, tell_stderr)
            before = engine.pace.steps
            checks += self._case(case, engine)
            taken = engine.pace.steps - before
            self.steps[case.name] = max(taken, self.steps.get(case.name, 0.0))
            self.study.progress(f"engine {name}", done, stages)
        return checks

    def _qualification(self, engine: Engine) -> tuple[str, list[Check]]:
        """Return why an engine does not qualify, or nothing, and the rows of its qualification."""
        try:
            found = qualify(engine, self._qualifying, self.study, tell_stderr)
        except Exception as error:
            row = failed_part(f"{engine.name}: qualification", error, kind=Kind.ANALYTIC)
            return row.note, [row]
        self.found.findings.setdefault(engine.name, {}).update(found.findings)
        return found.reason, list(found.checks)

    def _case(self, case: Case[Any], engine: Engine) -> list[Check]:
        """Return the rows of a case in an engine; one that raises is one failed row."""
        if not engine.states(case.template):
            return untested(engine.name, [case], f"it has no template {case.template.name!r}")
        try:
            found = case.verify_beside(engine, self.study)
        except Exception as error:
            return [failed_part(f"{engine.name}: {case.name}", error)]
        self.found.findings.setdefault(engine.name, {})[case.name] = found
        return found.checks

    def _recorded(self) -> None:
        """Add what was recorded elsewhere with engines that were asked for and are not used."""
        wanted = filter(self.asked.wants, self.asked.engines)
        missing = frozenset(name for name in wanted if not self.found.qualified(name))
        study = replace(self.study, missing=missing)
        for case in self.cases:
            try:
                recorded = case.recorded(study)
            except Exception as error:
                self.found.checks.append(failed_part(f"{case.name}: recorded results", error))
                continue
            for name, found in recorded.items():
                self.found.findings.setdefault(name, {})[case.name] = found
                self.found.checks += found.checks

    def _across(self, case: Case[Any]) -> None:
        beside = {
            name: by[case.name] for name, by in self.found.findings.items() if case.name in by
        }
        try:
            self.found.checks += case.across(beside)
        except Exception as error:
            self.found.checks.append(failed_part(f"{case.name}: engines against another", error))

    @property
    def _qualifying(self) -> list[Case[Any]]:
        return [case for case in all_cases().values() if case.qualifies]

    @property
    def _judging(self) -> list[Case[Any]]:
        return [case for case in self.cases if not case.qualifies]
