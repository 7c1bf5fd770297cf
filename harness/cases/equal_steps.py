"""Checks of a case at equal steps: each quantity of a run against the reference's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TypeVar

from harness.cases.base import Case, Check, Value
from harness.cases.bench import Bench
from harness.engines.base import Engine
from harness.model.base import Parameters
from harness.results.rows import Level, Tolerance

P = TypeVar("P", bound=Parameters)

ROUND_OFF = 1e-9  # of the scale of a quantity
REASON = "both take the same steps: what differs is round-off, or a fault"


def equal_steps_checks(
    case: Case[P], engine: Engine, setups: Mapping[str, P], level: Level = "quick"
) -> Iterator[Check]:
    """Yield a check of each quantity of one run in each setup, by the name of the setup.

    The tolerance is a part of the quantity's scale, and the last digit of the engine's output. The
    note has the error of the step where a closed form exists.
    """
    digits = 10.0 ** (1 - engine.traits.digits)
    for setup, parameters in setups.items():
        for quantity in case.quantities:
            if quantity.varies:  # a search of several runs
                continue
            width = (ROUND_OFF + digits) * quantity.size(parameters)
            yield Check(
                setup=setup,
                quantity=quantity.name,
                unit=quantity.unit,
                measure=partial(_measured, case, parameters, quantity.name),
                expected=partial(_expected, case, parameters, quantity.name),
                tolerance=Tolerance(absolute=width, reason=REASON),
                level=level,
                jobs=(case.job(parameters),),
            )


def _measured(case: Case[P], parameters: P, name: str, bench: Bench) -> Value:
    value = case.measure(parameters, bench.output(case.job(parameters)))[name]
    exact = case.exact(parameters)
    if name not in exact:
        return Value(value)
    error = _expected(case, parameters, name, bench) - exact[name]
    return Value(value, note=f"error of the step {error:.2g} (closed form {exact[name]:.9g})")


def _expected(case: Case[P], parameters: P, name: str, bench: Bench) -> float:
    return case.reference(parameters, bench)[name]
