"""How a case is verified: the parts of a verification, its settings, and by default plans.

A verification runs in an engine and leaves rows. A case that is judged by its plans needs nothing
of this; one of another shape names a subclass of :class:`Verification` in ``verified_by``, whose
``planned`` names the checks that must be there: one that is missing is a failed row of its name. A
part of a verification (:class:`Part`) leaves rows whatever becomes of the others.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, TypeVar

from harness.cases.text import tolerances_in
from harness.comparison.verdicts import (
    Check,
    Kind,
    Planned,
    Tolerance,
    Triage,
    failed,
    failed_run,
    judge,
    not_tested,
)
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Output
from harness.errors import EngineError, EngineOutputError, RequestError

if TYPE_CHECKING:
    from harness.cases.contract import Case, LevelName, Plan
    from harness.comparison.known_defects import KnownDefect

Value = TypeVar("Value")


class Once:
    """Values by their keys: the first thread to need one computes it, the others wait for it."""

    def __init__(self) -> None:
        self._values: dict[Hashable, Future[Any]] = {}
        self._lock = threading.Lock()

    def __call__(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """Return the value of a key; raise for all what ``make`` raised."""
        with self._lock:
            first = key not in self._values
            value: Future[Value] = self._values.setdefault(key, Future())
        if first:
            try:
                value.set_result(make())
            except BaseException as error:
                value.set_exception(error)
        return value.result()


Progress = Callable[[str, int, int], None]
"""Called with the name of a stage, the parts done, and the parts in all; from any thread."""


def silent(stage: str, done: int, total: int) -> None:
    """Report no progress."""


class Part(NamedTuple):
    """A part of a verification: its name, what runs it, and the names of rows that it must leave.

    A name may be the beginning of a row's.
    """

    name: str
    run: Callable[[], Sequence[Check]]
    rows: tuple[str, ...] = ()


def planned_in(parts: Iterable[Part]) -> list[Planned]:
    """Return the checks that parts name."""
    return [Planned(name) for part in parts for name in part.rows]


def rows_of_parts(case: str, parts: Iterable[Part], unit: str = "") -> list[Check]:
    """Run the parts of a verification in order and return their rows.

    A part that raises becomes a failed row; the other parts go on.
    """
    rows: list[Check] = []
    for part in parts:
        try:
            rows += part.run()
        except Exception as error:
            rows.append(failed_part(f"{case}: {part.name}", error, unit))
    return rows


def asked(part: Part) -> Part:
    """Return a part whose RequestError is the engine's failure.

    The runs are ours: one that does not show what is measured in it is the engine's doing.
    """

    def run() -> Sequence[Check]:
        try:
            return part.run()
        except RequestError as error:
            raise EngineOutputError(str(error)) from error

    return part._replace(run=run)


def failed_part(name: str, error: Exception, unit: str = "", kind: Kind = Kind.CROSS_CODE) -> Check:
    """Return the failed row of a part that raised: an engine's failure, or an error here."""
    if isinstance(error, EngineError):
        return failed_run(name, kind, error, unit)
    return failed(name, kind, f"{type(error).__name__}: {error}", Triage.HARNESS, unit)


Role = Literal["main", "other"]


@dataclass(frozen=True)
class Study:
    """Settings of a verification: its level, and how to open another engine by name.

    ``role`` is that of the engine: ``main``, or ``other`` for one that is compared with it.
    ``cases`` are verified. ``once`` holds values that several parts share; a case keys its entries
    by its parameters.
    ``defects`` are those that failures are held against.
    ``only`` is a shell-style pattern: trials and rows that it does not match are left out.
    """

    level: LevelName = "default"
    progress: Progress = silent
    open_engine: Callable[[str], AbstractContextManager[Engine]] | None = None
    cases: tuple[Case[Any], ...] = ()
    once: Once = field(default_factory=Once, compare=False, repr=False)
    only: str = ""
    role: Role = "main"
    defects: tuple[KnownDefect, ...] = ()

    def selects(self, *names: str) -> bool:
        """Return whether :attr:`only` matches one of the names; True where there is no pattern."""
        pattern = self.only.casefold()
        return not pattern or any(fnmatchcase(name.casefold(), pattern) for name in names)

    def keeps(self, row: Check, case: str) -> bool:
        """Return whether a row of a case is selected: by its name, or by its place."""
        cell = row.cell
        place = () if cell is None else places(cell.case, cell.submodel, cell.system)
        return self.selects(row.name, row.name.rpartition(": ")[2], case, *place)


