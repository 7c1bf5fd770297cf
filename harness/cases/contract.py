"""The contract of a case: what is simulated, how an output is read, and how it is judged.

A case is one object and one folder: ``parameters.py`` (frozen, validated, SI), ``case.toml`` (its
quantities, as ``name = "[unit] meaning"``, tolerances with their reasons, the prose of its
report), ``template.py`` (the values that scripts are told, the same system as a scene), reading,
``checks.py``, ``sections.py`` with figures. It names no engine: every engine that has a template
for it, or takes scenes, and whose declared rules accept the values, runs it.

To add a case, subclass :class:`Case` in ``cases/<name>/case.py`` as ``CASE = MyCase()``, or in a
package of your own under the entry point ``dem_harness.cases``. ``quantities``, ``template``,
``job``, ``read`` and ``references`` are enough for ``run`` and for a verification with ``plans``;
override ``verify`` for studies of another shape.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, TypeVar, get_args

from harness.cases.case_text import text_of
from harness.cases.once import Once
from harness.cases.parts import Progress as Progress
from harness.cases.parts import silent as silent
from harness.comparison.findings import Findings
from harness.comparison.tolerances import Tolerance
from harness.comparison.verdicts import Check, Kind, failed_run, judge, not_tested
from harness.engines.contract import Engine, Job, Output, Template
from harness.engines.cost import job_seconds
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineUndecidedError, RequestError
from harness.observables.declared import Observable, numbers
from harness.observables.provenance import Provenance
from harness.parameters.base import Parameters
from harness.report.sections import Section

if TYPE_CHECKING:
    from harness.cases.case_study import CaseStudy

P = TypeVar("P", bound=Parameters)

LevelName = Literal["quick", "default", "full"]
LEVELS: tuple[LevelName, ...] = ("quick", "default", "full")

ReferenceKind = Literal["closed form", "integrated", "none"]


@dataclass(frozen=True)
class Reference:
    """What a quantity is expected to be, and where that comes from."""

    value: float
    kind: ReferenceKind


@dataclass(frozen=True)
class Measured:
    """The quantities of one run, by their declared names, who made it, on which MPI ranks."""

    values: Mapping[str, float]
    provenance: Provenance | None = None
    seconds: float = 0.0
    ranks: int | None = None


@dataclass(frozen=True)
class Plan(Generic[P]):
    """A run of a verification: parameters, and the quantities to judge with their tolerances."""

    name: str
    parameters: P
    tolerances: Mapping[str, Tolerance]


@dataclass(frozen=True)
class Study:
    """How a verification is to be done: how much of it, and how to open another engine by name.

    ``missing`` are the names of engines that were asked for and could not be run, ``cases`` are
    verified. ``once`` makes what several parts share; a case keys its entries by its parameters.
    """

    level: LevelName = "default"
    progress: Progress = silent
    open_engine: Callable[[str], AbstractContextManager[Engine]] | None = None
    missing: frozenset[str] = frozenset()
    cases: tuple[Case[Any], ...] = ()
    once: Once = field(default_factory=Once, compare=False, repr=False)


class Case(ABC, Generic[P]):
    """One system: parameters to values, output to quantities, quantities to verdicts."""

    name: ClassVar[str]
    group: ClassVar[str]
    summary: ClassVar[str]
    """The first line of the class's docstring, unless it says something else."""
    by_default: ClassVar[bool] = False
    """Whether ``verify`` runs it when no case is named."""
    qualifies: ClassVar[bool] = False
    """Whether an engine must pass it before its other results are used."""
    parameters: ClassVar[type[Parameters]]
    """The class that the case is generic in, as ``Case[MyParameters]``."""
    quantities: ClassVar[tuple[Observable, ...]]
    """Those of ``case.toml`` beside the class's module, unless it names others."""
    template: ClassVar[Template]
    solvers: ClassVar[tuple[str, ...]] = ()
    """Solvers of this package that run it beside engines."""
    regression: ClassVar[Mapping[str, Tolerance]] = {}
    """How far the quantities of its baseline records may move, by their names; ``series`` is the
    band about every series."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        told = vars(cls)
        if "summary" not in told and cls.__doc__:
            cls.summary = cls.__doc__.partition("\n")[0]
        if "quantities" not in told and "quantities" in (text := text_of(cls)):
            cls.quantities = numbers(**text["quantities"])
        kinds = [kind for base in told.get("__orig_bases__", ()) for kind in get_args(base)]
        if "parameters" not in told and kinds and isinstance(kinds[0], type):
            cls.parameters = kinds[0]

    @property
    def presets(self) -> Mapping[str, P]:
        """Return known sets of parameters, by name."""
        return {}

    def study(self) -> CaseStudy | None:
        """Return the study that the case declares, None for one without."""
        return None

    @property
    def default(self) -> P:
        """Return the parameters of a run for which none are given: the first preset."""
        found: P = next(iter(self.presets.values()), None) or self.parameters()  # type: ignore[assignment]
        return found

    @abstractmethod
    def job(self, parameters: P) -> Job:
        """Return the job of one run."""

    @abstractmethod
    def read(self, parameters: P, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return the declared quantities of a run; raise EngineOutputError for a bad output."""

    def references(self, parameters: P, traits: Traits) -> Mapping[str, Reference]:
        """Return what quantities are expected to be under an engine's rules; {} where unknown."""
        return {}

    def solve(self, parameters: P, solver: str) -> Measured:
        """Run a solver of this package."""
        raise RequestError(f"--engine {solver!r}: case {self.name!r} has no such solver")

    def seconds(self, parameters: P, rules: Traits | None, solver: str = "") -> float:
        """Return what a run is expected to take [s], in an engine of these rules or a solver."""
        return 0.0 if rules is None else job_seconds(self.job(parameters), rules)

    def part_seconds(self, parameters: P, rules: Traits) -> float:
        """Return what the longest part of a run between two restart files is expected to take [s].

        All of it unless the case says otherwise.
        """
        return self.seconds(parameters, rules)

    def measure(self, parameters: P, engine: Engine) -> Measured:
        """Run once in an engine and return what was measured.

        Raise EngineError for a run that failed, RequestError for one that it cannot state.
        """
        (output,) = engine.run([self.job(parameters)])
        if isinstance(output, EngineError):
            raise output
        return self.measured(parameters, output, engine.traits)

    def plans(self, level: LevelName, traits: Traits) -> Sequence[Plan[P]]:
        """Return the runs of a level that the default :meth:`verify` judges."""
        return ()

    def expected_rows(self, level: LevelName, engine: Engine) -> int:
        """Return how many rows :meth:`verify` leaves at least, 0 where the case does not say."""
        return sum(
            1 if engine.refuses(self.job(plan.parameters)) else len(plan.tolerances)
            for plan in self.plans(level, engine.traits)
        )

    def verify(self, engine: Engine, study: Study) -> Findings:
        """Run the plans of a level in an engine and judge each quantity against its reference."""
        plans = self.plans(study.level, engine.traits)
        findings, runnable = Findings(self.name, engine.name), []
        for plan in plans:
            reason = engine.refuses(self.job(plan.parameters))
            if reason:
                name = f"{self.name}: {plan.name}, {engine.name}"
                findings.checks.append(not_tested(name, Kind.ANALYTIC, reason))
            else:
                runnable.append(plan)
        outputs = engine.run([self.job(plan.parameters) for plan in runnable]) if runnable else []
        for plan, output in zip(runnable, outputs, strict=True):
            findings.checks += self._judged(plan, output, engine)
        return findings

    def seconds_to_verify(self, engine: Engine) -> float:
        """Return what :meth:`verify` is expected to take [s], timed in short runs; 0: not known."""
        return 0.0

    def verify_own(self, study: Study) -> Findings:
        """Judge what needs no engine: closed forms and solvers of this package."""
        return Findings(self.name)

    def verify_beside(self, engine: Engine, study: Study) -> Findings:
        """Judge an engine beside the main one; as :meth:`verify` unless there is less to do."""
        return self.verify(engine, study)

    def recorded(self, study: Study) -> Mapping[str, Findings]:
        """Return what was recorded with engines of ``study.missing``, by the name to show."""
        return {}

    def across(self, beside: Mapping[str, Findings]) -> Sequence[Check]:
        """Hold engines, by name, against one another."""
        return ()

    def sections(
        self, main: Findings | None, own: Findings, beside: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the parts of the report: of the main engine, own solvers, engines beside it."""
        return ()

    def measured(self, parameters: P, output: Output, traits: Traits) -> Measured:
        """Return the quantities of an output; raise EngineError for one that is not declared."""
        try:
            values = dict(self.read(parameters, output, traits))
        except EngineUndecidedError as error:
            error.provenance, error.seconds = output.provenance, output.seconds
            error.ranks = output.ranks
            raise
        declared = {observable.name for observable in self.quantities}
        where = f"case {self.name!r} of package {type(self).__module__.partition('.')[0]!r}"
        for name, value in values.items():
            if name not in declared:
                raise EngineError(f"{where} returned {name!r}, which it does not declare")
            if not isinstance(value, (int, float)):
                told = " ".join(repr(value).split())[:60]
                raise EngineError(f"{where} returned {name} = {told}: not one number")
        return Measured(values, output.provenance, output.seconds, output.ranks)

    def _judged(self, plan: Plan[P], output: Output | EngineError, engine: Engine) -> list[Check]:
        name = f"{self.name}: {plan.name}, {engine.name}"
        try:
            if isinstance(output, EngineError):
                raise output
            found = self.measured(plan.parameters, output, engine.traits)
        except EngineError as error:
            return [failed_run(name, Kind.ANALYTIC, error)]
        references = self.references(plan.parameters, engine.traits)
        return [
            judge(
                f"{name}: {quantity}",
                Kind.ANALYTIC if references[quantity].kind == "closed form" else Kind.CROSS_CODE,
                found.values[quantity],
                references[quantity].value,
                tolerance,
            )
            for quantity, tolerance in plan.tolerances.items()
        ]
