"""The contract of a case: what is simulated, how an output is read, and how it is judged.

A case is one object and one folder or module. It names no engine: every engine that has a template
for it, or takes scenes, and whose declared rules accept the values, runs it. Its quantities,
formula, tolerances (each with its reason) and prose lie in ``case.toml`` beside its module.

To add a case, subclass :class:`Case` in ``cases/<name>/case.py`` as ``CASE = MyCase()``, or in a
package of your own under the entry point ``dem_harness.cases``. ``quantities``, ``template``,
``job``, ``read`` and ``references`` are enough for ``run``, and with ``plans`` for a verification;
override ``verify`` for one of another shape, and name in ``planned`` the checks that it must leave:
one that is missing is a failed row of its name. A part of a verification (:class:`Part`) leaves
rows whatever becomes of the others.

A quantity that takes several runs for one value, such as a critical angle, is measured by a case of
its own, which ``derived`` returns: it names what it ``varied``, and overrides ``measure``. ``run``
and ``sweep`` get that case from ``measuring``, by the name of the quantity.

A study (:class:`CaseStudy`) is a question that one case answers with many runs, from the runs to a
verdict in words. A workflow for any case does the runs and returns the rows.
"""

from __future__ import annotations

import sys
import threading
import tomllib
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, NamedTuple, TypeVar, get_args

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
from harness.engines.border import job_seconds
from harness.engines.contract import Engine, Job, Output, Template
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineOutputError, EngineUndecidedError, RequestError
from harness.observables.provenance import Observable, Provenance, numbers
from harness.observables.reference import ReferencePoints
from harness.parameters.base import Parameters
from harness.report.sections import Drawing, Opening, Section, Table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from harness.report.film import Film


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


def text_of(case: type) -> dict[str, Any]:
    """Return the content of the TOML file of a case's module; {} where there is none."""
    return _toml_of(getattr(sys.modules[case.__module__], "__file__", None) or "")


@cache
def _toml_of(module: str) -> dict[str, Any]:
    named = Path(module).with_suffix(".toml")
    file = named if named.is_file() else named.with_name("case.toml")
    return tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}


def tolerances_of(module: str, section: str = "tolerances") -> dict[str, Tolerance]:
    """Return the tolerances that ``case.toml`` beside a module has, each with its reason.

    ``regression`` is the section of those of the baseline's records.
    """
    none = {"unit": "", "absolute": 0.0, "relative": 0.0}
    tables = _toml_of(module)[section]
    return {name: Tolerance(**{**none, **table}) for name, table in tables.items()}


class Words:
    """The texts of a report on a case, without its numbers, from ``case.toml`` of a module.

    ``figures`` have a title and a caption, ``sections`` a title and paragraphs, ``tables`` a
    caption and a head. Names in braces are replaced by the values passed.
    """

    def __init__(self, module: str) -> None:
        self._told, self._folder = _toml_of(module), Path(module).parent

    def drawing(self, name: str, draw: Callable[[], Figure], **values: Any) -> Drawing:
        """Return a figure by its name, which is that of its file; raise KeyError for another."""
        title, caption = self._told["figures"][name]
        file, title, caption = (text.format(**values) for text in (name, title, caption))
        return Drawing(file, title, caption, draw)

    def section(self, name: str, **parts: Any) -> Section:
        """Return a section with its ``parts``, those of :class:`Section`; raise KeyError."""
        texts = self._told["sections"][name]
        further = parts.pop("paragraphs", ())
        return Section(texts["title"], (*texts.get("paragraphs", ()), *further), **parts)

    def opening(self, figure: str = "", **values: Any) -> Opening:
        """Return the report's opening with the case's sketch; raise KeyError for none."""
        texts = self._told["opening"]
        return Opening(
            texts["title"],
            (self._folder / "sketch.svg").read_text("utf-8"),
            tuple(step.format(**values) for step in texts["steps"]),
            texts["source"],
            tuple(texts["terms"].items()),
            figure,
        )

    def table(
        self,
        name: str,
        rows: Sequence[tuple[str, ...]],
        **values: Any,
    ) -> Table:
        """Return a table by its label, with rows; raise KeyError for another."""
        texts = self._told["tables"][name]
        caption = texts["caption"].format(**values)
        return Table(name, caption, tuple(texts["head"]), tuple(rows))


P = TypeVar("P", bound=Parameters)

LevelName = Literal["quick", "default", "full"]
LEVELS: tuple[LevelName, ...] = ("quick", "default", "full")

Role = Literal["main", "other"]

ReferenceKind = Literal["closed form", "integrated", "none"]


@dataclass(frozen=True)
class Reference:
    """The expected value of a quantity, and its origin.

    ``quick`` says that an integrated one costs milliseconds, as a closed form does: figures draw
    it between the points too.
    """

    value: float
    kind: ReferenceKind
    quick: bool = False


