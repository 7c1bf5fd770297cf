"""Columns of the table of a sweep: names with their units, and which of them its figure shows."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from harness.engines.registry import engine_class, engine_names
from harness.observables.provenance import Observable
from harness.parameters.base import Parameters
from harness.workflows.case_runs import PRESET, parameters_in
from harness.workflows.sweep_plan import SweepPlan, SweepPoint, names_in


def parameter_columns(parameters: Parameters, without: Sequence[str] = ()) -> dict[str, Any]:
    """Return every parameter under its name with its unit; lists of numbers as JSON text.

    Those of the names ``without`` are left out.
    """
    columns: dict[str, Any] = {}
    for name, info in parameters_in(parameters):
        if name in without:
            continue
        value = info.default
        plain = isinstance(value, (bool, int, float, str)) or value is None
        columns[column_of(name, info.unit)] = value if plain else json.dumps(value)
    return columns


def swept_columns(point: SweepPoint, names: Mapping[str, str]) -> tuple[str, ...]:
    """Return the columns of swept parameters; a nested one that is swept whole by its name."""
    units = {name: info.unit for name, info in parameters_in(point.parameters)}
    columns: list[str] = []
    for name in names:
        if name in units or name == PRESET:
            columns.append(column_of(name, units.get(name, "")))
        else:  # an object by its name
            columns += [column_of(n, u) for n, u in units.items() if n == f"{name}.name"] or [name]
    return tuple(columns)


def engine_title(name: str) -> str:
    """Return what figures call an engine; a solver has its name."""
    if name not in engine_names() and ":" not in name:
        return name
    return engine_class(name).traits.title or name.upper()


def drawn_columns(chosen: SweepPlan) -> tuple[str, str, str]:
    """Return the columns of a sweep's figure: the first that is swept, and what is asked for.

    The third is that of the uncertainty of what is asked for.
    """
    over = swept_columns(chosen.points[0], chosen.request.over)
    units = {quantity.name: quantity.unit for quantity in chosen.case.quantities}
    name = names_in(chosen.request.quantity)[0]
    unit = units[name]
    return over[0], column_of(name, unit), column_of("uncertainty", unit)


def quantity_key(quantity: Observable) -> str:
    """Return the column of a quantity, its name with its unit."""
    return column_of(quantity.name, quantity.unit)


def column_of(name: str, unit: str) -> str:
    """Return a name with its unit, as ``stiffness_N_per_m``; one that ends in it stays."""
    spelled = unit.replace("/", "_per_").replace(" ", "").replace("^", "")
    if spelled in ("", "1", "-") or name.endswith(f"_{spelled}"):
        return name
    return f"{name}_{spelled}"
