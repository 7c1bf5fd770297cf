"""Defects of releases that are known, with their cause: failures that they explain are told apart.

A failure in a cell that a defect names is *known defect*: shown, counted apart, never a pass. A
cell of one that holds in a release that is said to have it is *fixed*.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase

from pydantic import Field

from harness.comparison.verdicts import Check, Verdict
from harness.observables.release import release_of
from harness.parameters.base import Parameters


class KnownDefect(Parameters):
    """A defect: in which cells of which engine, from which release to which, and why.

    ``cases``, ``submodels`` and ``systems`` are those of cells, with ``*`` and ``?``; ``since``
    and ``until`` the first and the last release that are known to have it, empty for no bound.
    ``invariances`` are those that it breaks, empty for one that makes values wrong.
    """

    name: str
    engine: str
    cases: tuple[str, ...] = Field(min_length=1)
    submodels: tuple[str, ...] = Field(min_length=1)
    systems: tuple[str, ...] = ("*",)
    invariances: tuple[str, ...] = ("",)
    cause: str = Field(min_length=20)
    since: str = ""
    until: str = ""
    upstream: str = ""
    script: str = ""

    def concerns(self, check: Check, versions: Mapping[str, str]) -> bool:
        """Return whether a check stands in a cell of the defect, in a release that has it."""
        cell = check.cell
        if cell is None:
            return False
        patterns = (self.cases, self.submodels, self.systems, (self.engine,), self.invariances)
        if not all(map(_among, cell.place, patterns)):
            return False
        here, last = release_of(versions.get(cell.engine, "")), release_of(self.until)
        return here >= release_of(self.since) and (not last or here[: len(last)] <= last)

    @property
    def note(self) -> str:
        """Return what a report says of it in a line."""
        where = f"; upstream: {self.upstream}" if self.upstream else ""
        shown = f"; {self.script} shows it" if self.script else ""
        return f"known defect {self.name}: {self.cause}{where}{shown}"


def defect_of(check: Check) -> str:
    """Return the name of the known defect that a check was marked with; empty without one."""
    return check.cell.defect if check.cell is not None else ""


def _among(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def told_apart(
    checks: Iterable[Check], defects: Sequence[KnownDefect], versions: Mapping[str, str]
) -> tuple[Check, ...]:
    """Return the checks, failures that a defect explains and cells where it is gone marked so.

    ``versions`` are those of the engines by name. A defect is gone where every judged check of a
    cell holds.
    """
    checks = tuple(checks)
    failing = {c.cell.place for c in checks if c.cell and c.verdict is Verdict.FAIL}
    return tuple(_marked(check, defects, versions, failing) for check in checks)


def _marked(
    check: Check,
    defects: Sequence[KnownDefect],
    versions: Mapping[str, str],
    failing: set[tuple[str, str, str, str, str]],
) -> Check:
    defect = next((one for one in defects if one.concerns(check, versions)), None)
    if defect is None or check.cell is None:
        return check
    note = "; ".join(filter(None, (defect.note, check.note)))
    marked = replace(check, cell=replace(check.cell, defect=defect.name))
    if check.verdict is Verdict.FAIL:
        return replace(marked, verdict=Verdict.KNOWN_DEFECT, note=note, engine_died=False)
    if check.verdict is Verdict.PASS and check.cell.place not in failing:
        return replace(marked, verdict=Verdict.FIXED, note=f"no longer there: {note}")
    return check
