"""What the quantity of a sweep's figure is expected to be: lines over the first parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from harness.cases.contract import Case, Reference
from harness.engines.registry import engine_class
from harness.engines.traits import Traits
from harness.errors import HarnessError
from harness.parameters.base import Parameters
from harness.report.sweep_figures import DENSE, ReferenceLine, is_logarithmic
from harness.workflows.case_runs import NO_RULES, parameters_of
from harness.workflows.sweep_plan import (
    SweepPlan,
    SweepPoint,
    engine_title,
    parameter_columns,
    quantity_key,
)


def reference_lines(
    chosen: SweepPlan, column: str, over: Sequence[str]
) -> tuple[ReferenceLine, ...]:
    """Return the lines of the quantity in a column, over the first of the columns ``over``.

    One for each value of the second and each engine where they differ, between the points too
    where a reference costs little; none where a case knows no reference.
    """
    name = next(q.name for q in chosen.case.quantities if quantity_key(q) == column)
    rest = list(chosen.request.over)[2:]
    first = chosen.points[0].swept
    drawn = [p for p in chosen.points if all(p.swept[other] == first[other] for other in rest)]
    engines: dict[ReferenceLine, list[str]] = {}
    for engine in chosen.engines:
        rules = NO_RULES if chosen.solves(engine) else engine_class(engine).traits
        for second, points in _by_second(drawn, over):
            line = _line(chosen, name, over[0], points, rules)
            if line is not None:
                engines.setdefault(replace(line, second=second), []).append(engine_title(engine))
    lines = [
        replace(line, engines=() if len(those) == len(chosen.engines) else tuple(those))
        for line, those in engines.items()
    ]
    # lines that are the same for every value of the second parameter are one
    seconds = len(_by_second(drawn, over))
    groups: dict[ReferenceLine, list[ReferenceLine]] = {}
    for line in lines:
        groups.setdefault(replace(line, second=None), []).append(line)
    return tuple(
        line
        for merged, some in groups.items()
        for line in ([merged] if len(some) == seconds else some)
    )


def _by_second(
    points: Sequence[SweepPoint], over: Sequence[str]
) -> list[tuple[Any, list[SweepPoint]]]:
    """Return each value of the second parameter, None without one, and its points."""
    groups: dict[Any, list[SweepPoint]] = {}
    for point in points:
        second = None if len(over) < 2 else _value(point, over[1])
        groups.setdefault(second, []).append(point)
    return list(groups.items())


def _value(point: SweepPoint, column: str) -> Any:
    return parameter_columns(point.parameters).get(column, point.swept.get(column))


def _line(
    chosen: SweepPlan, name: str, across: str, points: Sequence[SweepPoint], rules: Traits
) -> ReferenceLine | None:
    x: list[Any] = [_value(point, across) for point in points]
    references = _references(chosen.case, name, [p.parameters for p in points], rules)
    present = [reference for reference in references if reference is not None]
    if not present:
        return None
    kind = (
        "integrated"
        if any(reference.kind == "integrated" for reference in present)
        else "closed form"
    )
    cheap = all(ref.kind == "closed form" or ref.quick for ref in present)
    numbers = all(isinstance(at, (int, float)) and not isinstance(at, bool) for at in x)
    if cheap and numbers and len(set(x)) > 1:
        between = np.geomspace if is_logarithmic(x) else np.linspace
        many = [float(f"{at:.12g}") for at in between(min(x), max(x), DENSE)]
        with suppress(HarnessError):  # whole numbers, or values that a case refuses
            x, references = many, _dense(chosen, name, points[0], many, rules)
    there = [place for place, ref in enumerate(references) if ref is not None]
    # to 12 digits: round-off makes no other line
    y = tuple(float(f"{ref.value:.12g}") for ref in references if ref is not None)
    return ReferenceLine(kind, tuple(x[place] for place in there), y)


def _dense(
    chosen: SweepPlan, name: str, point: SweepPoint, x: Sequence[float], rules: Traits
) -> list[Reference | None]:
    swept: Mapping[str, str] = point.swept
    first = next(iter(chosen.request.over))
    settings = {**chosen.request.fixed, **swept}
    parameters = [parameters_of(chosen.case, {**settings, first: repr(at)}) for at in x]
    return _references(chosen.case, name, parameters, rules)


def _references(
    case: Case[Any], name: str, parameters: Sequence[Parameters], rules: Traits
) -> list[Reference | None]:
    """Return what is expected at each; None where that is not known."""
    references: list[Reference | None] = []
    for values in parameters:
        try:
            references.append(case.references(values, rules).get(name))
        except HarnessError:
            references.append(None)
    return references
