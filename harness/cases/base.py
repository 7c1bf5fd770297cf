"""The base of a case: what is simulated, measured and expected of it, and its checks as data.

A case is one module or folder. It names no engine. To add one, subclass :class:`Case`:

1. ``parameters`` (a frozen :class:`harness.model.base.Parameters`), ``quantities``, ``presets``;
2. ``job`` returns the job of a run: a scene, or a template with values;
3. ``measure`` returns the quantities of an output, ``exact`` those with a closed form;
4. ``checks`` lists what ``verify`` judges; the runner (:mod:`harness.cases.checks`) makes exactly
   one row of each, whatever happens;
5. ``sections`` shows the results in a report.

A quantity that takes several runs for one value, such as a critical angle, declares the parameters
that its search ``varies``, and is measured by ``search``.
"""

from __future__ import annotations

import functools
import math
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar

from pydantic import Field

from harness.cases.bench import Bench
from harness.engines.base import Engine, Job, Output
from harness.engines.output import Table
from harness.errors import EngineError, HarnessError, RequestError, Unsupported
from harness.model.base import Parameters
from harness.model.law import PLASTIC, NamedContact
from harness.report.content import Section
from harness.results.rows import LEVELS, Failure, Kind, Level, Tolerance

if TYPE_CHECKING:
    from harness.model.scene import Scene
    from harness.report.content import Discs

__all__ = ["LEVELS", "Case", "Check", "Level", "Quantity", "Value"]

P = TypeVar("P", bound=Parameters)
GUARDED = {"job", "measure", "exact"}  # calls of a case of another package


class Value(NamedTuple):
    """A measured value with its uncertainty, in the unit of its quantity.

    ``failure`` is the class of a failure where the measurement shows more than a number, as the
    first divergence of a series does.
    """

    value: float
    uncertainty: float = 0.0
    note: str = ""
    failure: Failure = Failure.NONE

    @classmethod
    def of(cls, measured: Value | float) -> Value:
        """Return what a measurement returns, a value or a plain number, as a value."""
        return measured if isinstance(measured, Value) else cls(float(measured))


@dataclass(frozen=True)
class Quantity(Generic[P]):
    """A quantity of a case.

    ``unit`` is "1" for a pure number. ``scale`` is the size that the quantity has in the case
    [unit], by the parameters of a run or one for all: tolerances on round-off are a part of it.
    ``varies`` are the parameters that a search for it varies, none for what one run measures. The
    closed form of a ``rigid`` one is that of rigid bodies, which small steps alone do not reach.
    """

    name: str
    unit: str
    meaning: str
    scale: float | Callable[[P], float] = 1.0
    varies: tuple[str, ...] = ()
    rigid: bool = False

    def size(self, parameters: P) -> float:
        """Return the scale [unit] for the parameters of a run."""
        return self.scale(parameters) if callable(self.scale) else self.scale


@dataclass(frozen=True, kw_only=True)
class Check:
    """One row of a verification: what is measured, what is expected, how close, and why so close.

    ``check`` names the route where a quantity of a setup is compared with two things. ``jobs`` are
    run in one batch with those of all other checks before anything is measured; an engine that
    refuses one of them is not tested. ``level`` is the shortest that runs the check, and its value
    must not depend on the level: another effort is another ``setup``. The difference of a finding
    is not judged; its tolerance, if any, is how far it may move from the accepted run. What is
    recorded has no expected value.
    """

    setup: str
    quantity: str
    unit: str
    measure: Callable[[Bench], Value | float]
    expected: float | Callable[[Bench], float] = float("nan")
    tolerance: Tolerance | Callable[[Bench], Tolerance] = field(default_factory=Tolerance)
    kind: Kind = Kind.CROSS_CODE
    level: Level = "quick"
    check: str = ""
    jobs: Sequence[Job] = ()
    note: str = ""

    def __post_init__(self) -> None:
        if self.level not in LEVELS or not all(isinstance(job, Job) for job in self.jobs):
            must = f"level must be one of {', '.join(LEVELS)}, jobs a list of Job"
            raise ValueError(f"a check has level {self.level!r}, jobs {self.jobs!r:.40}: {must}")


