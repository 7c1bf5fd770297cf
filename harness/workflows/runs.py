"""One run of a case: parameters from text, an engine or solver, quantities with references."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from harness import __version__
from harness.cases.base import Case, Value
from harness.cases.bench import Bench, output_of
from harness.cases.registry import get_case
from harness.engines.base import PARTICLES, Engine, Traits, job_seconds
from harness.engines.registry import DEFAULT, engine_class, engine_names
from harness.errors import EngineError, HarnessError, RequestError, Unsupported
from harness.model.base import Parameters
from harness.report.content import Summarized, value_text
from harness.store.cache import EngineChoice, opened
from harness.workflows import Progress, silent
from harness.workflows.executors import opened_on
from harness.workflows.settings import leaves, point_of, quantity_names, texts_of

if TYPE_CHECKING:
    import pandas as pd

    from harness.model.scene import Scene
    from harness.report.content import Discs

EQUAL_STEPS, CLOSED_FORM, NO_REFERENCE = "equal steps", "closed form", "none"
COLUMNS = ("value", "unit", "reference", "reference_kind", "difference", "limit", "step_error")
SEARCH_RUNS = 30  # runs of a search, for the estimate of its time
SOLVER_MICROSECONDS = 0.02  # of a body and step in a solver of this package, likewise
LIMIT_TARGET = 1e-9  # of a quantity's scale: error at which no finer run is made
RESOLVED = 1e-6  # of a quantity's scale, or
RESOLVED_SHARE = 0.1  # of the step's error: largest error of a limit that is returned
MOST_BODY_STEPS = 2_000_000  # steps times bodies of the finest run: a second in all
OpenEngine = Callable[[str], AbstractContextManager[Engine]]


@dataclass(frozen=True)
class Result:
    """A measured quantity with its reference and limit, in its unit; NaN for what is not known.

    ``reference`` is the value at equal steps, else the closed form, by ``reference_kind``;
    ``limit`` is the value of small steps, ``step_error`` how far equal steps are from it.
    ``uncertainty`` is that of a search.
    """

    value: float
    unit: str
    reference: float = math.nan
    reference_kind: str = NO_REFERENCE
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

    def __str__(self) -> str:
        text = f"{self.value:.10g} {self.unit if self.unit != '1' else ''}".rstrip()
        text = value_text(self.value, self.uncertainty, self.unit) if self.uncertainty else text
        if self.reference_kind == NO_REFERENCE:
            return text
        text += f"; {self.reference:.10g} by {self.reference_kind}, {self.difference:+.2g} off"
        if math.isnan(self.step_error):
            return text
        return f"{text}; limit {self.limit:.8g}, the step's error {self.step_error:+.2g}"


@dataclass(frozen=True, repr=False)
class RunResult(Summarized):
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
            "quantities": {name: result.to_json() for name, result in self.quantities.items()},
        }
        return record | ({"profile": dict(self.profile)} if self.profile else {})

    def to_frame(self) -> pd.DataFrame:
        """Return the quantities as a table, one row each; of a search with the uncertainty."""
        import pandas as pd

        rows = [{"quantity": name, **q.to_json()} for name, q in self.quantities.items()]
        uncertain = ["uncertainty"] * any(q.uncertainty for q in self.quantities.values())
        return pd.DataFrame(rows, columns=["quantity", *COLUMNS, *uncertain])

    def summary(self) -> dict[str, str]:
        """Return who ran the case with what, and the quantities with their references."""
        parameters = ((name, value) for name, value in leaves(self.parameters) if value is not None)
        values = ", ".join(f"{name} = {value}" for name, value in parameters)
        lines = {self.case: f"{self.engine} {self.engine_version}", "parameters": values}
        return lines | {name: str(result) for name, result in self.quantities.items()}


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
    degrees, and ``preset`` for a published set; a nested object such as ``PLASTIC`` may be whole.
    ``engine`` is an open engine, or the name of an engine or of a solver of the case.
    ``quantities`` are names of those to return; a search, such as ``critical_angle_deg``, takes
    several runs. ``profile``, ``script`` and ``film_frames`` (a number of samples) request these
    parts of the result. With an ``executor`` its workers run the engine of a name, in place of
    ``open_engine``. ``check_duration`` is called with the expected time on one core [s], and may
    raise.

    Raise RequestError for a name or value that is not allowed, and for an engine that cannot run
    the case, with the reason; EngineError for a run that failed.
    """
    chosen = get_case(case)
    names = quantity_names(chosen, quantities)
    point = point_of(chosen, texts_of(settings or {}), names)
    parameters = point.parameters
    if isinstance(engine, Engine):
        opening: AbstractContextManager[Engine] = nullcontext(engine)
    else:
        name = runner_name(chosen, engine)
        if is_solver(chosen, name):
            parts = {"--script": script, "--film": film_frames, "--profile": profile}
            for option in (option for option, wanted in parts.items() if wanted):
                raise RequestError(f"{option}: {name!r} is a solver, an engine is needed")
            check_duration(run_seconds(chosen, parameters, None, names))
            runner = (name, f"dem-harness {__version__}")
            return _result(chosen, parameters, names, runner, chosen.solve(parameters, name))
        opening = open_engine(name) if executor is None else opened_on(executor, name)
    with opening as running:
        job = chosen.job(parameters)
        if reason := running.refuses(job):
            raise RequestError(f"--engine {running.name!r}: cannot run {case!r}: {reason}")
        if profile and type(chosen).profile is Case.profile:
            raise RequestError(f"--profile: case {case!r} has no profile")
        text = running.script_text(job) if script else ""
        if script and not text:
            raise RequestError(f"--script: {running.title} runs case {case!r} without a script")
        check_duration(run_seconds(chosen, parameters, running.traits, names))
        progress(case, 0, 1)
        bench, runner = Bench(running), (running.name, running.identify().engine_version)
        if is_search(chosen, names):
            values = chosen.search(names, parameters, bench, **point.options)
            return _result(chosen, parameters, names, runner, values)
        output = bench.output(job)
        measured = chosen.measure(parameters, output)
        result = _result(chosen, parameters, names, runner, measured, bench)
        columns = chosen.profile(parameters, output) if profile else {}
        discs = None
        if film_frames:
            film = bench.output(chosen.film_job(parameters, film_frames))
            discs = chosen.discs(parameters, film)
        return replace(result, profile=columns, script=text, discs=discs)


