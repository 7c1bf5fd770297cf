"""Run any case once: parameters in, quantities with their references out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from harness import __version__
from harness.cases.contract import Case, Measured, Reference, ReferenceKind
from harness.cases.registry import get_case
from harness.comparison.published import Number, published
from harness.engines.contract import Engine
from harness.engines.cost import refuse_endless
from harness.engines.registry import DEFAULT, engine_names, open_engine
from harness.engines.traits import Traits
from harness.errors import RequestError
from harness.parameters.base import Parameters
from harness.shown import Shown
from harness.workflows.case_settings import parameters_of
from harness.workflows.progress import Progress, silent
from harness.workflows.verification_run import Open

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure

NO_RULES = Traits(install_hint="", versions=(), integrator="")
"""Of a solver, which follows the parameters as they are."""


@dataclass(frozen=True)
class RunQuantity:
    """A quantity of a run beside what it is expected to be; NaN where nothing is known."""

    value: Number
    unit: str
    reference: Number = math.nan
    reference_kind: ReferenceKind = "none"
    difference: Number = math.nan


@dataclass(frozen=True, repr=False)
class RunResult(Shown):
    """One run of a case: who ran it, with which parameters, and what was measured."""

    case: str
    engine: str
    engine_version: str
    parameters: Mapping[str, Any]
    quantities: Mapping[str, RunQuantity]

    def record(self) -> dict[str, Any]:
        """Return it as a JSON-ready mapping."""
        return published(self)

    def frame(self) -> pd.DataFrame:
        """Return the quantities as a table, one row each."""
        import pandas as pd

        rows = [{"quantity": name, **vars(one)} for name, one in self.quantities.items()]
        return pd.DataFrame(rows, columns=["quantity", *RunQuantity.__dataclass_fields__])

    def told(self) -> dict[str, str]:
        """Return the quantities beside their references, and who ran the case."""
        found = {name: _told(one) for name, one in self.quantities.items()}
        return {**found, "case": self.case, "engine": f"{self.engine} {self.engine_version}"}

    def drawn(self) -> Figure:
        """Draw how far each quantity is off its reference; those without one are named so."""
        from harness.shown.figure import Figure, label

        figure = Figure(figsize=(7.0, 1.3 + 0.4 * len(self.quantities)), layout="constrained")
        axes = figure.add_subplot()
        for place, one in enumerate(self.quantities.values()):
            off = one.difference / (abs(one.reference) or 1.0)
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
    engine: str | Engine | None = None,
    *,
    open_one: Open = open_engine,
    progress: Progress = silent,
    most_seconds: float = math.inf,
) -> RunResult:
    """Run a case once and return its quantities beside their references.

    ``settings`` are texts by the names of parameters, in SI units and degrees as :func:`cases`
    lists them (k in [N/m]), of nested ones with a dot, and ``preset`` for a known set; each
    quantity names its unit. ``engine`` is an open engine, or the name of an engine or of a solver
    of the case; the default engine unless given. ``open_one`` opens one by its name. Raise
    RequestError for a name or value that is not allowed, for an engine that cannot run the
    case, with the reason, and for a run that is expected to take more than ``most_seconds``;
    EngineError for a run that failed.
    """
    chosen = get_case(case)
    parameters = parameters_of(chosen, settings or {})

    def begin(rules: Traits | None, solver: str = "") -> None:
        refuse_endless(
            chosen.seconds(parameters, rules, solver), f"case {case!r} with these values",
            most_seconds,
        )  # fmt: skip
        progress(case, 0, 1)

    if isinstance(engine, Engine):
        begin(engine.traits)
        return _in_engine(chosen, parameters, engine)
    name = engine or usual_engine(chosen)
    if name in chosen.solvers and (engine is None or name not in engine_names()):
        begin(None, name)
        measured = chosen.solve(parameters, name)
        who = (name, f"dem-harness {__version__}")
        return _result(chosen, parameters, who, measured, NO_RULES)
    if name not in engine_names() and ":" not in name:
        known = ", ".join([*engine_names(), *chosen.solvers])
        raise RequestError(f"--engine {name!r} is not known: must be one of {known}")
    with open_one(name) as opened:
        begin(opened.traits)
        return _in_engine(chosen, parameters, opened)


def usual_engine(case: Case[Any]) -> str:
    """Return the default engine, or the first solver of a case that it cannot state."""
    from harness.engines.registry import engine_class

    if case.solvers and not engine_class(DEFAULT).states(case.template):
        return case.solvers[0]
    return DEFAULT


def _in_engine(case: Case[Any], parameters: Parameters, engine: Engine) -> RunResult:
    reason = engine.refuses(case.job(parameters))
    if reason:
        raise RequestError(f"--engine {engine.name!r}: cannot run {case.name!r}: {reason}")
    measured = case.measure(parameters, engine)
    who = measured.provenance or engine.identify()
    named = (engine.name, who.engine_version)
    return _result(case, parameters, named, measured, engine.traits)


def _result(
    case: Case[Any],
    parameters: Parameters,
    who: tuple[str, str],
    measured: Measured,
    traits: Traits,
) -> RunResult:
    references = case.references(parameters, traits)
    units = {quantity.name: quantity.unit for quantity in case.quantities}
    return RunResult(
        case=case.name,
        engine=who[0],
        engine_version=who[1],
        parameters=parameters.model_dump(mode="json"),
        quantities={
            name: _quantity(measured.values[name], unit, references.get(name))
            for name, unit in units.items()
            if name in measured.values
        },
    )


def _quantity(value: float, unit: str, reference: Reference | None) -> RunQuantity:
    if reference is None:
        return RunQuantity(value, unit)
    return RunQuantity(value, unit, reference.value, reference.kind, value - reference.value)


def _told(one: RunQuantity) -> str:
    """Return a value with its unit, and what is expected."""
    said = f"{one.value:.10g} {'' if one.unit == '1' else one.unit}".rstrip()
    if one.reference_kind == "none":
        return said
    return f"{said}; {one.reference:.10g} by {one.reference_kind}, {one.difference:+.2g} off"
