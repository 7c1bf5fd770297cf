"""The cases of a verification in the main engine and in the harness's own solvers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from harness.cases.contract import Case, Study
from harness.cases.parts import failed_part
from harness.cases.registry import get_case
from harness.comparison.divergence import Comparison
from harness.comparison.findings import Findings
from harness.comparison.verdicts import Check, judge_count
from harness.engines.contract import Engine
from harness.engines.parallel import parallel_map
from harness.engines.registry import DEFAULT, open_engine
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.workflows.engine_rows import untested
from harness.workflows.engines_beside import Beside

SIDE_BY_SIDE = 4
"""Parts that run at a time: own solvers compute while others wait for the engine's workers."""

Part = tuple[Case[Any], str, Callable[[], Findings]]
"""A case, the engine that runs it (empty for own solvers), and what runs it."""


@dataclass
class MainRun:
    """What the cases left, as they go.

    ``checks`` are all rows in order, those of the findings among them; ``broken`` says why a case
    ended early, ``raised`` are those that did by an exception, which is a failed row.
    """

    cases: Sequence[Case[Any]]
    study: Study
    engine: Engine | None = None
    provenance: Provenance | None = None
    main: dict[str, Findings] = field(default_factory=dict)
    own: dict[str, Findings] = field(default_factory=dict)
    checks: list[Check] = field(default_factory=list)
    broken: dict[str, str] = field(default_factory=dict)
    raised: set[str] = field(default_factory=set)

    @property
    def who(self) -> str:
        """Return the name of the main engine, whose baseline it is, also where it is missing."""
        if self.provenance is not None:
            return self.provenance.engine
        return self.engine.name if self.engine is not None else DEFAULT

    @property
    def findings(self) -> list[Findings]:
        """Return what the main engine left, then own solvers."""
        return [*self.main.values(), *self.own.values()]

    @property
    def divergences(self) -> list[Comparison]:
        """Return the series that left the band about their reference."""
        return [series for found in self.findings for series in found.divergences]

    def open(self, given: Engine | None, stack: ExitStack) -> None:
        """Identify the main engine; one that is not here is a failed row, and the rest goes on."""
        try:
            self.engine = given or stack.enter_context(open_engine())
            self.provenance = self.engine.identify()
        except Exception as error:
            row = failed_part(f"engine {self.who}", error)
            self.checks.append(row)
            self.broken |= {case.name: row.note for case in self.cases}

    def cases_side_by_side(self) -> None:
        """Run the cases in the main engine, then in own solvers."""
        parts: list[Part] = []
        if self.engine is not None and self.provenance is not None:
            for case in self.cases:
                if self.engine.states(case.template):
                    verify_main = partial(case.verify, self.engine, self.study)
                    parts.append((case, self.engine.name, verify_main))
                else:
                    why = f"it has no template {case.template.name!r}"
                    self.checks += untested(self.engine.name, [case], why)
                    self.broken[case.name] = f"{self.engine.name}: {why}"
        parts += [(case, "", partial(case.verify_own, self.study)) for case in self.cases]
        found = parallel_map(_found_or_failed, parts, SIDE_BY_SIDE)
        for (case, engine, _), outcome in zip(parts, found, strict=True):
            self._keep(case, engine, outcome)

    def _keep(self, case: Case[Any], engine: str, outcome: Findings | Check) -> None:
        if isinstance(outcome, Check):
            self.checks.append(outcome)
            self.raised.add(case.name)
            self.broken[case.name] = f"its part ended early: {outcome.note}"
            return
        (self.main if engine else self.own)[case.name] = outcome
        self.checks += outcome.checks
        died = next((check.note for check in outcome.checks if check.engine_died), "")
        if died:
            self.broken.setdefault(case.name, f"its part ended early: {died}")
        elif engine and self.engine is not None:
            expected = case.expected_rows(self.study.level, self.engine)
            if expected:
                name = f"{case.name}: rows of level {self.study.level}, {engine}"
                self.checks.append(judge_count(name, len(outcome.checks), expected))

    def scripts(self, beside: Beside) -> dict[str, str]:
        """Return the inputs that ran, by name."""
        found: dict[str, str] = {}
        if self.engine is not None:
            found |= self.engine.inputs([get_case(name).template for name in self.main])
        for name, by_case in beside.findings.items():
            if name in beside.kinds:
                templates = [get_case(case).template for case in by_case]
                # one that fails to render left its row
                with suppress(EngineError):
                    found |= beside.kinds[name].inputs(templates)
        return found


def _found_or_failed(part: Part) -> Findings | Check:
    """Run a case; one that raises is one failed row."""
    case, engine, run = part
    try:
        return run()
    except Exception as error:
        return failed_part(f"{case.name}: {engine or 'own solvers'}", error)
