"""Run checks: exactly one row of each, whatever happens.

A job that the engine refuses, or a run that ends undecided: not tested, with the reason. An
engine's error: a failed row with its log. Any other error: a harness error. Failures that are known
defects of the release are marked where they are judged.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from harness.cases.base import LEVELS, Check, Level, Value
from harness.cases.bench import Bench
from harness.cases.calls import CaseError
from harness.engines.base import Engine, Job
from harness.engines.jobs import cores, parallel_map
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
from harness.results.rows import (
    NAN,
    Failure,
    Kind,
    Row,
    failed,
    finding,
    judge,
    matches,
    not_tested,
    recorded,
)

Explain = Callable[[Bench, Sequence[Check], Sequence[Row]], list[Row]]
"""Marks the rows that are known defects of the release; see :mod:`harness.cases.defects`."""


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
    _check_keys(case, checks)
    refused = [_refusal(bench, check) for check in checks]
    runs = [check for check, reason in zip(checks, refused, strict=True) if not reason]
    blank = [_blank(case, check, bench, version) for check in checks]
    if jobs := [job for check in runs for job in check.jobs]:
        bench.prepare(jobs)

    def row_of(place: int) -> Row:
        if refused[place]:
            return not_tested(blank[place], refused[place])
        return row_in(bench, checks[place], blank[place])

    rows = parallel_map(row_of, range(len(checks)), cores())
    return rows if explain is None else explain(bench, checks, rows)


def row_in(bench: Bench, check: Check, blank: Row) -> Row:
    """Return the row of a check: measured, expected and judged."""
    try:
        measured = check.measure(bench)
        found = measured if isinstance(measured, Value) else Value(float(measured))
        expected = check.expected(bench) if callable(check.expected) else check.expected
        width = check.tolerance(bench) if callable(check.tolerance) else check.tolerance
    except (Unsupported, EngineMissingError, EngineUndecidedError) as error:
        return not_tested(blank, str(error))
    except EngineError as error:
        return failed(blank, failure_of(error), f"{error.kind}: {error}", error.log)
    except CaseError as error:
        return failed(blank, Failure.HARNESS, str(error))
    except Exception as error:  # a case of a plug-in may raise anything
        return failed(blank, Failure.HARNESS, f"{type(error).__name__}: {error}")
    note = "; ".join(filter(None, (check.note, found.note)))
    row = replace(
        blank, value=found.value, uncertainty=found.uncertainty, expected=expected, note=note
    )
    if check.kind is Kind.FINDING:
        limit = width.width(row.value) or NAN
        return finding(replace(row, tolerance=limit, reason=width.reason))
    if check.kind is Kind.RECORDED:
        return recorded(row, width)
    return judge(row, width, failure=found.failure)


def failure_of(error: EngineError) -> Failure:
    """Return the class of an engine's error."""
    classes: tuple[tuple[type[EngineError], Failure], ...] = (
        (EngineTimeoutError, Failure.TIMEOUT),
        (EngineMemoryError, Failure.MEMORY),
        (EngineNaNError, Failure.NOT_A_NUMBER),
        (EngineLostAtomsError, Failure.ENGINE),
        (EngineInputError, Failure.WRONG_INPUT),
    )
    return next((found for kind, found in classes if isinstance(error, kind)), Failure.ENGINE)


def inputs_digest(engine: Engine, jobs: Sequence[Job]) -> str:
    """Return a digest of what jobs give an engine; empty without jobs."""
    if not jobs:
        return ""
    content = [
        [
            job.template.name,
            job.variant,
            dict(sorted(job.values.items())),
            None if job.scene is None else job.scene.model_dump(mode="json"),
            engine.script_digest(job),
        ]
        for job in jobs
    ]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]


def _check_keys(case: str, checks: Sequence[Check]) -> None:
    seen = set()
    for check in checks:
        key = (check.setup, check.quantity, check.check)
        if key in seen:
            raise ValueError(f"case {case!r}: two checks {' / '.join(key)}")
        seen.add(key)


def _refusal(bench: Bench, check: Check) -> str:
    return next(filter(None, (bench.refusal(job) for job in check.jobs)), "")


def _blank(case: str, check: Check, bench: Bench, version: str) -> Row:
    return Row(
        case=case,
        setup=check.setup,
        quantity=check.quantity,
        engine=bench.name,
        check=check.check,
        version=version,
        unit=check.unit,
        kind=check.kind,
        level=check.level,
        inputs=inputs_digest(bench.engine, check.jobs) if check.jobs else "",
    )
