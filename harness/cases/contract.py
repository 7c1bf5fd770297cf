"""The contract of a case: what is simulated, how an output is read, and what is expected.

A case is one object and one folder or module. It names no engine: every engine that has a template
for it, or takes scenes, and whose declared rules accept the values, runs it. Its quantities,
formula, tolerances (each with its reason) and prose lie in ``case.toml`` beside its module.

To add a case, subclass :class:`Case` in ``cases/<name>/case.py`` as ``CASE = MyCase()``, or in a
package of your own under the entry point ``dem_harness.cases``. ``quantities``, ``template``,
``job``, ``read`` and ``references`` are enough for ``run``, and with ``plans`` for a verification.
What is more than plans lies in a class of its own: how the case is verified
(:mod:`harness.cases.verification`), how it is shown (:mod:`harness.cases.display`).

A quantity that takes several runs for one value, such as a critical angle, is measured by a case of
its own, which ``derived`` returns: it names what it ``varied``, and overrides ``measure``. ``run``
and ``sweep`` get that case from ``measuring``, by the name of the quantity.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, TypeVar, get_args

from harness.cases.text import text_of
from harness.comparison.verdicts import Tolerance
from harness.engines.contract import Engine, Job, Output, Template
from harness.engines.cost import job_seconds
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineUndecidedError, RequestError
from harness.observables.provenance import Observable, Provenance, numbers
from harness.parameters.base import Parameters

if TYPE_CHECKING:
    from harness.cases.display import Display
    from harness.cases.verification import Verification

P = TypeVar("P", bound=Parameters)

LevelName = Literal["quick", "default", "full"]
LEVELS: tuple[LevelName, ...] = ("quick", "default", "full")

ReferenceKind = Literal["equal steps", "closed form", "integrated", "none"]


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


class Case(ABC, Generic[P]):
    """One system: parameters to a job, an output to quantities, and what these should be."""

    name: ClassVar[str]
    group: ClassVar[str]
    summary: ClassVar[str]
    """The first line of the class's docstring, unless it says something else."""
    qualifies: ClassVar[bool] = False
    """Whether an engine must pass it before its other results are used."""
    parameters: ClassVar[type[Parameters]]
    """The class that the case is generic in, as ``Case[MyParameters]``."""
    text: ClassVar[Mapping[str, Any]] = {}
    """The TOML file beside the class's module."""
    quantities: ClassVar[tuple[Observable, ...]]
    """Those of :attr:`text`, unless it names others."""
    template: ClassVar[Template]
    solvers: ClassVar[tuple[str, ...]] = ()
    """Solvers of this package that run it beside engines."""
    verified_by: ClassVar[str] = "harness.cases.verification:Verification"
    """The class of :attr:`verification`, as ``module:Class``: by plans, unless it names another."""
    shown_by: ClassVar[str] = "harness.cases.display:Display"
    """The class of :attr:`display`: by rows alone, unless it names another."""
    varied: tuple[str, ...] = ()
    """Parameters that :meth:`measure` varies over several runs for one value: none may be set."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        members = vars(cls)
        if "summary" not in members and cls.__doc__:
            cls.summary = cls.__doc__.partition("\n")[0]
        if text := text_of(cls):
            cls.text = text
        if "quantities" not in members and "quantities" in text:
            cls.quantities = numbers(**text["quantities"])
        kinds = [kind for base in members.get("__orig_bases__", ()) for kind in get_args(base)]
        if "parameters" not in members and kinds and isinstance(kinds[0], type):
            cls.parameters = kinds[0]

    @property
    def presets(self) -> Mapping[str, P]:
        """Return known sets of parameters, by name."""
        return {}

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

    def timed_job(self, parameters: P, rules: Traits) -> Job:
        """Return the job of a run with its expected time, in an engine of these rules."""
        return replace(self.job(parameters), seconds=self.seconds(parameters, rules))

    def measure(self, parameters: P, engine: Engine) -> Measured:
        """Run once in an engine and return what was measured.

        Raise EngineError for a run that failed, RequestError for one that it cannot state.
        """
        (output,) = engine.run([self.timed_job(parameters, engine.traits)])
        if isinstance(output, EngineError):
            raise output
        return self.measured(parameters, output, engine.traits)

    def profile(self, parameters: P, output: Output) -> Mapping[str, Sequence[float]]:
        """Return a run's profile as columns of one length; {} for a case without one."""
        return {}

    def plans(self, level: LevelName, traits: Traits) -> Sequence[Plan[P]]:
        """Return the runs of a level that the default :attr:`verification` judges."""
        return ()

    @property
    def verification(self) -> Verification:
        """Return what verifies the case."""
        verification: Verification = resolve_name(self.verified_by)(self)
        return verification

    @property
    def display(self) -> Display:
        """Return what shows the case."""
        display: Display = resolve_name(self.shown_by)(self)
        return display

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
