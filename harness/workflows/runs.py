"""One run of a case: parameters from text, an engine or solver, quantities with references."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

from harness import __version__
from harness.cases.base import Case, Value
from harness.cases.bench import Bench
from harness.cases.registry import get_case
from harness.engines.base import Engine, Output, Traits
from harness.engines.cost import PARTICLES, job_seconds
from harness.engines.registry import DEFAULT, engine_class, engine_names
from harness.errors import EngineError, HarnessError, RequestError, Unsupported
from harness.model.base import Parameters
from harness.report.notebook import Shown
from harness.store.cache import EngineChoice, opened
from harness.workflows.executors import opened_on
from harness.workflows.limits import limits_of
from harness.workflows.progress import Progress, silent
from harness.workflows.settings import flat, parameters_of, quantity_names, split_settings

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.content import Discs
    from harness.report.style import Figure

EQUAL_STEPS, CLOSED_FORM, NONE = "equal steps", "closed form", "none"
COLUMNS = ("value", "unit", "reference", "reference_kind", "difference", "limit", "step_error")
SEARCH_RUNS = 30  # runs of a search, for the estimate of its time
SOLVER_MICROSECONDS = 0.02  # of a body and step in a solver of this package, likewise
OpenEngine = Callable[[str], AbstractContextManager[Engine]]


@dataclass(frozen=True)
class Result:
    """A measured quantity with what is known of it, in its unit; NaN for what is not known.

    ``reference`` is the value at equal steps, else the closed form, as ``reference_kind`` says;
    ``limit`` is the value of small steps, ``step_error`` how far equal steps are from it.
    ``uncertainty`` is that of a search.
    """

    value: float
    unit: str
    reference: float = math.nan
    reference_kind: str = NONE
    limit: float = math.nan
    uncertainty: float = 0.0

    @property
    def difference(self) -> float:
        """Return value - reference."""
        return self.value - self.reference

    @property
    def step_error(self) -> float:
        """Return the value at equal steps less the limit."""
        return self.reference - self.limit if self.reference_kind == EQUAL_STEPS else math.nan

    def to_json(self) -> dict[str, Any]:
        """Return the columns of a quantity; the uncertainty where there is one."""
        record = {name: getattr(self, name) for name in COLUMNS}
        return record | ({"uncertainty": self.uncertainty} if self.uncertainty else {})


@dataclass(frozen=True, repr=False)
class RunResult(Shown):
    """One run of a case: who ran it, with which parameters, and what was measured.

    ``profile`` are columns of one length of a case that has a profile, ``script`` the plain script
    of the run, ``discs`` what a film of it shows; they are made on request.
    """

    case: str
    engine: str
    engine_version: str
    parameters: Mapping[str, Any]
    quantities: Mapping[str, Result]
    profile: Mapping[str, Sequence[float]] = field(default_factory=dict)
    script: str = ""
    discs: Discs | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the run as a JSON-ready mapping; the profile where there is one."""
        record: dict[str, Any] = {
            "case": self.case,
            "engine": self.engine,
            "engine_version": self.engine_version,
            "parameters": dict(self.parameters),
            "quantities": {name: found.to_json() for name, found in self.quantities.items()},
        }
        return record | ({"profile": dict(self.profile)} if self.profile else {})

    def to_frame(self) -> pd.DataFrame:
        """Return the quantities as a table, one row each."""
        import pandas as pd

        rows = [{"quantity": name, **q.to_json()} for name, q in self.quantities.items()]
        return pd.DataFrame(rows, columns=["quantity", *COLUMNS])

    def summary(self) -> dict[str, str]:
        """Return who ran the case with what, and the quantities with their references."""
        values = ", ".join(f"{name} = {value}" for name, value in flat(self.parameters).items())
        lines = {self.case: f"{self.engine} {self.engine_version}", "parameters": values}
        lines |= {name: quantity_text(found) for name, found in self.quantities.items()}
        more = [q.name for q in get_case(self.case).quantities if q.varies]
        of_search = not more or self.quantities.keys() & set(more)
        return lines if of_search else lines | {"by --quantity, of several runs": ", ".join(more)}

    def draw(self) -> Figure:
        """Draw the difference of each quantity from its reference, over the reference."""
        from harness.report.style import Figure, label

        figure = Figure(figsize=(7.0, 1.3 + 0.4 * len(self.quantities)), layout="constrained")
        axes = figure.add_subplot()
        for place, found in enumerate(self.quantities.values()):
            axes.plot(found.difference / (abs(found.reference) or 1.0), place, "o")
            if found.reference_kind == NONE:
                across = axes.get_yaxis_transform()
                axes.text(0.5, place, "no reference", va="center", transform=across)
        axes.axvline(0.0, color="black", ls="--", lw=1)
        axes.set_yticks(range(len(self.quantities)), [*self.quantities])
        axes.set_ylim(len(self.quantities) - 0.5, -0.5)
        label(axes, "difference over the reference (over 1 where that is 0)", "", self.case)
        return figure


