"""The sections of a report: those of all cases of a verification, case by case."""

from __future__ import annotations

from harness.cases.registry import get_case
from harness.comparison.findings import Findings
from harness.comparison.verification import Verification
from harness.report.sections import Section


def sections(found: Verification) -> list[Section]:
    """Return what the cases make of their findings, in the order they were verified.

    A case that raises is a section that says so: the report is written all the same.
    """
    made: list[Section] = []
    for name in found.cases:
        own = found.own.get(name, Findings(name))
        try:
            made += get_case(name).sections(found.main.get(name), own, found.of_case(name))
        except Exception as error:
            told = f"The sections of this case could not be made: {type(error).__name__}: {error}"
            made.append(Section(name, (told,)))
    return made
