"""The cases: what each is given, what it measures in which unit, and which engines run it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic_core import PydanticUndefined

from harness.cases.contract import Case
from harness.cases.registry import all_cases
from harness.comparison.published import published
from harness.engines.registry import engine_class, engine_names
from harness.errors import RequestError
from harness.parameters.allowed import unit_in
from harness.parameters.base import Parameters
from harness.shown import Listing


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter: its default (None where it must be given), unit and meaning."""

    default: Any
    unit: str
    description: str


@dataclass(frozen=True)
class CaseInfo:
    """A case as it is listed.

    ``parameters`` are named as ``--set`` takes them, those of nested objects with a dot;
    ``quantities`` map a name to its unit; ``engines`` have a template for the case, or take its
    scene; ``solvers`` are those of this package; ``presets`` known sets of parameters.
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

    def record(self) -> dict[str, Any]:
        """Return it as a JSON-ready mapping."""
        return published(self)


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
        by_default=case.by_default,
    )


def _states(engine: str, case: Case[Any]) -> bool:
    """Return whether an engine can run a case; one that cannot be imported can not."""
    try:
        return engine_class(engine).states(case.template)
    except RequestError:
        return False


def default_of(case: Case[Any]) -> Parameters | None:
    """Return the parameters of a run that sets none, or None where some must be set."""
    try:
        found: Parameters = case.default
        return found
    except RequestError:
        return None


def parameters_in(values: Parameters) -> list[tuple[str, ParameterInfo]]:
    """Return the names, of nested ones with a dot, and what is known of each; values as default."""
    return list(_parameters(type(values), values, ""))


def _parameters(
    kind: type[Parameters], values: Parameters | None, prefix: str
) -> Iterator[tuple[str, ParameterInfo]]:
    """Yield the fields of a class of parameters, and of those nested in it."""
    for name, declared in kind.model_fields.items():
        value = getattr(values, name) if values is not None else declared.default
        if isinstance(value, Parameters):
            yield from _parameters(type(value), value, f"{prefix}{name}.")
            continue
        text = declared.description or ""
        meaning = text.partition("]")[2].strip() if text.startswith("[") else text
        default = None if value is PydanticUndefined else value
        yield prefix + name, ParameterInfo(default, unit_in(text), meaning)
