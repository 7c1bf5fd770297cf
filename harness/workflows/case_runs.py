"""The cases as a command sees them: listed, given settings as text, run once.

A run has quantities with their references.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pydantic_core import PydanticUndefined

from harness import __version__
from harness.cases.contract import Case, Measured, Reference
from harness.cases.registry import MAIN, all_cases, get_case
from harness.engines.contract import Engine
from harness.engines.registry import DEFAULT, engine_class, engine_names
from harness.engines.traits import Traits
from harness.errors import RequestError
from harness.observables.row import Row
from harness.parameters.allowed import allowed_in, unit_in
from harness.parameters.base import Parameters, nested
from harness.shown import Listing, Record, Result
from harness.store.cache import EngineChoice, opened
from harness.workflows.progress import Progress, silent
from harness.workflows.verification import Open

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.film import Film
    from harness.shown.figure import Figure


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter: its default (None where it must be given), unit and meaning."""

    default: Any
    unit: str
    description: str


@dataclass(frozen=True)
class CaseInfo(Record):
    """A case as it is listed.

    ``parameters`` are named as ``--set`` takes them, those of nested objects with a dot;
    ``quantities`` map a name to its unit; ``engines`` have a template for the case, or take its
    scene; ``solvers`` are those of this package; ``presets`` known sets of parameters; ``derived``
    are quantities, with their units, that take several runs for a value.
    """

    name: str
    group: str
    summary: str
    parameters: Mapping[str, ParameterInfo]
    quantities: Mapping[str, str]
    engines: tuple[str, ...]
    solvers: tuple[str, ...] = ()
    presets: tuple[str, ...] = ()
    by_default: bool = field(default=False)
    derived: Mapping[str, str] = field(default_factory=dict)


def cases() -> Listing[CaseInfo]:
    """Return every case that can be used, those of this package first."""
    return Listing(_info(case) for case in all_cases().values())


def _info(case: Case[Any]) -> CaseInfo:
    return CaseInfo(
        name=case.name,
        group=case.group,
        summary=case.summary,
        parameters=dict(_parameters(case.parameters, default_of(case), "")),
        quantities={quantity.name: quantity.unit for quantity in case.quantities},
        engines=tuple(name for name in engine_names() if _states(name, case)),
        solvers=case.solvers,
        presets=tuple(case.presets),
        by_default=case.name in MAIN,
        derived={
            quantity.name: quantity.unit for more in case.derived() for quantity in more.quantities
        },
    )


@dataclass(frozen=True)
class ParameterDetails(ParameterInfo):
    """As :class:`ParameterInfo`, and what is ``allowed``: words, or bounds in words."""

    allowed: str = ""


@dataclass(frozen=True)
class PresetDetails:
    """Where the values of a preset come from, empty for this package, and what it changes."""

    source: str
    values: Mapping[str, Any]


@dataclass(frozen=True)
class CaseDetails(CaseInfo):
    """One case in full, as :class:`CaseInfo`.

    ``meanings`` are those of the quantities, ``preset_details`` by the names of ``presets``,
    ``derived_parameters`` what the quantities of ``derived`` take besides;
    ``refused_by`` says why an engine cannot run the case as it is by default.
    """

    parameters: Mapping[str, ParameterDetails]
    meanings: Mapping[str, str] = field(default_factory=dict)
    preset_details: Mapping[str, PresetDetails] = field(default_factory=dict)
    derived_parameters: Mapping[str, ParameterDetails] = field(default_factory=dict)
    refused_by: Mapping[str, str] = field(default_factory=dict)


def case_details(name: str) -> CaseDetails:
    """Return all that is known of a case; raise RequestError for a name that is not known."""
    case = get_case(name)
    info = _info(case)
    usual = {key: parameter.default for key, parameter in info.parameters.items()}
    changed = {
        preset: {
            key: parameter.default
            for key, parameter in parameters_in(values)
            if parameter.default != usual.get(key)
        }
        for preset, values in case.presets.items()
    }
    refused = {engine: _why_not(engine, case) for engine in engine_names()}
    return CaseDetails(
        **{
            **vars(info),
            "parameters": _details(case),
        },
        meanings={
            quantity.name: quantity.meaning
            for kind in (case, *case.derived())
            for quantity in kind.quantities
        },
        preset_details={
            preset: PresetDetails(case.source_of(preset), values)
            for preset, values in changed.items()
        },
        derived_parameters={
            key: details
            for more in case.derived()
            for key, details in _details(more).items()
            if key not in info.parameters
        },
        refused_by={engine: reason for engine, reason in refused.items() if reason},
    )