def places(case: str, submodel: str, system: str) -> tuple[str, ...]:
    """Return what a pattern may call a trial: its parts, its cell, or all three with slashes."""
    cell = f"{case}/{submodel}"
    return case, submodel, system, cell, f"{cell}/{system}"


@dataclass(frozen=True)
class Verification:
    """Runs what judges a case, by default its plans, and compares engines."""

    case: Case[Any]

    lists_rows: ClassVar[bool] = False
    """Whether :meth:`selectable` names what each row is of."""

    @property
    def regression(self) -> Mapping[str, Tolerance]:
        """Return how far quantities of its baseline records may move, by their names.

        ``series`` is the band about every series.
        """
        return tolerances_in(self.case.text.get("regression", {}))

    def selectable(self, level: LevelName) -> set[str]:
        """Return the names that :attr:`Study.only` can match before a row is there."""
        return {self.case.name, *(quantity.name for quantity in self.case.quantities)}

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks that :meth:`run` must return."""
        return [
            Planned(name)
            for plan in self.case.plans(level, engine.traits)
            for name in self._names(plan, engine)
        ]

    def run(self, engine: Engine, study: Study) -> Findings:
        """Run the plans of a level in an engine and judge each quantity against its reference.

        The role of the engine is that of the study: a case may have fewer or other checks
        for an engine that is compared with the main one.
        """
        case, runnable = self.case, []
        findings = Findings(case.name, engine.name)
        for plan in case.plans(study.level, engine.traits):
            reason = engine.refuses(case.job(plan.parameters))
            if reason:
                (name,) = self._names(plan, engine)
                findings.checks.append(not_tested(name, Kind.ANALYTIC, reason))
            else:
                runnable.append(plan)
        outputs = engine.run([case.job(plan.parameters) for plan in runnable]) if runnable else []
        for plan, output in zip(runnable, outputs, strict=True):
            findings.checks += self._judged(plan, output, engine)
        return findings

    def seconds(self, engine: Engine) -> float:
        """Return what :meth:`run` is expected to take [s], timed in short runs; 0: not known."""
        return 0.0

    def run_solvers(self, study: Study) -> Findings:
        """Judge what needs no engine: closed forms and solvers of this package."""
        return Findings(self.case.name)

    def compare(self, engines: Mapping[str, Findings]) -> Sequence[Check]:
        """Hold engines, by name, against one another."""
        return ()

    def _names(self, plan: Plan[Any], engine: Engine) -> list[str]:
        """Return the names of the rows of a run: one where the engine refuses it."""
        name = f"{self.case.name}: {plan.name}, {engine.name}"
        if engine.refuses(self.case.job(plan.parameters)):
            return [name]
        return [f"{name}: {quantity}" for quantity in plan.tolerances]

    def _judged(self, plan: Plan[Any], output: Output | EngineError, engine: Engine) -> list[Check]:
        name = f"{self.case.name}: {plan.name}, {engine.name}"
        try:
            if isinstance(output, EngineError):
                raise output
            result = self.case.measured(plan.parameters, output, engine.traits)
        except EngineError as error:
            return [failed_run(name, Kind.ANALYTIC, error)]
        references = self.case.references(plan.parameters, engine.traits)
        return [
            judge(
                f"{name}: {quantity}",
                Kind.ANALYTIC if references[quantity].kind == "closed form" else Kind.CROSS_CODE,
                result.values[quantity],
                references[quantity].value,
                tolerance,
            )
            for quantity, tolerance in plan.tolerances.items()
        ]
