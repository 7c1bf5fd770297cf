"""The guards between the harness and an engine, which may belong to another package.

Its methods may return or raise anything. A guard makes that an EngineError of one line, which
names engine, package, call and what was expected; other jobs go on.
"""

from __future__ import annotations

import errno
import functools
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.engines.output import SERIES, Output
from harness.engines.provenance import Provenance
from harness.errors import FULL, EngineError, EngineNaNError, EngineOutputError, HarnessError

if TYPE_CHECKING:
    from harness.engines.base import Engine, Job

Outcomes = list[Output | EngineError]
Run = Callable[["Engine", Sequence["Job"]], Outcomes]
EXPECTED: dict[str, str] = {  # results of methods
    "identify": "a Provenance",
    "refuses": "a text, empty where it refuses nothing",
    "fingerprint": "a dictionary that is ready for JSON, or None",
    "rules": "the Rules of a scene, or raise Unsupported with the reason",
    "motions": "a list with a Motion or an EngineError for each job",
}


class _RaisedError(EngineError):
    """Another exception than the contract has."""


class _WrongResultError(EngineOutputError):
    """A result of another type than the contract has."""


def engine_label(engine: Engine | type[Engine]) -> str:
    """Return an engine's name for a message, with its package where that is not the harness."""
    kind = engine if isinstance(engine, type) else type(engine)
    package = f" of package {kind.__module__.partition('.')[0]!r}" if _is_foreign(kind) else ""
    return f"engine {getattr(engine, 'name', kind.__name__)!r}{package}"


def checked_run(run: Run) -> Run:
    """Return ``run`` with guards: number of outcomes, shapes, finite numbers, exceptions."""

    @functools.wraps(run)
    def checked(self: Engine, jobs: Sequence[Job]) -> Outcomes:
        try:
            outcomes: Any = run(self, jobs)
        except Exception as error:
            if isinstance(error, _RaisedError | _WrongResultError):
                return [error for _ in jobs]
            full = isinstance(error, OSError) and error.errno in (*FULL, errno.EMFILE)
            known = isinstance(error, (HarnessError, MemoryError)) or full
            if known or not _is_foreign(type(self)):
                raise
            return [_raised(self, "run", error) for _ in jobs]
        are_outcomes = isinstance(outcomes, (list, tuple))
        if not are_outcomes or len(outcomes) != len(jobs):
            found = f"{len(outcomes)} outcomes" if are_outcomes else f"a {type(outcomes).__name__}"
            expected = f"a list with an Output or an EngineError for each of {len(jobs)} jobs"
            return [_error(self, "run", found, expected) for _ in jobs]
        return [_checked(self, outcome) for outcome in outcomes]

    return checked


def checked_call(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method of an engine whose result is checked; it raises EngineError otherwise."""

    @functools.wraps(call)
    def checked(self: Engine, *arguments: Any) -> Any:
        if not _is_foreign(type(self)):
            return call(self, *arguments)
        try:
            value: Any = call(self, *arguments)
        except HarnessError:
            raise
        except Exception as error:
            raise _raised(self, name, error) from error
        if found := _wrong(name, value, arguments):
            raise _error(self, name, found, EXPECTED[name])
        return value

    return checked


def _wrong(name: str, value: Any, arguments: Sequence[Any]) -> str:
    """Return what a method returned in place of what is expected, empty where that is right."""
    from harness.model.conventions import Rules

    kinds: dict[str, tuple[type, ...]] = {
        "identify": (Provenance,), "refuses": (str,), "fingerprint": (Mapping, type(None)),
        "rules": (Rules,), "motions": (list, tuple),
    }  # fmt: skip
    if not isinstance(value, kinds[name]):
        return f"a {type(value).__name__}"
    return _wrong_motions(value, *arguments) if name == "motions" else ""


def _wrong_motions(motions: Any, jobs: Sequence[Job]) -> str:
    from harness.model.motion import Motion

    others = [one for one in motions if not isinstance(one, Motion | EngineError)]
    if others:
        return f"a list with a {type(others[0]).__name__}"
    return "" if len(motions) == len(jobs) else f"{len(motions)} motions of {len(jobs)} jobs"


def _is_foreign(kind: type[Engine]) -> bool:
    return kind.__module__.partition(".")[0] != "harness"


def _error(engine: Engine, call: str, found: str, expected: str) -> EngineOutputError:
    label = engine_label(engine)
    return _WrongResultError(f"{label}: {call} returned {found}, must return {expected}")


def _raised(engine: Engine, call: str, error: Exception) -> EngineError:
    """Return the error of a call that raised what no engine should, with its place in the code."""
    frames = traceback.extract_tb(error.__traceback__)
    file = getattr(sys.modules.get(type(engine).__module__), "__file__", "")
    place = [*frames, *(f for f in frames if f.filename == file)][-1]
    text = " ".join(f"{type(error).__name__}: {error}".split()).strip(": ")[:160]
    found = f"{call} raised {text} ({Path(place.filename).name}, line {place.lineno})"
    expected = "must raise an EngineError, or return one for the job"
    log = "".join(traceback.format_exception(error))
    return _RaisedError(f"{engine_label(engine)}: {found}, {expected}").with_log(log)


def _checked(engine: Engine, outcome: Any) -> Output | EngineError:
    """Return an outcome, or an error in its place."""
    if isinstance(outcome, EngineError):
        return outcome
    if flaw := next(_flaws(outcome), None):
        return _error(engine, "run", *flaw)
    output: Output = outcome
    if _is_foreign(type(engine)) and (column := _infinite_column(output)):
        found = f"a series with values that are not numbers in {column!r}, must return finite ones"
        return EngineNaNError(f"{engine_label(engine)}: run returned {found}")

    return output


def _flaws(outcome: Any) -> Iterator[tuple[str, str]]:
    """Yield each flaw in the types and shapes of an outcome, with what was expected."""
    import numpy as np

    if not isinstance(outcome, Output):
        yield f"a {type(outcome).__name__} for a job", "an Output or an EngineError"
        return
    if not isinstance(outcome.provenance, Provenance):
        yield f"an Output of {type(outcome.provenance).__name__}", "a Provenance in it"
    for name, table in outcome.tables.items():
        if not isinstance(table, Mapping):
            yield f"table {name!r} as a {type(table).__name__}", "columns by name"
            continue
        for column, values in table.items():
            is_array = isinstance(values, np.ndarray)
            if not is_array or values.dtype.kind not in "fiub" or values.ndim not in (1, 2):
                kind = f"{values.dtype} array" if is_array else type(values).__name__
                found = f"column {column!r} of table {name!r} as a {kind}"
                yield found, "an array of numbers, (M,) or (M, N)"
        lengths = {column: len(values) for column, values in table.items()}
        if len({*lengths.values()}) > 1:
            yield f"table {name!r} with columns of several lengths ({lengths})", "one for all"


def _infinite_column(output: Output) -> str:
    """Return the name of a sampled column with a NaN, "" without one; forces may be unknown."""
    import numpy as np

    for name, values in output.tables.get(SERIES, {}).items():
        if not name.endswith(("_N", "_N_m")) and not np.isfinite(values).all():
            return name
    return ""