def _details(case: Case[Any]) -> dict[str, ParameterDetails]:
    allowed = dict(_allowed(case.parameters, ""))
    return {
        key: ParameterDetails(**vars(parameter), allowed=allowed.get(key, ""))
        for key, parameter in _parameters(case.parameters, default_of(case), "")
    }


def _allowed(kind: type[Parameters], prefix: str) -> Iterator[tuple[str, str]]:
    for name, limits in allowed_in(kind).items():
        yield prefix + name, ", ".join(limits.words) or limits.range
    for name, declared in kind.model_fields.items():
        inner = declared.annotation
        if isinstance(inner, type) and issubclass(inner, Parameters):
            yield from _allowed(inner, f"{prefix}{name}.")


def _why_not(engine: str, case: Case[Any]) -> str:
    try:
        kind = engine_class(engine)
        if not kind.states(case.template):
            scene = "does not take its scene" if case.template.scene else "the case has no scene"
            return f"it has no script for the case, and {scene}"
        return kind.traits.refuses(case.job(case.default).values)
    except RequestError as error:
        return str(error)


def _states(engine: str, case: Case[Any]) -> bool:
    """Return whether an engine can run a case; one that cannot be imported can not."""
    try:
        return engine_class(engine).states(case.template)
    except RequestError:
        return False


def default_of(case: Case[Any]) -> Parameters | None:
    """Return the parameters of a run that sets none, or None where some must be set."""
    try:
        parameters: Parameters = case.default
        return parameters
    except RequestError:
        return None


def parameters_in(values: Parameters) -> list[tuple[str, ParameterInfo]]:
    """Return the names, of nested ones with a dot, and what is known of each; values as default."""
    return list(_parameters(type(values), values, ""))


def _parameters(
    kind: type[Parameters], values: Parameters | None, prefix: str
) -> Iterator[tuple[str, ParameterInfo]]:
    for name, declared in kind.model_fields.items():
        value = getattr(values, name) if values is not None else declared.default
        if isinstance(value, Parameters):
            yield from _parameters(type(value), value, f"{prefix}{name}.")
            continue
        text = declared.description or ""
        meaning = text.partition("]")[2].strip() if text.startswith("[") else text
        default = None if value is PydanticUndefined else value
        yield prefix + name, ParameterInfo(default, unit_in(text), meaning)


PRESET = "preset"
NONE = "none"
"""Text of a value that is left out."""

Tree = dict[str, Any]
"""Settings by name; a nested one is a tree of its own."""


def parameters_of(case: Case[Any], settings: Mapping[str, str]) -> Parameters:
    """Return the parameters of a case with settings as ``height=3`` and ``contact.tail=clipped``.

    ``preset`` chooses the set that they change. Raise RequestError, naming the setting and what
    is allowed, for a name or value that is not, CombinationError for values that are not together.
    """
    base = _preset(case, settings[PRESET]) if PRESET in settings else default_of(case)
    tree = _tree((name, text) for name, text in settings.items() if name != PRESET)
    for name in case.varied:
        if name in tree:
            raise RequestError(
                f"--set: {name}: {case.quantities[0].name} is searched for over {name}: must be "
                "left out"
            )
    try:
        if base is None:
            return case.parameters(**_values(case.parameters, tree))
        return _changed(base, tree, "")
    except RequestError as error:
        raise type(error)(f"--set: {error}{_elsewhere(case, tree)}") from None


def _elsewhere(case: Case[Any], names: Iterable[str]) -> str:
    """Return which case of the same group has the parameter that a case does not; or nothing."""
    unknown = [name for name in names if name not in case.parameters.model_fields]
    having = [
        f"; case {other.name} has {name}"
        for name in unknown[:1]
        for other in all_cases().values()
        if other.group == case.group and name in other.parameters.model_fields
    ]
    return having[0] if having else ""


def _tree(settings: Iterable[tuple[str, str]]) -> Tree:
    try:
        return nested(settings)
    except ValueError as error:
        raise RequestError(f"--set {error}") from None


def _preset(case: Case[Any], name: str) -> Parameters:
    if name not in case.presets:
        presets = ", ".join(case.presets) or "none"
        raise RequestError(f"--set preset={name}: case {case.name!r} has the presets {presets}")
    parameters: Parameters = case.presets[name]
    return parameters


def _changed(parameters: Parameters, tree: Tree, prefix: str) -> Parameters:
    fields = type(parameters).model_fields
    changes = _values(type(parameters), {k: v for k, v in tree.items() if not isinstance(v, dict)})
    for name, part in tree.items():
        if not isinstance(part, dict):
            continue
        nested = getattr(parameters, name, None)
        if name in fields and not isinstance(nested, Parameters):
            raise RequestError(f"{prefix}{name} has no parts (given: {', '.join(part)})")
        # a name that is not known is refused, with those that are, by replace()
        changes[name] = _changed(nested, part, f"{prefix}{name}.") if nested is not None else part
    return parameters.replace(**changes)


