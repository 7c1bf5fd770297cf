"""Run any case once: parameters in, quantities with their references out."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from harness import __version__
from harness.cases.contract import Case, Measured, Reference, ReferenceKind
from harness.cases.registry import get_case
from harness.comparison.published import Number, published
from harness.engines.contract import Engine
from harness.engines.registry import DEFAULT, engine_names, open_engine
from harness.engines.traits import Traits
from harness.errors import RequestError
from harness.parameters.base import Parameters
from harness.workflows.case_settings import parameters_of
from harness.workflows.verification_run import Open

if TYPE_CHECKING:
    import pandas as pd

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


@dataclass(frozen=True)
class RunResult:
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

    def _repr_html_(self) -> str:
        """Return a short table for a notebook: values beside what is expected."""
        rows = "".join(
            f"<tr><td>{html.escape(name)}</td><td>{one.value:.10g} {html.escape(one.unit)}</td>"
            f"<td>{_expected(one)}</td></tr>"
            for name, one in self.quantities.items()
        )
        who = html.escape(f"{self.case}, {self.engine} {self.engine_version}")
        return (
            f"<table><caption>{who}</caption><thead><tr><th>quantity</th><th>value</th>"
            f"<th>reference</th></tr></thead><tbody>{rows}</tbody></table>"
        )


def run(
    case: str,
    settings: Mapping[str, str] | None = None,
    engine: str | Engine | None = None,
    *,
    open_one: Open = open_engine,
) -> RunResult:
    """Run a case once and return its quantities beside their references.

    ``settings`` are texts by the names of parameters, of nested ones with a dot, and ``preset``
    for a known set. ``engine`` is an open engine, or the name of an engine or of a solver
    of the case; the default engine unless given. ``open_one`` opens one by its name. Raise
    RequestError for a name or value that is not allowed, and for an engine that cannot run the
    case, with the reason; EngineError for a run that failed.
    """
    chosen = get_case(case)
    parameters = parameters_of(chosen, settings or {})
    if isinstance(engine, Engine):
        return _in_engine(chosen, parameters, engine)
    name = engine or usual_engine(chosen)
    if name in chosen.solvers and (engine is None or name not in engine_names()):
        measured = chosen.solve(parameters, name)
        who = (name, f"dem-harness {__version__}")
        return _result(chosen, parameters, who, measured, NO_RULES)
    if name not in engine_names() and ":" not in name:
        known = ", ".join([*engine_names(), *chosen.solvers])
        raise RequestError(f"--engine {name!r} is not known: must be one of {known}")
    with open_one(name) as opened:
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


def _expected(one: RunQuantity) -> str:
    if one.reference_kind == "none":
        return ""
    return f"{one.reference:.10g} ({one.reference_kind}; {one.difference:+.2g})"
