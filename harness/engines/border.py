"""The guard between the harness and an engine, which may belong to another package.

Its methods may return or raise anything. The guard makes that an EngineError of one line, which
names engine, package, call and what was expected; other jobs go on.
"""

from __future__ import annotations

import errno
import functools
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.engines.output import SERIES, Output
from harness.engines.provenance import Provenance
from harness.errors import FULL, EngineError, EngineNaNError, EngineOutputError, HarnessError

if TYPE_CHECKING:
    from harness.engines.base import Engine

CONTRACT = {  # results of methods
    "identify": "a Provenance",
    "refuses": "a text, empty where it refuses nothing",
    "fingerprint": "a dictionary that is ready for JSON, or None",
    "rules": "the Rules of a scene, or raise Unsupported with the reason",
    "motions": "a list with a Motion or an EngineError for each job",
    "run": "a list with an Output or an EngineError for each job",
}


class ContractError(EngineOutputError):
    """A call of an engine that returned or raised what its contract does not have."""


def engine_label(engine: Engine | type[Engine]) -> str:
    """Return an engine's name for a message, with its package where that is not the harness."""
    kind = engine if isinstance(engine, type) else type(engine)
    package = f" of package {kind.__module__.partition('.')[0]!r}" if _is_foreign(kind) else ""
    return f"engine {getattr(engine, 'name', kind.__name__)!r}{package}"


def guard_calls(kind: type[Any]) -> None:
    """Guard the calls in :data:`CONTRACT` that an engine's class defines; here ``run`` alone."""
    for name in CONTRACT.keys() & vars(kind).keys():
        if name == "run" or _is_foreign(kind):
            setattr(kind, name, _guarded(name, vars(kind)[name]))


def _is_foreign(kind: type[Any]) -> bool:
    return kind.__module__.partition(".")[0] != "harness"


def _guarded(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(call)
    def guarded(self: Engine, *arguments: Any) -> Any:
        try:
            value = call(self, *arguments)
            if flaw := _flaw(name, value, arguments):
                raise ContractError(f"{engine_label(self)}: {name} returned {flaw}")
        except ContractError as error:
            if name != "run":
                raise
            return [error for _ in arguments[0]]
        except Exception as error:
            full = isinstance(error, OSError) and error.errno in (*FULL, errno.EMFILE)
            if full or isinstance(error, HarnessError | MemoryError) or not _is_foreign(type(self)):
                raise
            raised = _raised(self, name, error)
            if name != "run":
                raise raised from error
            return [raised for _ in arguments[0]]
        return [_checked(self, outcome) for outcome in value] if name == "run" else value

    return guarded


def _flaw(name: str, value: Any, arguments: Sequence[Any]) -> str:
    """Return what a call returned, and what its contract has; nothing where it is right."""
    from harness.model.conventions import Rules
    from harness.model.motion import Motion

    kinds: dict[str, tuple[type, ...]] = {
        "identify": (Provenance,), "refuses": (str,), "fingerprint": (Mapping, type(None)),
        "rules": (Rules,), "motions": (list, tuple), "run": (list, tuple),
    }  # fmt: skip
    flaw = ""
    if not isinstance(value, kinds[name]):
        flaw = f"a {type(value).__name__}"
    elif isinstance(value, list | tuple):
        items = (Motion if name == "motions" else Output, EngineError)
        others = [item for item in value if not isinstance(item, items)]
        if others:
            flaw = f"a list with a {type(others[0]).__name__}"
        elif len(value) != len(arguments[0]):
            flaw = f"{len(value)} outcomes of {len(arguments[0])} jobs"
    return flaw and f"{flaw}, must return {CONTRACT[name]}"


def _raised(engine: Engine, call: str, error: Exception) -> ContractError:
    """Return the error of a call that raised what no engine should, with its place in the code."""
    frames = traceback.extract_tb(error.__traceback__)
    file = getattr(sys.modules.get(type(engine).__module__), "__file__", "")
    place = [*frames, *(f for f in frames if f.filename == file)][-1]
    text = " ".join(f"{type(error).__name__}: {error}".split()).strip(": ")[:160]
    return ContractError(
        f"{engine_label(engine)}: {call} raised {text} ({Path(place.filename).name}, line "
        f"{place.lineno}), must raise an EngineError, or return one for the job"
    ).with_log("".join(traceback.format_exception(error)))


def _checked(engine: Engine, outcome: Output | EngineError) -> Output | EngineError:
    """Return an outcome, or an error in its place where its tables are flawed."""
    if isinstance(outcome, EngineError):
        return outcome
    words = f"{engine_label(engine)}: run returned"
    if not isinstance(outcome.provenance, Provenance):
        return ContractError(f"{words} an Output of {type(outcome.provenance).__name__}, must "
                             "return a Provenance in it")  # fmt: skip
    for name, table in outcome.tables.items():
        if flaw := _flaw_of_table(table):
            return ContractError(f"{words} table {name!r} with {flaw}")
    if _is_foreign(type(engine)):
        for column, values in outcome.tables.get(SERIES, {}).items():
            if not column.endswith(("_N", "_N_m")) and not _is_finite(values):
                return EngineNaNError(f"{words} a series with values that are not numbers in "
                                      f"{column!r}, must return finite ones")  # fmt: skip
    return outcome


def _is_finite(values: Any) -> bool:
    import numpy as np

    return bool(np.isfinite(values).all())


def _flaw_of_table(table: Any) -> str:
    """Return the flaw of a table, and what is expected; nothing where it has none."""
    import numpy as np

    if not isinstance(table, Mapping):
        return f"a {type(table).__name__}, must return columns by name"
    for column, values in table.items():
        is_array = isinstance(values, np.ndarray)
        if not is_array or values.dtype.kind not in "fiub" or values.ndim not in (1, 2):
            kind = f"{values.dtype} array" if is_array else type(values).__name__
            return f"column {column!r} a {kind}, must return an array of numbers, (M,) or (M, N)"
    lengths = {column: len(values) for column, values in table.items()}
    if len({*lengths.values()}) > 1:
        return f"columns of several lengths ({lengths}), must return one for all"
    return ""
