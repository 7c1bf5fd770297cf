"""The registry of cases: by folder, and by entry points of other packages.

A folder of this package with a module ``case``, or a module with a TOML file of its name, is a case
of that name, with hyphens for underscores. Another package names its cases under the entry point
``dem_harness.cases``. A case is imported when it is used, not to list names.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import harness.cases
from harness.cases.contract import Case
from harness.errors import RequestError

GROUP = "dem_harness.cases"
"""Entry point of other packages."""

ALL = "all"

MAIN = ("incline", "tower")
"""Cases that ``verify`` runs unless others are named."""


@cache
def built_in() -> tuple[str, ...]:
    """Return the names of the cases of this package, in order."""
    return tuple(_homes())


@cache
def _homes() -> dict[str, str]:
    """Return the module of each case by its name."""
    homes = {}
    for module in pkgutil.iter_modules(harness.cases.__path__, "harness.cases."):
        place = Path(harness.cases.__path__[0], module.name.rpartition(".")[2])
        if (place / "case.py").is_file() or place.with_suffix(".toml").is_file():
            name = place.name.replace("_", "-")
            homes[name] = f"{module.name}.case" if module.ispkg else module.name
    return homes


def plugins() -> Mapping[str, EntryPoint]:
    """Return the entry points of other packages by name; of two of one name the first."""
    return {point.name: point for point in reversed(_points())}


def _points() -> list[EntryPoint]:
    return sorted(entry_points(group=GROUP), key=lambda point: (point.name, _package(point)))


def case_names() -> tuple[str, ...]:
    """Return the names of all cases: of this package, then of others."""
    return (*built_in(), *(name for name in plugins() if name not in built_in()))


def get_case(name: str) -> Case[Any]:
    """Return a case by name.

    Raise RequestError for a name that is not known, and, naming its package, for a case of
    another package that cannot be used.
    """
    if name in built_in():
        case: Case[Any] = import_module(_homes()[name]).CASE
        return case
    point = plugins().get(name)
    if point is None:
        raise RequestError(f"case {name!r} is not known: must be one of {', '.join(case_names())}")
    return _loaded(point)


def all_cases() -> dict[str, Case[Any]]:
    """Return the cases that can be used, by name; what is wrong with others: :func:`faults`."""
    return _usable()[0]


def faults() -> tuple[str, ...]:
    """Return one line for each case of another package that cannot be used."""
    return tuple(_usable()[1])


def cases_named(text: str = "") -> dict[str, Case[Any]]:
    """Return the cases of a text such as ``incline,tower``; see :func:`names_in`."""
    return {name: get_case(name) for name in names_in(text)}


def names_in(text: str = "") -> tuple[str, ...]:
    """Return the names of the cases of a text: names, groups, or ``all``; no text: :data:`MAIN`.

    Names alone import no case. Raise RequestError for a word that is neither a name nor a group,
    for no word at all, and for a named case that cannot be used.
    """
    words = [word.strip() for word in text.split(",") if word.strip()] if text else MAIN
    if not words:
        raise RequestError(f"--cases {text!r}: names no case")
    unknown = [word for word in words if word != ALL and word not in case_names()]
    named = dict.fromkeys(word for word in words if word not in (ALL, *unknown))
    if len(named) == len(set(words)):
        return tuple(named)
    usable = all_cases()
    groups = {case.group for case in usable.values()}
    for word in unknown:
        if word not in groups:
            raise RequestError(
                f"--cases {word!r} is not known: must be {ALL}, a group "
                f"({', '.join(sorted(groups))}), or one or more of {', '.join(case_names())}"
            )
    wanted = {name: get_case(name) for name in named}
    return tuple(
        name
        for name, case in (usable | wanted).items()
        if name in wanted or ALL in words or case.group in unknown
    )


def _usable() -> tuple[dict[str, Case[Any]], list[str]]:
    usable, wrong = {name: get_case(name) for name in built_in()}, []
    for point in _points():
        first = plugins()[point.name]
        try:
            if point is not first and _package(point) != _package(first):
                raise RequestError(
                    f"package {_package(point)!r}, case {point.name!r}: package "
                    f"{_package(first)!r} has a case of this name"
                )
            usable[point.name] = _loaded(first)
        except RequestError as error:
            wrong.append(str(error))
    return usable, wrong


def _loaded(point: EntryPoint) -> Case[Any]:
    """Return the case of an entry point; raise RequestError that names its package."""
    where = f"package {_package(point)!r}, case {point.name!r}"
    if point.name in built_in():
        raise RequestError(f"{where}: this is the name of a case of dem-harness itself")
    try:
        case = point.load()
    except Exception as error:
        message = " ".join(f"{type(error).__name__}: {error}".split())
        raise RequestError(f"{where}: {point.value} does not import: {message}") from None
    if not isinstance(case, Case):
        raise RequestError(
            f"{where}: {point.value} is no case but {type(case).__name__}: must be an instance "
            "of harness.cases.contract.Case"
        )
    try:
        case.verification  # noqa: B018 - what it names must be there before anything runs
    except (ImportError, AttributeError, ValueError) as error:
        raise RequestError(f"{where}: verified_by = {case.verified_by!r}: {error}") from None
    without = [quantity.name for quantity in case.quantities if not quantity.unit]
    if without:
        raise RequestError(f"{where}: quantity {without[0]!r} has no unit ('1' for a pure number)")
    if getattr(case, "name", None) != point.name:
        named = getattr(case, "name", None)
        raise RequestError(f"{where}: its case has the name {named!r}: must be that of the entry")
    return case


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist is not None else point.value.partition(":")[0]
