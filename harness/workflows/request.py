"""What a verification is asked for: level, cases and baseline, checked before anything runs."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from harness.cases.contract import LEVELS, Case, LevelName
from harness.cases.registry import cases_named
from harness.comparison.regression import Baseline
from harness.errors import RequestError
from harness.store.baseline import committed, read_baseline


def checked_level(name: str) -> LevelName:
    """Return a level by its name; raise RequestError for a name that is not one."""
    for level in LEVELS:
        if level == name:
            return level
    raise RequestError(f"level = {name!r} is not known: must be one of {', '.join(LEVELS)}")


def chosen_cases(wanted: str | Iterable[str] | None) -> list[Case[Any]]:
    """Return the cases of names, groups or ``all``; those that run by default for None."""
    if wanted is None:
        return list(cases_named().values())
    return list(cases_named(wanted if isinstance(wanted, str) else ",".join(wanted)).values())


def chosen_baseline(given: Path | Baseline | None, tolerances: Path | None = None) -> Baseline:
    """Return the baseline of a folder, or the committed one; empty where there is none.

    ``tolerances`` is a file of overrides, the committed one unless given.
    """
    if isinstance(given, Baseline):
        return given
    where = given or committed()
    if where is None:
        return Baseline({}, "none")
    return read_baseline(where, tolerances)
