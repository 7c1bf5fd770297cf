"""Run checks: exactly one row of each, whatever happens.

A job that the engine refuses, or a run that ends undecided: not tested, with the reason. An
engine's error: a failed row with its log. Any other error: a harness error. Failures that are known
defects of the release are marked where they are judged.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeVar

from harness.cases.base import LEVELS, Case, CaseError, Check, Level, Value
from harness.cases.bench import Bench
from harness.engines.base import Engine
from harness.engines.process import cores, parallel_map
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineTimeoutError,
    EngineUndecidedError,
    Unsupported,
)
from harness.model.base import Parameters
from harness.results.rows import (
    NAN,
    Failure,
    Kind,
    Row,
    Tolerance,
    failed,
    finding,
    judge,
    matches,
    not_tested,
    recorded,
)

P = TypeVar("P", bound=Parameters)
ROUND_OFF = 1e-9  # of the scale of a quantity
REASON = "both take the same steps: what differs is round-off, or a fault"
Explain = Callable[[Bench, Sequence[Check], Sequence[Row]], list[Row]]  # marks known defects
FAILURES: tuple[tuple[type[EngineError], Failure], ...] = (
    (EngineTimeoutError, Failure.TIMEOUT),
    (EngineMemoryError, Failure.MEMORY),
    (EngineNaNError, Failure.NOT_A_NUMBER),
    (EngineLostAtomsError, Failure.ENGINE),  # a kind of refused input
    (EngineInputError, Failure.WRONG_INPUT),
    (EngineError, Failure.ENGINE),
)


def selected(case: str, checks: Iterable[Check], level: Level, only: str = "*") -> list[Check]:
    """Return the checks of a level whose ``case/setup/quantity`` matches a pattern."""
    return [
        check
        for check in checks
        if runs_at(check.level, level) and matches(f"{case}/{check.setup}/{check.quantity}", only)
    ]


def runs_at(shortest: Level | None, level: Level) -> bool:
    """Return whether a level runs what a shorter one does, nothing for None."""
    return shortest is not None and LEVELS.index(shortest) <= LEVELS.index(level)


def run_checks(
    case: str,
    checks: Sequence[Check],
    bench: Bench,
    *,
    version: str = "",
    explain: Explain | None = None,
) -> list[Row]:
    """Return the row of each check, in order. Raise ValueError for two checks of one key."""
    keys = Counter((check.setup, check.quantity, check.check) for check in checks)
    for key, count in keys.items():
        if count > 1:
            raise ValueError(f"case {case!r}: two checks {' / '.join(key)}")
    refusals = [next(filter(None, map(bench.refusal, check.jobs)), "") for check in checks]
    pairs = zip(checks, refusals, strict=True)
    if jobs := [job for check, refusal in pairs if not refusal for job in check.jobs]:
        bench.prepare(jobs)

    def row_of(place: int) -> Row:
        check = checks[place]
        blank = Row(
            case=case,
            setup=check.setup,
            quantity=check.quantity,
            engine=bench.name,
            check=check.check,
            version=version,
            unit=check.unit,
            kind=check.kind,
            level=check.level,
            inputs=bench.inputs_digest(check.jobs),
        )
        if refusals[place]:
            return not_tested(blank, refusals[place])
        return row_in(bench, check, blank)

    rows = parallel_map(row_of, range(len(checks)), cores())
    rows = rows if explain is None else explain(bench, checks, rows)
    bench.rows[case] += rows
    return rows


def row_in(bench: Bench, check: Check, blank: Row) -> Row:
    """Return the row of a check: measured, expected and judged."""
    try:
        value = Value.of(check.measure(bench))
        expected = check.expected(bench) if callable(check.expected) else check.expected
        tolerance = check.tolerance(bench) if callable(check.tolerance) else check.tolerance
    except (Unsupported, EngineMissingError, EngineUndecidedError) as error:
        return not_tested(blank, str(error))
    except EngineError as error:
        return failed_run(blank, error)
    except CaseError as error:
        return failed(blank, Failure.HARNESS, str(error))
    except Exception as error:  # a case of a plug-in may raise anything
        return failed(blank, Failure.HARNESS, f"{type(error).__name__}: {error}")
    note = "; ".join(filter(None, (check.note, value.note)))
    row = replace(
        blank, value=value.value, uncertainty=value.uncertainty, expected=expected, note=note
    )
    if check.kind is Kind.FINDING and math.isnan(row.value):
        return failed(row, Failure.NOT_A_NUMBER, note)
    if check.kind is Kind.FINDING:
        limit = tolerance.width(row.value) or NAN
        return finding(replace(row, tolerance=limit, reason=tolerance.reason))
    if check.kind is Kind.RECORDED:
        return recorded(row, tolerance)
    return judge(row, tolerance, failure=value.failure)


def failed_run(blank: Row, error: EngineError, text: str = "") -> Row:
    """Return the row of a run that failed: class of the error, its log and its text, or another."""
    failure = next(failure for kind, failure in FAILURES if isinstance(error, kind))
    return failed(blank, failure, f"{error.kind}: {text or error}", error.log)


# ---- checks at equal steps: each quantity of a run against the reference's


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
    expected = partial(_expected, case, parameters, name, bench)
    return with_step_error(value, case.exact(parameters).get(name), expected)


def with_step_error(value: float, exact: float | None, expected: Callable[[], float]) -> Value:
    """Return a value at equal steps; its note has the reference's distance from a closed form."""
    if exact is None:
        return Value(value)
    error = expected() - exact
    return Value(value, note=f"error of the step {error:.2g} (closed form {exact:.9g})")


def _expected(case: Case[P], parameters: P, name: str, bench: Bench) -> float:
    return case.reference(parameters, bench)[name]