@dataclass(frozen=True)
class Measured:
    """The quantities of one run, by their declared names, who made it, on which MPI ranks.

    ``profile`` are columns of one length, of a case that has one.
    """

    values: Mapping[str, float]
    provenance: Provenance | None = None
    seconds: float = 0.0
    ranks: int | None = None
    profile: Mapping[str, Sequence[float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Plan(Generic[P]):
    """A run of a verification: parameters, and the quantities to judge with their tolerances."""

    name: str
    parameters: P
    tolerances: Mapping[str, Tolerance]


@dataclass(frozen=True)
class Study:
    """Settings of a verification: its level, and how to open another engine by name.

    ``role`` is that of the engine: ``main``, or ``other`` for one that is compared with it.
    ``missing`` are the names of requested engines that could not be run, ``cases`` are
    verified. ``once`` holds values that several parts share; a case keys its entries by its
    parameters.
    ``only`` is a shell-style pattern: trials and rows that it does not match are left out.
    """

    level: LevelName = "default"
    progress: Progress = silent
    open_engine: Callable[[str], AbstractContextManager[Engine]] | None = None
    missing: frozenset[str] = frozenset()
    cases: tuple[Case[Any], ...] = ()
    once: Once = field(default_factory=Once, compare=False, repr=False)
    only: str = ""
    role: Role = "main"

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
    """Return what a pattern may call a trial: its parts, or all three with slashes between."""
    return case, submodel, system, f"{case}/{submodel}/{system}"


GONE = {
    "by_default": "`verify` runs incline and tower unless others are named",
    "expected_rows": "name the checks in `planned`",
    "judge_count": "name the checks in `planned`",
    "verify_beside": "`verify` reads `study.role`",
}
"""Members of a case of earlier versions, and what is in their place: one that still has them would
be judged otherwise than it says."""


class Case(ABC, Generic[P]):
    """One system: parameters to values, output to quantities, quantities to verdicts."""

    name: ClassVar[str]
    group: ClassVar[str]
    summary: ClassVar[str]
    """The first line of the class's docstring, unless it says something else."""
    lists_rows: ClassVar[bool] = False
    """Whether :meth:`selectable` names what each row is of."""
    qualifies: ClassVar[bool] = False
    """Whether an engine must pass it before its other results are used."""
    parameters: ClassVar[type[Parameters]]
    """The class that the case is generic in, as ``Case[MyParameters]``."""
    quantities: ClassVar[tuple[Observable, ...]]
    """Those of ``case.toml`` beside the class's module, unless it names others."""
    template: ClassVar[Template]
    solvers: ClassVar[tuple[str, ...]] = ()
    """Solvers of this package that run it beside engines."""
    cost: ClassVar[Mapping[str, float]] = {}
    """CPU time [s] that its verification took by level, in the default engine, without the
    report; that of ``case.toml`` unless given."""
    varied: tuple[str, ...] = ()
    """Parameters that :meth:`measure` varies over several runs for one value: none may be set."""
    regression: ClassVar[Mapping[str, Tolerance]] = {}
    """How far the quantities of its baseline records may move, by their names; ``series`` is the
    band about every series."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        members = vars(cls)
        gone = [name for name in members if name in GONE]
        if gone:
            raise TypeError(f"{cls.__name__}.{gone[0]}: is not called any more: {GONE[gone[0]]}")
        if "summary" not in members and cls.__doc__:
            cls.summary = cls.__doc__.partition("\n")[0]
        if "quantities" not in members and "quantities" in (text := text_of(cls)):
            cls.quantities = numbers(**text["quantities"])
        if "cost" not in members and "cost" in (text := text_of(cls)):
            cls.cost = text["cost"]
        kinds = [kind for base in members.get("__orig_bases__", ()) for kind in get_args(base)]
        if "parameters" not in members and kinds and isinstance(kinds[0], type):
            cls.parameters = kinds[0]

    @property
    def presets(self) -> Mapping[str, P]:
        """Return known sets of parameters, by name."""
        return {}

    def selectable(self, level: LevelName) -> set[str]:
        """Return the names that :attr:`Study.only` can match before a row is there."""
        return {self.name, *(quantity.name for quantity in self.quantities)}

    def derived(self) -> Sequence[Case[Any]]:
        """Return what takes several runs for one value: a case for each, of other quantities."""
        return ()

    def measuring(self, names: Sequence[str]) -> Case[Any]:
        """Return the case, or the derived one, that measures quantities; itself for none.

        Raise RequestError for a name that is not known, and for names of several of them.
        """
        options = [self, *self.derived()]
        measurable = {quantity.name: case for case in options for quantity in case.quantities}
        for name in names:
            if name not in measurable:
                must = ", ".join(measurable)
                raise RequestError(f"--quantity {name!r}: case {self.name!r} measures {must}")
        chosen = list(dict.fromkeys(measurable[name] for name in names))
        if len(chosen) > 1:
            sets = " or of ".join(", ".join(q.name for q in case.quantities) for case in options)
            raise RequestError(
                f"--quantity {','.join(names)}: not of the same runs; must be some of {sets}"
            )
        return chosen[0] if chosen else self

    def study(self) -> CaseStudy | None:
        """Return the study that the case declares, None for one without."""
        return None

    def source_of(self, preset: str) -> str:
        """Return where the values of a preset were published; empty for those of this package."""
        return "the source paper, arXiv 2409.13633" if preset == "source" else ""

    @property
    def default(self) -> P:
        """Return the parameters of a run for which none are given: the first preset."""
        parameters: P = next(iter(self.presets.values()), None) or self.parameters()  # type: ignore[assignment]
        return parameters

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
        """Return the expected time of the longest part of a run between two restart files [s].

        By default that of the whole run.
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

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks that :meth:`verify` must return; none by default."""
        return [
            Planned(name)
            for plan in self.plans(level, engine.traits)
            for name in self._names(plan, engine)
        ]

    def verify(self, engine: Engine, study: Study) -> Findings:
        """Run the plans of a level in an engine and judge each quantity against its reference.

        The role of the engine is that of the study: a case may have fewer or other checks
        for an engine that is compared with the main one.
        """
        plans = self.plans(study.level, engine.traits)
        findings, runnable = Findings(self.name, engine.name), []
        for plan in plans:
            reason = engine.refuses(self.job(plan.parameters))
            if reason:
                (name,) = self._names(plan, engine)
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

    def recorded(self, study: Study) -> Mapping[str, Findings]:
        """Return what was recorded with engines of ``study.missing``, by the name to show."""
        return {}

    def across(self, beside: Mapping[str, Findings]) -> Sequence[Check]:
        """Hold engines, by name, against one another."""
        return ()

    def sections(
        self, main: Findings | None, own: Findings, beside: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the sections of the report: of the main engine, own solvers, other engines."""
        return ()

    def profile(self, parameters: P, output: Output) -> Mapping[str, Sequence[float]]:
        """Return a run's profile as columns of one length; {} for a case without one."""
        return {}

    def figures(self, rows: pd.DataFrame) -> Mapping[str, Callable[[], Figure]]:
        """Return what draws figures of a sweep's rows, those that are done, by names of files."""
        return {}

    def film(self, engine: Engine, parameters: P | None = None, frames: int = 120) -> Film | None:
        """Return the film of one run; None for a case that has none.

        Of the system that shows the case best where no parameters are given. Raise EngineError
        for a run that failed.
        """
        return None

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
                content = " ".join(repr(value).split())[:60]
                raise EngineError(f"{where} returned {name} = {content}: not one number")
        profile = self.profile(parameters, output)
        return Measured(values, output.provenance, output.seconds, output.ranks, profile)

    def _names(self, plan: Plan[P], engine: Engine) -> list[str]:
        """Return the names of the rows of a run: one where the engine refuses it."""
        name = f"{self.name}: {plan.name}, {engine.name}"
        if engine.refuses(self.job(plan.parameters)):
            return [name]
        return [f"{name}: {quantity}" for quantity in plan.tolerances]

    def _judged(self, plan: Plan[P], output: Output | EngineError, engine: Engine) -> list[Check]:
        name = f"{self.name}: {plan.name}, {engine.name}"
        try:
            if isinstance(output, EngineError):
                raise output
            result = self.measured(plan.parameters, output, engine.traits)
        except EngineError as error:
            return [failed_run(name, Kind.ANALYTIC, error)]
        references = self.references(plan.parameters, engine.traits)
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


Level = Literal["quick", "default", "full"]

Row = Mapping[str, Any]
"""One run, flat as in a sweep: parameters and quantities with their units, status and reason."""


@dataclass(frozen=True)
class Arm:
    """Runs that belong together, each with parameters of its own; ``ranks`` of MPI in each."""

    name: str
    parameters: tuple[Parameters, ...]
    ranks: int = 1


@dataclass(frozen=True)
class Conclusion:
    """Result of a study: its rows, the verdict in sentences, the sections of its report.

    ``test`` is how the verdict follows from the numbers, stated before they are known.
    """

    rows: tuple[Row, ...]
    verdict: tuple[str, ...]
    test: str
    sections: tuple[Section, ...]


@dataclass(frozen=True)
class StudyCost:
    """What a level costs: what was ``measured``, a row for each number of cores, the model."""

    measured: tuple[Row, ...]
    rows: tuple[Row, ...]
    model: str


EngineOf = Callable[[int], AbstractContextManager[Engine]]
"""Opens an engine whose runs take so many ranks of MPI."""


class CaseStudy(ABC):
    """What is run at each level, and what follows from it."""

    title: str
    question: str
    columns: Sequence[str]
    """Of the rows of its conclusion, those that a terminal shows."""

    @abstractmethod
    def arms(self, level: Level) -> Sequence[Arm]:
        """Return the runs of a level."""

    def cost(self, level: Level, engine_of: EngineOf, runs: Sequence[Row] = ()) -> StudyCost:
        """Return what a level costs on 1, 16 and 256 cores.

        By the wall times of ``runs`` of this study, else measured on an engine in short runs.
        """
        raise RequestError(f"--cost: the study {self.title!r} does not tell what it costs")

    @abstractmethod
    def conclude(
        self, arms: Mapping[str, Sequence[Row]], points: ReferencePoints | None
    ) -> Conclusion:
        """Return what follows from the rows of each arm, in the order of its parameters.

        An arm whose engine is not here has no rows. ``points`` are a user's, to be drawn.
        """
