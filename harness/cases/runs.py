"""Run the jobs of a case in an engine, and read what comes back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from importlib import resources
from typing import TypeVar

from harness.engines.contract import Engine, Job, Output
from harness.errors import EngineError

P = TypeVar("P")
Run = TypeVar("Run")


def run_jobs(
    engine: Engine,
    cases: Sequence[P],
    job_of: Callable[[P], Job],
    read: Callable[[P, Output], Run],
) -> list[Run | EngineError]:
    """Run cases, in parallel where that helps, and return their results in order; errors in place.

    Raise RequestError for a case that the engine cannot state.
    """
    results: list[Run | EngineError] = []
    outputs = engine.run([job_of(case) for case in cases])
    for case, output in zip(cases, outputs, strict=True):
        try:
            if isinstance(output, EngineError):
                raise output
            results.append(read(case, output))
        except EngineError as error:
            if isinstance(output, Output):
                error.log = output.log
            results.append(error)
    return results


def complete(results: Iterable[Run | EngineError]) -> list[Run]:
    """Return results; raise the first error among them, for callers that need them all."""
    return [whole(result) for result in results]


def whole(result: Run | EngineError) -> Run:
    """Return a result; raise it where it is an error."""
    if isinstance(result, EngineError):
        raise result
    return result


def recorded_text(engine: str, name: str) -> str:
    """Return a table of the folder ``recorded`` of an engine, which says where it comes from."""
    folder = resources.files(f"harness.engines.{engine}").joinpath("recorded")
    return folder.joinpath(name).read_text(encoding="utf-8")
