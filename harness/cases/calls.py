"""Guards of a case of another package: what a call raises or returns becomes one line."""

from __future__ import annotations

import functools
import traceback
from collections.abc import Callable, Mapping
from numbers import Real
from pathlib import Path
from typing import Any

from harness.engines.base import Job
from harness.errors import HarnessError, RequestError

EXPECTED = {
    "job": "a Job",
    "measure": "numbers by the names of quantities",
    "exact": "numbers by the names of quantities",
}  # results of calls


class CaseError(RequestError):
    """A call of a case that raises, or returns another type than the contract has."""


def guard_calls(kind: type[Any]) -> None:
    """Guard the calls of a class of another package that are in :data:`EXPECTED`."""
    if kind.__module__.partition(".")[0] == "harness":
        return
    for name in EXPECTED.keys() & vars(kind).keys():
        setattr(kind, name, _guarded(name, vars(kind)[name]))


def case_error(case: Any, call: str, found: str, expected: str) -> CaseError:
    """Return the error of a call in one line: package, case, call, found and expected."""
    package = type(case).__module__.partition(".")[0]
    where = "" if package == "harness" else f"package {package!r}, "
    return CaseError(f"{where}case {case.name!r}: {call} {found}, must return {expected}")


def _guarded(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(call)
    def guarded(self: Any, *arguments: Any, **options: Any) -> Any:
        try:
            value = call(self, *arguments, **options)
        except HarnessError:
            raise
        except Exception as error:  # another package may raise anything
            place = traceback.extract_tb(error.__traceback__)[-1]
            text = " ".join(f"{type(error).__name__}: {error}".split())[:160]
            found = f"raised {text} ({Path(place.filename).name}, line {place.lineno})"
            raise case_error(self, name, found, EXPECTED[name]) from error
        if not _is_expected(name, value):
            raise case_error(self, name, f"returned a {type(value).__name__}", EXPECTED[name])
        return value

    return guarded


def _is_expected(name: str, value: Any) -> bool:
    if name == "job":
        return isinstance(value, Job)
    return isinstance(value, Mapping) and all(isinstance(one, Real) for one in value.values())
