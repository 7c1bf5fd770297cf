"""Calls of a case that may raise or return anything: results of the right type, or one line."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from harness.cases.base import Case, Check
from harness.engines.contract import Engine
from harness.errors import EngineError, Unsupported
from harness.report.content import Section

EXPECTED = {
    "checks": "a list of harness.cases.base.Check",
    "own_checks": "a list of harness.cases.base.Check",
    "comparisons": "a list of pairs (Engine, Check)",
    "sections": "a list of harness.report.content.Section",
}


class CaseError(Exception):
    """A case that raises, or returns a wrong type, in one line."""


def checks_in(case: Case[Any], call: str, make: Callable[[], Any]) -> list[Check]:
    """Return the checks of ``checks`` or ``own_checks``; raise CaseError for anything else."""
    return _items(case, call, make, Check)


def comparisons_in(case: Case[Any], engines: Sequence[Engine]) -> dict[str, list[Check]]:
    """Return the comparisons of engines by the engine that is measured; likewise."""
    checks: dict[str, list[Check]] = {}
    for pair in _items(case, "comparisons", lambda: case.comparisons(engines), tuple):
        match pair:
            case (Engine() as engine, Check() as check):
                checks.setdefault(engine.name, []).append(check)
            case _:
                raise _error(case, "comparisons", f"returned a tuple of {len(pair)} other items")
    return checks


def sections_in(case: Case[Any], make: Callable[[], Any]) -> list[Section]:
    """Return the sections of a case; likewise."""
    return _items(case, "sections", make, Section)


def _items(case: Case[Any], call: str, make: Callable[[], Any], kind: type[Any]) -> list[Any]:
    try:
        result = make()
        are_many = isinstance(result, Iterable) and not isinstance(result, str | Mapping)
        items = list(result) if are_many else None
    except (Unsupported, EngineError):
        raise
    except Exception as error:  # a case of another package may raise anything
        text = " ".join(f"{type(error).__name__}: {error}".split())
        raise _error(case, call, f"raised {text}") from error
    if items is None:
        raise _error(case, call, f"returned {_described(result)}")
    for item in items:
        if not isinstance(item, kind):
            raise _error(case, call, f"returned {_described(item)} among its items")
    return items


def _described(value: object) -> str:
    return "None" if value is None else f"a {type(value).__name__}"


def _error(case: Case[Any], call: str, found: str) -> CaseError:
    package = type(case).__module__.partition(".")[0]
    where = "" if package == "harness" else f"package {package!r}, "
    return CaseError(f"{where}case {case.name!r}: {call} {found}, must return {EXPECTED[call]}")