class Case(ABC, Generic[P]):
    """One system: parameters to a job, an output to quantities, and what is expected of them."""

    name: str
    group: str = ""
    summary: str  # one line, for lists
    parameters: ClassVar[type[Parameters]]
    quantities: Sequence[Quantity[Any]]
    search_options: type[Parameters] = Parameters  # of `search`, next to the parameters
    presets: Mapping[str, P]  # by name; the first is the default of `run`
    sources: Mapping[str, str] = MappingProxyType({})  # preset: where it was published
    solvers: Sequence[str] = ()  # names of solvers of this package that `solve` runs
    exact_by: ClassVar[str] = "closed form"  # in the legend of a figure: the source of `exact`
    has_figures: ClassVar[bool] = False  # at level quick: matplotlib is loaded while engines run

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if cls.__module__.partition(".")[0] != "harness":
            for name in GUARDED & vars(cls).keys():
                setattr(cls, name, _guarded(name, vars(cls)[name]))

    @property
    def default(self) -> P:
        """Return the parameters of a run for which none are given."""
        return next(iter(self.presets.values()))

    # ---- one run

    @abstractmethod
    def job(self, parameters: P) -> Job:
        """Return the job of one run. Raise RequestError for parameters that cannot be run."""

    @abstractmethod
    def measure(self, parameters: P, output: Output) -> Mapping[str, float]:
        """Return the quantities of a run. Raise EngineOutputError for an output that is cut."""

    def exact(self, parameters: P) -> Mapping[str, float]:
        """Return the quantities with a closed form."""
        return {}

    def reference(self, parameters: P, bench: Bench) -> Mapping[str, float]:
        """Return the quantities at equal steps, under the conventions of the bench's engine.

        Raise Unsupported where the reference cannot run the case.
        """
        scene = self.scene(parameters)
        if scene is None:
            raise Unsupported("the reference does not run this case")
        return self.measure(parameters, bench.reference_output(scene))

    def scene(self, parameters: P) -> Scene | None:
        """Return the scene of a run, None where it is no scene of spheres and walls."""
        return self.job(parameters).scene

    def solve(self, parameters: P, solver: str) -> Mapping[str, float]:
        """Return the quantities by one of :attr:`solvers`."""
        raise RequestError(f"--engine {solver!r}: case {self.name!r} has no such solver")

    def profile(self, parameters: P, output: Output) -> Mapping[str, Sequence[float]]:
        """Return columns of one length over a run, empty for a case without a profile."""
        return {}

    def discs(self, parameters: P, output: Output) -> Discs:
        """Return what a film of a run shows. Raise RequestError for a case without a film."""
        raise RequestError(f"--film: case {self.name!r} has no film")

    def film_job(self, parameters: P, frames: int) -> Job:
        """Return the job of a run whose samples make a film of so many frames."""
        return self.job(parameters)

    def cost(self, parameters: P) -> float:
        """Return the steps of a run times its moving bodies, for an estimate of its time."""
        scene = self.scene(parameters)
        return 0.0 if scene is None else float(scene.steps * len(scene.bodies))

    # ---- several runs

    def search(
        self, names: Sequence[str], parameters: P, bench: Bench, **options: Any
    ) -> Mapping[str, Value]:
        """Return quantities that take several runs, by name; ``options`` as `search_options`."""
        raise RequestError(f"--quantity {','.join(names)}: case {self.name!r} has no such search")

    # ---- verification and report

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, of all levels."""
        return ()

    def checks_up_to(self, engine: Engine, level: Level) -> Iterable[Check]:
        """Return the checks of an engine of a level and shorter ones; more do no harm.

        For a case in which a check takes time to make.
        """
        return self.checks(engine)

    def own_checks(self) -> Iterable[Check]:
        """Return the checks of this package's solvers, whose bench has no engine."""
        return ()

    def comparisons(self, engines: Sequence[Engine]) -> Iterable[tuple[Engine, Check]]:
        """Return the checks of engines against one another, whose benches are ``bench.others``."""
        return ()

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return the sections of a report, from benches that have run their checks, by engine.

        The bench of this package's solvers has the name ``harness``; ``rows`` and ``notes`` of a
        bench are those of its checks and of :meth:`notes`, by case.
        """
        return ()

    def notes(self, bench: Bench) -> Any:
        """Return what sections need of a bench besides rows and outputs, as something to pickle.

        It is called in the process that has run the checks.
        """
        return None

    def quantity(self, name: str) -> Quantity[Any]:
        """Return a quantity by name. Raise RequestError for another name."""
        for quantity in self.quantities:
            if quantity.name == name:
                return quantity
        names = ", ".join(quantity.name for quantity in self.quantities)
        raise RequestError(f"--quantity {name!r}: case {self.name!r} measures {names}")


# ---- cases of another package: an error of a call becomes one line


class CaseError(RequestError):
    """A call of a case that raises, or returns another type than the contract has."""


def case_error(case: Any, call: str, result: str, expected: str) -> CaseError:
    """Return the error of a call in one line: package, case, call, result and expected one."""
    package = type(case).__module__.partition(".")[0]
    where = "" if package == "harness" else f"package {package!r}, "
    return CaseError(f"{where}case {case.name!r}: {call} {result}, must return {expected}")


RETURNED = {
    "checks": (Check, "a list of harness.cases.base.Check"),
    "own_checks": (Check, "a list of harness.cases.base.Check"),
    "comparisons": (tuple, "a list of pairs (Engine, Check)"),
    "sections": (Section, "a list of harness.report.content.Section"),
}  # by the methods of a case


def returned(case: Case[Any], call: str, *arguments: Any) -> list[Any]:
    """Return the list that a method of a case makes; raise CaseError for anything else."""
    kind, must = RETURNED[call]
    method: Callable[..., Any] = case.checks_up_to if call == "checks" else getattr(case, call)
    try:
        items = list(method(*arguments))
    except (Unsupported, EngineError, CaseError):
        raise
    except Exception as error:  # a case of another package may raise anything
        text = " ".join(f"{type(error).__name__}: {error}".split())
        raise case_error(case, call, f"raised {text}", must) from None
    for item in items:
        if not isinstance(item, kind):
            name = type(item).__name__
            raise case_error(case, call, f"returned a {name} among its items", must)
    return items


def _guarded(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
    expected = "a Job" if name == "job" else "numbers by the names of quantities"

    @functools.wraps(call)
    def guarded(self: Any, *arguments: Any, **options: Any) -> Any:
        try:
            value = call(self, *arguments, **options)
        except HarnessError:
            raise
        except Exception as error:  # another package may raise anything
            place = traceback.extract_tb(error.__traceback__)[-1]
            text = " ".join(f"{type(error).__name__}: {error}".split())[:160]
            result = f"raised {text} ({Path(place.filename).name}, line {place.lineno})"
            raise case_error(self, name, result, expected) from error
        if name == "job":
            is_expected = isinstance(value, Job)
        else:
            numbers = value.values() if isinstance(value, Mapping) else [None]
            is_expected = all(isinstance(number, Real) for number in numbers)
        if not is_expected:
            raise case_error(self, name, f"returned a {type(value).__name__}", expected)
        return value

    return guarded


# ---- cases of a grain and equal spheres in a plane, with a linear contact

UNIT_MASS_DENSITY = 6.0 / math.pi  # [kg/m3] gives a sphere of 1 m the mass of 1 kg
COLUMNS = ("time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")


class EqualSpheres(Parameters):
    """A grain and spheres of its size, with a linear spring and a dashpot, in SI units."""

    # fmt: off
    contact: NamedContact = Field(PLASTIC, description="[-] dissipation of the contact")
    stiffness: float = Field(1e6, gt=0.0, description="[N/m] normal stiffness")
    steps_per_contact: float = Field(
        100.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)")
    diameter: float = Field(1.0, gt=0.0, description="[m] diameter of all spheres")
    density: float = Field(UNIT_MASS_DENSITY, gt=0.0, description="[kg/m3] density of the grain")
    gravity: float = Field(9.81, gt=0.0, description="[m/s2] acceleration of gravity")
    # fmt: on

    @property
    def mass(self) -> float:
        """Return the grain's mass [kg]."""
        return self.density * math.pi / 6.0 * self.diameter**3

    @property
    def contact_time(self) -> float:
        """Return pi sqrt(m / k) [s], the undamped contact time in which steps are counted."""
        return math.pi * math.sqrt(self.mass / self.stiffness)

    @property
    def step(self) -> float:
        """Return the time step [s]."""
        return self.contact_time / self.steps_per_contact


def path_in(output: Output, rows: int | None = None) -> Table:
    """Return the path of the grain, which is the first of several bodies, each column (M,).

    Raise EngineOutputError for samples that are missing, and for another number of ``rows``.
    """
    table = output.table(COLUMNS, rows)
    names = [name for name in ("step", *COLUMNS) if name in table]
    return {n: table[n][:, 0] if table[n].ndim == 2 else table[n] for n in names}