def run(  # noqa: PLR0913 - the options of a user
    case: str,
    settings: Mapping[str, Any] | None = None,
    engine: EngineChoice = None,
    *,
    quantities: str | Iterable[str] = (),
    open_engine: OpenEngine = opened,
    executor: Executor | None = None,
    profile: bool = False,
    script: bool = False,
    film_frames: int = 0,
    check_duration: Callable[[float], None] = lambda _: None,
    progress: Progress = silent,
) -> RunResult:
    """Run a case once and return its quantities with their references.

    ``settings`` are values by the names of parameters, of nested ones with a dot, in SI units and
    degrees, and ``preset`` for a known set. ``engine`` is an open engine, or the name of an engine
    or of a solver of the case. ``quantities`` are names of those to return; one that is searched
    for, such as ``critical_angle_deg``, takes several runs. ``profile``, ``script`` and
    ``film_frames`` (a number of samples) request these parts of the result. With an ``executor``
    its workers run the engine of a name, in place of ``open_engine``. ``check_duration`` is called
    with the expected time on one core [s], and may raise.

    Raise RequestError for a name or value that is not allowed, and for an engine that cannot run
    the case, with the reason; EngineError for a run that failed.
    """
    chosen = get_case(case)
    names = quantity_names(chosen, quantities)
    given = {n: "none" if value is None else str(value) for n, value in (settings or {}).items()}
    texts, options = split_settings(chosen, given, names)
    parameters = parameters_of(chosen, texts)
    if not isinstance(engine, Engine):
        name = runner_name(chosen, engine)
        if is_solver(chosen, name):
            if script or film_frames or profile:
                part = "--script" if script else "--film" if film_frames else "--profile"
                raise RequestError(f"{part}: {name!r} is a solver, an engine is needed")
            check_duration(run_seconds(chosen, parameters, None, names))
            return _solved(chosen, parameters, name, names)
        opening = open_engine if executor is None else partial(opened_on, executor)
        with opening(name) as running:
            return run(
                case, settings, running, quantities=quantities, profile=profile, script=script,
                film_frames=film_frames, check_duration=check_duration, progress=progress,
            )  # fmt: skip
    job = chosen.job(parameters)
    if reason := engine.refuses(job):
        raise RequestError(f"--engine {engine.name!r}: cannot run {chosen.name!r}: {reason}")
    if profile and type(chosen).profile is Case.profile:
        raise RequestError(f"--profile: case {chosen.name!r} has no profile")
    text = engine.script_text(job) if script else ""
    if script and not text:
        raise RequestError(f"--script: {engine.title} runs case {chosen.name!r} without a script")
    check_duration(run_seconds(chosen, parameters, engine.traits, names))
    progress(case, 0, 1)
    bench, version = Bench(engine), engine.identify().engine_version
    if searched(chosen, names):
        found = chosen.search(names, parameters, bench, **options)
        results = {n: _searched(chosen, parameters, n, found[n]) for n in names if n in found}
        varied = {name for n in names for name in chosen.quantity(n).varies}
        values = parameters.model_dump(mode="json", exclude=varied)
        return RunResult(case, engine.name, version, values, results)
    output = bench.output(job)
    discs = None
    if film_frames:
        filmed = bench.output(chosen.film_job(parameters, film_frames))
        discs = chosen.discs(parameters, filmed)
    return RunResult(
        case, engine.name, version, parameters.model_dump(mode="json"),
        measured(chosen, parameters, bench, output, names),
        chosen.profile(parameters, output) if profile else {}, text, discs,
    )  # fmt: skip


def runner_name(case: Case[Any], name: str | None) -> str:
    """Return the engine or solver of a name, the usual one for None; RequestError for others."""
    if name is None:
        return usual_runner(case)
    known = [*engine_names(), *case.solvers]
    if name not in known and ":" not in name:
        raise RequestError(f"--engine {name!r} is not known: must be one of {', '.join(known)}")
    return name


