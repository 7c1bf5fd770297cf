"""Whether an engine passes the cases that it must pass before its other results are used."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from harness.cases.contract import Case
from harness.cases.registry import all_cases
from harness.cases.verification import Study
from harness.comparison.verdicts import Check, Verdict
from harness.comparison.verification import Findings
from harness.engines.contract import Engine
from harness.engines.cost import STATED_SECONDS, in_words


@dataclass(frozen=True)
class Qualification:
    """What the qualifying cases found in an engine; its results are used if it ``holds``.

    ``findings`` are those of each case, by name.
    """

    engine: str
    checks: tuple[Check, ...]
    findings: Mapping[str, Findings] = field(default_factory=dict, repr=False)

    @property
    def holds(self) -> bool:
        """Return whether no check failed, and at least one was made."""
        verdicts = [check.verdict for check in self.checks]
        return Verdict.FAIL not in verdicts and Verdict.PASS in verdicts

    @property
    def failures(self) -> str:
        """Return the names of the checks that failed, without the engine's, and how it died."""
        failed = [check for check in self.checks if check.verdict is Verdict.FAIL]
        names = ", ".join(check.name.partition(": ")[2] for check in failed)
        died = [check.note for check in failed if check.engine_died]
        more = f", the first of {len(died)} that ended so" if len(died) > 1 else ""
        return f"{names} ({died[0]}{more})" if died else names

    @property
    def reason(self) -> str:
        """Return why the engine does not qualify; empty where it does."""
        return "" if self.holds else self.failures or "nothing was checked"


def qualify(
    engine: Engine,
    cases: Iterable[Case[Any]] | None = None,
    study: Study | None = None,
    tell: Callable[[str], None] | None = None,
) -> Qualification:
    """Run the cases that qualify an engine, those given or all that there are, and judge them.

    A case that the engine cannot state at all says nothing of it. ``tell`` is told beforehand what
    a long qualification is expected to take, of an engine whose runs are not kept.
    """
    wanted = all_cases().values() if cases is None else cases
    chosen = [case for case in wanted if case.qualifies and engine.states(case.template)]
    if tell is not None and engine.fingerprint() is None:
        seconds = sum(case.verification.seconds(engine) for case in chosen)
        announce(engine, "its qualification", seconds, tell)
    by_case = {case.name: case.verification.run(engine, study or Study()) for case in chosen}
    checks = tuple(check for findings in by_case.values() for check in findings.checks)
    return Qualification(engine.name, checks, by_case)


def announce(engine: Engine, work: str, seconds: float, tell: Callable[[str], None]) -> None:
    """Tell how long an engine is expected to take [s] for some work, where that is long."""
    if seconds > STATED_SECONDS:
        tell(f"{engine.name}: about {in_words(float(f'{seconds:.2g}'))} for {work}")