def _values(kind: type[Parameters], tree: Tree) -> Tree:
    """Return settings as values: whole numbers, and ``none`` where one may be left out."""
    return {name: _value(kind, name, text) for name, text in tree.items()}


def _value(kind: type[Parameters], name: str, text: Any) -> Any:
    field = kind.model_fields.get(name)
    if field is None or not isinstance(text, str):
        return text
    if text == NONE and type(None) in getattr(field.annotation, "__args__", ()):
        return None
    # a strict whole number is not read from a text
    is_whole_number = field.annotation is int and text.strip().lstrip("+-").isdecimal()
    return int(text) if is_whole_number else text


NO_RULES = Traits(install_hint="", versions=(), integrator="")
"""Of a solver, which follows the parameters as they are."""


@dataclass(frozen=True, repr=False)
class RunResult(Result):
    """One run of a case: who ran it, with which parameters, and what was measured.

    A quantity is expected to be what its reference is, whose kind is the row's ``note``.
    ``profile`` are columns of one length, of a case that has a profile.
    """

    case: str
    engine: str
    engine_version: str
    parameters: Mapping[str, Any]
    quantities: Mapping[str, Row]
    profile: Mapping[str, Sequence[float]] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Return it as a JSON-ready mapping; the profile, where there is one, by its columns."""
        rows = {name: _record(row) for name, row in self.quantities.items()}
        fields = {**vars(self), "parameters": dict(self.parameters), "quantities": rows}
        return fields if self.profile else {k: v for k, v in fields.items() if k != "profile"}

    def to_frame(self) -> pd.DataFrame:
        """Return the quantities as a table, one row each."""
        import pandas as pd

        rows = [{"quantity": name, **_record(row)} for name, row in self.quantities.items()]
        return pd.DataFrame(rows, columns=["quantity", *COLUMNS])

    def summary(self) -> dict[str, str]:
        """Return the quantities with their references, and who ran the case."""
        lines = {name: _quantity_text(row) for name, row in self.quantities.items()}
        return {**lines, "case": self.case, "engine": f"{self.engine} {self.engine_version}"}

    def draw(self) -> Figure:
        """Draw how far each quantity is off its reference; those without one are named so."""
        from harness.shown.figure import Figure, label

        figure = Figure(figsize=(7.0, 1.3 + 0.4 * len(self.quantities)), layout="constrained")
        axes = figure.add_subplot()
        for place, row in enumerate(self.quantities.values()):
            off = row.difference / (abs(row.expected) or 1.0)
            if math.isnan(off):
                across = axes.get_yaxis_transform()
                axes.text(0.5, place, "no reference", va="center", transform=across)
            axes.plot(off, place, "o")
        axes.axvline(0.0, color="black", ls="--", lw=1)
        axes.set_yticks(range(len(self.quantities)), [*self.quantities])
        axes.set_ylim(len(self.quantities) - 0.5, -0.5)
        label(axes, "difference over the reference (over 1 where that is 0)", "quantity", self.case)
        return figure


def run(
    case: str,
    settings: Mapping[str, str] | None = None,
    engine: EngineChoice = None,
    *,
    quantities: str | Sequence[str] = (),
    open_one: Open | None = None,
    fresh: bool = False,
    progress: Progress = silent,
    check_duration: Callable[[float], None] = lambda _: None,
) -> RunResult:
    """Run a case once and return its quantities with their references.

    ``settings`` are texts by the names of parameters, in SI units and degrees as :func:`cases`
    lists them (k in [N/m]), of nested ones with a dot, and ``preset`` for a known set; each
    quantity names its unit. ``quantities`` are names of those to return; a derived one, such as
    ``critical_angle_deg``, takes several runs. ``engine`` is an open engine, or the name of an
    engine or of a solver of the case; the default engine unless given. ``open_one`` opens one by
    its name; else runs are kept, and ``fresh`` makes them again. Raise RequestError for a name or
    value that is not allowed, for an engine that cannot run the case, with the reason;
    EngineError for a run that failed. ``check_duration`` is called with the expected time [s], and
    may raise.
    """
    wanted = [quantities] if isinstance(quantities, str) else list(quantities)
    chosen = get_case(case).measuring(wanted)
    parameters = parameters_of(chosen, settings or {})

    def begin(rules: Traits | None, solver: str = "") -> None:
        check_duration(chosen.seconds(parameters, rules, solver))
        progress(case, 0, 1)

    if isinstance(engine, Engine):
        begin(engine.traits)
        return _in_engine(chosen, parameters, engine, wanted)
    name = engine_for(chosen, engine)
    if name in chosen.solvers and (engine is None or name not in engine_names()):
        begin(None, name)
        measured = chosen.solve(parameters, name)
        solver = (name, f"dem-harness {__version__}")
        return _result(chosen, parameters, solver, measured, NO_RULES, wanted)
    with open_one(name) if open_one else opened(name, fresh=fresh) as running:
        begin(running.traits)
        return _in_engine(chosen, parameters, running, wanted)


def film(
    case: str,
    settings: Mapping[str, str] | None = None,
    engine: EngineChoice = None,
    *,
    frames: int = 120,
    fresh: bool = False,
) -> Film:
    """Run a case once and return the film of its motion, which a notebook shows.

    ``settings`` are those of :func:`run`, ``engine`` an open one or a name. ``save(path)`` writes
    it as .gif, or .mp4 where ffmpeg is on the path. Raise RequestError for a case without films,
    and for an engine that cannot run one.
    """
    from harness.report.film import check_frames

    chosen = get_case(case)
    check_frames(frames, "film")
    if not chosen.display.has_film:
        have = [other.name for other in all_cases().values() if other.display.has_film]
        raise RequestError(f"film: case {case!r} has none; must be one of {', '.join(have)}")
    parameters = parameters_of(chosen, settings or {})
    with opened(engine, fresh=fresh) as running:
        check_film(case, settings, running, frames)
        return chosen.display.film(running, parameters, frames)


def check_film(
    case: str, settings: Mapping[str, str] | None, engine: Engine, frames: int = 120
) -> None:
    """Raise RequestError, before anything is run, for an engine that cannot run a film's jobs."""
    chosen = get_case(case)
    parameters = parameters_of(chosen, settings or {})
    for job in chosen.display.film_jobs(parameters, frames):
        if reason := engine.refuses(job):
            raise RequestError(f"film: {engine.title} cannot run it: {reason}")


