"""Qualify an engine by drops on one fixed sphere, before its critical angles are believed."""

from __future__ import annotations

from dataclasses import dataclass

from harness.cases.drop.checks import drop_tests
from harness.cases.drop.runs import run_drops
from harness.comparison.verdicts import Check, Kind, Verdict, failed_run, judge, not_tested
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.parameters.contact import PLASTIC, SOURCE


@dataclass(frozen=True)
class Qualification:
    """What the drops of an engine found. Only an engine that ``holds`` is believed."""

    engine: str
    checks: tuple[Check, ...]

    @property
    def holds(self) -> bool:
        """Return whether no check failed, and at least one was made."""
        verdicts = [check.verdict for check in self.checks]
        return Verdict.FAIL not in verdicts and Verdict.PASS in verdicts

    @property
    def failures(self) -> str:
        """Return the names of the checks that failed, without the engine's."""
        failed = [c.name for c in self.checks if c.verdict is Verdict.FAIL]
        return ", ".join(name.partition(": ")[2] for name in failed)


def qualify(engine: Engine) -> Qualification:
    """Run the drops that an engine can state and judge each against its closed form.

    What the engine declares (``traits``) decides on the expectation: tail, effective
    mass, digits of its output. A run that dies is a failed check of its own.
    """
    tests = list(drop_tests(engine.traits))
    checks: list[Check] = []
    try:
        runs = run_drops(engine, [test.case for test in tests])
    except EngineError as error:
        runs = [error] * len(tests)
    for test, run in zip(tests, runs, strict=True):
        name = f"{engine.name}: {test.name}"
        if isinstance(run, EngineError):
            checks.append(failed_run(name, Kind.ANALYTIC, run, test.tolerance.unit))
            continue
        try:
            value = test.measure(run)
        except EngineError as error:
            checks.append(failed_run(name, Kind.ANALYTIC, error, test.tolerance.unit))
        else:
            checks.append(judge(name, Kind.ANALYTIC, value, test.expected, test.tolerance))
    for contact in (SOURCE, PLASTIC):
        refused = engine.traits.refuses_contact(contact)
        if refused:
            name = f"{engine.name}: restitution head-on, {contact.name} contact"
            checks.append(not_tested(name, Kind.ANALYTIC, refused))
    return Qualification(engine.name, tuple(checks))