# ---- who runs a case, and for how long


def runner_name(case: Case[Any], name: str | None) -> str:
    """Return the engine or solver of a name, the usual one for None; RequestError for others."""
    if name is None:
        return usual_runner(case)
    names = [*engine_names(), *case.solvers]
    if name not in names and ":" not in str(name):
        raise RequestError(f"--engine {name!r} is not known: must be one of {', '.join(names)}")
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


def is_search(case: Case[Any], names: Sequence[str]) -> bool:
    """Return whether quantities take several runs."""
    return any(case.quantity(name).varies for name in names)


def run_seconds(
    case: Case[Any], parameters: Parameters, traits: Traits | None, names: Sequence[str] = ()
) -> float:
    """Return the expected time of a run on one core [s]; ``traits`` is None for a solver."""
    runs = SEARCH_RUNS if is_search(case, names) else 1
    if traits is None:
        return runs * case.cost(parameters) * SOLVER_MICROSECONDS * 1e-6
    job = case.job(parameters)
    if job.seconds or type(case).cost is Case.cost:
        return runs * job_seconds(job, traits)
    return runs * case.cost(parameters) / PARTICLES * traits.microseconds_per_step * 1e-6


# ---- references and limits


def _result(
    case: Case[Any],
    parameters: Parameters,
    names: Sequence[str],
    runner: tuple[str, str],
    values: Mapping[str, Value | float],
    bench: Bench | None = None,
) -> RunResult:
    """Return measured values, those of ``names`` if given, with closed forms.

    With the bench of a single run they have references at equal steps and limits of small steps.
    """
    exact: Mapping[str, float] = {}
    exact_limits: Mapping[str, float] = {}
    reference: Mapping[str, float] = {}
    limits: Mapping[str, float] = {}
    with suppress(HarnessError):  # a closed form may not exist for these parameters
        exact = case.exact(parameters)
        rigid = {quantity.name for quantity in case.quantities if quantity.rigid}
        exact_limits = {name: exact[name] for name in exact.keys() - rigid}
    if bench is not None:
        with suppress(Unsupported, EngineError):
            reference = case.reference(parameters, bench)
            others = [name for name in values if name not in exact_limits]
            limits = limits_of(case, parameters, bench, others)
    quantities = {}
    for quantity in case.quantities:
        name = quantity.name
        if name not in values or (names and name not in names):
            continue
        value = Value.of(values[name])
        expected = float({**exact, **reference}.get(name, math.nan))
        closed = NO_REFERENCE if math.isnan(expected) else CLOSED_FORM
        quantities[name] = Result(
            value=value.value,
            unit=quantity.unit,
            reference=expected,
            reference_kind=EQUAL_STEPS if name in reference else closed,
            limit=float({**limits, **exact_limits}.get(name, math.nan)),
            uncertainty=value.uncertainty,
        )
    varied = {parameter for name in names for parameter in case.quantity(name).varies}
    record = parameters.model_dump(mode="json", exclude=varied)
    return RunResult(case.name, *runner, record, quantities)


def limits_of(
    case: Case[Any], parameters: Parameters, bench: Bench, names: Sequence[str]
) -> dict[str, float]:
    """Return the limits of small steps by name, of those quantities where it is resolved.

    None for a case whose reference is not one scene.
    """
    from harness.solvers import reference

    scene = case.scene(parameters)
    if not names or scene is None or type(case).reference is not Case.reference:
        return {}
    rules, first = bench.rules(scene), scene.steps

    def quantities(steps: int) -> Mapping[str, float]:
        finer = refined(scene, steps // first)
        output = output_of(reference.run(finer, rules), scene)  # at the times of its samples
        values = case.measure(parameters, output)
        return {name: values[name] for name in names if name in values}

    scales = {name: case.quantity(name).size(parameters) for name in names}
    targets = {name: LIMIT_TARGET * scale for name, scale in scales.items()}
    most = max(MOST_BODY_STEPS // len(scene.bodies), first)
    try:
        limits = reference.limit(quantities, targets, first=first, most=most)
    except (EngineError, RequestError):  # a finer run overflows, or is another system
        return {}
    coarse = quantities(first)
    largest = {
        name: max(RESOLVED * scales[name], RESOLVED_SHARE * abs(limit.value - coarse[name]))
        for name, limit in limits.items()
    }
    return {name: limit.value for name, limit in limits.items() if limit.error <= largest[name]}


def refined(scene: Scene, factor: int) -> Scene:
    """Return a scene with steps that are a whole factor smaller, sampled at the same times."""
    return scene.replace(
        step=scene.step / factor,
        steps=scene.steps * factor,
        every=scene.every * factor,
        segments=tuple(part.replace(steps=part.steps * factor) for part in scene.segments),
        setups=tuple(at * factor for at in scene.setups),
    )