def usual_engine(case: Case[Any]) -> str:
    """Return the default engine, or the first solver of a case that it cannot state."""
    if case.solvers and not engine_class(DEFAULT).states(case.template):
        return case.solvers[0]
    return DEFAULT


def is_solver(case: Case[Any], name: str) -> bool:
    """Return whether a name is that of a solver of a case, of this package."""
    return name in case.solvers and name not in engine_names()


def engine_for(case: Case[Any], engine: str | None) -> str:
    """Return who runs a case; raise RequestError for a name that is not known."""
    name = engine or usual_engine(case)
    if name not in (*engine_names(), *case.solvers) and ":" not in name:
        names = ", ".join([*engine_names(), *case.solvers])
        raise RequestError(f"--engine {name!r} is not known: must be one of {names}")
    return name


def _in_engine(
    case: Case[Any], parameters: Parameters, engine: Engine, wanted: Sequence[str]
) -> RunResult:
    reason = engine.refuses(case.job(parameters))
    if reason:
        raise RequestError(f"--engine {engine.name!r}: cannot run {case.name!r}: {reason}")
    measured = case.measure(parameters, engine)
    provenance = measured.provenance or engine.identify()
    named = (engine.name, provenance.engine_version)
    return _result(case, parameters, named, measured, engine.traits, wanted)


def _result(
    case: Case[Any],
    parameters: Parameters,
    engine: tuple[str, str],
    measured: Measured,
    traits: Traits,
    wanted: Sequence[str],
) -> RunResult:
    references = case.references(parameters, traits)
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    return RunResult(
        case=case.name,
        engine=engine[0],
        engine_version=engine[1],
        parameters=parameters.model_dump(mode="json", exclude=set(case.varied)),
        quantities={
            name: _quantity(name, measured.values[name], unit, references.get(name))
            for name, unit in units.items()
            if name in measured.values and (not wanted or name in wanted)
        },
        profile=measured.profile,
    )


COLUMNS = ("value", "unit", "reference", "reference_kind", "difference")
"""Keys of a quantity of a run."""


def _record(row: Row) -> dict[str, Any]:
    values = (row.value, row.unit, row.expected, row.note, row.difference)
    return dict(zip(COLUMNS, values, strict=True))


def _quantity(name: str, value: float, unit: str, reference: Reference | None) -> Row:
    expected = reference or Reference(math.nan, "none")
    return Row(name, value, math.nan, unit, expected.value, note=expected.kind)


def _quantity_text(row: Row) -> str:
    text = f"{row.value:.10g} {'' if row.unit == '1' else row.unit}".rstrip()
    if row.note == "none":
        return text
    return f"{text}; {row.expected:.10g} by {row.note}, {row.difference:+.2g} off"