def usual_runner(case: Case[Any]) -> str:
    """Return the default engine, or the first solver of a case that it cannot run."""
    takes = takes_job(engine_class(DEFAULT), case) if case.solvers else True
    return DEFAULT if takes else case.solvers[0]


def takes_job(kind: type[Engine], case: Case[Any]) -> bool:
    """Return whether engines of a class run jobs like a case's: by a script, or as scenes."""
    job = case.job(case.default)
    takes_scenes = job.scene is not None and kind.rules is not Engine.rules
    return takes_scenes or kind.has_template(job.template)


def is_solver(case: Case[Any], name: str) -> bool:
    """Return whether a name is that of a solver of a case, of this package."""
    return name in case.solvers and name not in engine_names()


def searched(case: Case[Any], names: Sequence[str]) -> bool:
    """Return whether quantities take several runs."""
    return any(case.quantity(name).varies for name in names)


def run_seconds(
    case: Case[Any], parameters: Parameters, traits: Traits | None, names: Sequence[str] = ()
) -> float:
    """Return the expected time of a run on one core [s]; ``traits`` is None for a solver."""
    runs = SEARCH_RUNS if searched(case, names) else 1
    if traits is None:
        return runs * case.cost(parameters) * SOLVER_MICROSECONDS * 1e-6
    job = case.job(parameters)
    if job.seconds or type(case).cost is Case.cost:
        return runs * job_seconds(job, traits)
    return runs * case.cost(parameters) / PARTICLES * traits.microseconds_per_step * 1e-6


def measured(
    case: Case[Any], parameters: Parameters, bench: Bench, output: Output, names: Sequence[str] = ()
) -> dict[str, Result]:
    """Return the quantities of an output with their references; those of ``names`` if given."""
    values, exact = case.measure(parameters, output), case.exact(parameters)
    try:
        reference: Mapping[str, float] = case.reference(parameters, bench)
        limits = limits_of(case, parameters, bench, [n for n in values if n not in exact])
    except (Unsupported, EngineError):
        reference, limits = {}, {}
    results = {}
    for quantity in case.quantities:
        name = quantity.name
        if name in values and (not names or name in names):
            kind, expected = _reference(name, reference, exact)
            limit = exact.get(name, limits.get(name, math.nan))
            value = float(values[name])
            results[name] = Result(value, quantity.unit, float(expected), kind, float(limit))
    return results


def quantity_text(found: Result) -> str:
    """Return a quantity in words: value, reference and difference."""
    text = f"{found.value:.10g} {found.unit if found.unit != '1' else ''}".rstrip()
    text += f" +- {found.uncertainty:.2g}" if found.uncertainty else ""
    if found.reference_kind == NONE:
        return text
    text += f"; {found.reference:.10g} by {found.reference_kind}, {found.difference:+.2g} off"
    if math.isnan(found.step_error):
        return text
    return f"{text}; limit {found.limit:.8g}, the step's error {found.step_error:+.2g}"


def _reference(
    name: str, reference: Mapping[str, float], exact: Mapping[str, float]
) -> tuple[str, float]:
    if name in reference:
        return EQUAL_STEPS, reference[name]
    found = exact.get(name, math.nan)
    return (NONE if math.isnan(found) else CLOSED_FORM), found


def _solved(
    case: Case[Any], parameters: Parameters, solver: str, names: Sequence[str]
) -> RunResult:
    values, exact = case.solve(parameters, solver), case.exact(parameters)
    results = {}
    for quantity in case.quantities:
        if quantity.name in values and (not names or quantity.name in names):
            kind, expected = _reference(quantity.name, {}, exact)
            value = float(values[quantity.name])
            results[quantity.name] = Result(value, quantity.unit, expected, kind, expected)
    version = f"dem-harness {__version__}"
    return RunResult(case.name, solver, version, parameters.model_dump(mode="json"), results)


def _searched(case: Case[Any], parameters: Parameters, name: str, found: Value | float) -> Result:
    value = found if isinstance(found, Value) else Value(float(found))
    exact: Mapping[str, float] = {}
    with suppress(HarnessError):  # a closed form may not exist for these parameters
        exact = case.exact(parameters)
    kind, expected = _reference(name, {}, exact)
    unit = case.quantity(name).unit
    return Result(value.value, unit, expected, kind, expected, value.uncertainty)
