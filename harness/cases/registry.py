"""The registry of cases: names and groups, those of this package and of others.

Names and groups are listed without an import of a case. Another package names its cases under the
entry point ``dem_harness.cases``, each ``name = "module:CASE"`` with an instance of
:class:`harness.cases.base.Case`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from harness.cases.base import Case
from harness.errors import BrokenCaseError, RequestError

ENTRY_POINT = "dem_harness.cases"
ALL = "all"
DEFAULT = ("incline", "tower")  # cases of `verify` unless others are named
QUALIFYING = ("drop",)  # cases of this package that an engine must pass before all others

_CONTACTS = {
    "impact": ("bounce", "head-on", "stacked"),
    "oblique": ("box", "collision", "lj-units", "oblique", "spin"),
    "prescribed_motion": ("prescribed-motion", "pull-off"),
    "resting": ("incline-rest", "incline-roll", "rolling-resistance", "slip-to-roll", "twist"),
    "surroundings": ("curved-wall", "drag", "heat", "moving-wall"),
}  # by module

GROUPS: Mapping[str, Mapping[str, str]] = {
    "incline": {
        "incline": "harness.cases.incline.case:CASE",
        "columns": "harness.cases.incline.columns:CASE",
    },
    "chains": {"tower": "harness.cases.tower.case:CASE"},
    "contacts": {
        "drop": "harness.cases.drop:CASE",
        **{
            name: f"harness.cases.contacts.{module}:{name.replace('-', '_').upper()}"
            for name, module in sorted((n, m) for m, names in _CONTACTS.items() for n in names)
        },
    },
    "layers": {
        "layers": "harness.cases.layers.descent:CASE",
        "layers-flow": "harness.cases.layers.flow:CASE",
    },
    "bulk": {n: f"harness.cases.bulk.{n}:CASE" for n in ("silo", "drum", "heap", "penetration")},
}
"""Where the cases of this package are, by group and name."""


def homes() -> dict[str, str]:
    """Return ``module:CASE`` of each case of this package, by name."""
    return {name: home for group in GROUPS.values() for name, home in group.items()}


def case_names() -> tuple[str, ...]:
    """Return the names of all cases: of this package, then of others. Nothing is imported."""
    return tuple(dict.fromkeys((*homes(), *_plugins())))


def get_case(name: str) -> Case[Any]:
    """Return a case by name.

    Raise RequestError for an unknown name, BrokenCaseError for a case of another package that
    cannot be used.
    """
    if (home := homes().get(name)) is not None:
        module, _, attribute = home.partition(":")
        case: Case[Any] = getattr(import_module(module), attribute)
        return case
    if (point := _plugins().get(name)) is not None:
        return _plugin_case(point)
    raise RequestError(f"case {name!r} is not known: must be one of {', '.join(case_names())}")


def usable_cases() -> dict[str, Case[Any]]:
    """Return all cases that can be used, by name; :func:`plugin_faults` has the reasons."""
    points = [point for point in _plugins().values() if not _fault(point)]
    cases = {name: get_case(name) for name in homes()}
    return cases | {point.name: _plugin_case(point) for point in points}


def plugin_faults() -> list[str]:
    """Return one line for each case of another package that cannot be used."""
    return [fault for point in entry_points(group=ENTRY_POINT) if (fault := _fault(point))]


def hidden_cases() -> dict[str, str]:
    """Return why cases cannot be reached that have the name of another, by ``package:name``."""
    points = (p for p in entry_points(group=ENTRY_POINT) if _owner(p) != _package(p))
    return {f"{_package(point)}:{point.name}": _fault(point) for point in points}


def selected_cases(
    words: str | Iterable[str] | None = None,
) -> tuple[list[Case[Any]], dict[str, str]]:
    """Return the cases of names, groups or ``all``, and why others of them cannot be used, by name.

    Errors are those of :func:`selected_names`, and BrokenCaseError for a broken case that is named.
    """
    named, cases, faults = words_in(words or ()), list[Case[Any]](), dict[str, str]()
    for name in selected_names(words):
        try:
            cases.append(get_case(name))
        except BrokenCaseError as error:
            if name in named:
                raise
            faults[name] = str(error)
    return cases, faults | (hidden_cases() if ALL in named else {})


def selected_names(words: str | Iterable[str] | None = None) -> list[str]:
    """Return the names of cases by names, groups or ``all``; :data:`DEFAULT` for None.

    ``all`` has cases of other packages that cannot be used, too. Raise RequestError for another
    word, and for no word at all.
    """
    if words is None:
        return list(DEFAULT)
    texts = words_in(words)
    if not texts:
        raise RequestError(f"--cases {words!r}: names no case")
    return list(dict.fromkeys(name for text in texts for name in _names_of(text)))


def words_in(texts: str | Iterable[str]) -> list[str]:
    """Return the words of a text with commas, or of several texts, each once.

    Raise RequestError for what is no text.
    """
    many = texts.split(",") if isinstance(texts, str) else texts
    try:
        return list(dict.fromkeys(text.strip() for text in many if text.strip()))
    except (TypeError, AttributeError):
        raise RequestError(f"{texts!r}: must be a name, or several names") from None


def _names_of(word: str) -> list[str]:
    if word == ALL:
        return list(case_names())
    if word in case_names():
        return [word]
    plugins = (point for point in _plugins().values() if not _fault(point))
    members = [point.name for point in plugins if _plugin_case(point).group == word]
    members = [*GROUPS.get(word, ()), *members]
    if not members:
        raise RequestError(
            f"--cases {word!r} is not known: must be {ALL}, a group ({', '.join(GROUPS)}), or one "
            f"or more of {', '.join(case_names())}"
        )
    return members


@cache
def _plugins() -> dict[str, EntryPoint]:
    """Return the cases of other packages by name; of two packages the first by name."""
    points = sorted(entry_points(group=ENTRY_POINT), key=_package, reverse=True)
    return dict(sorted({point.name: point for point in points}.items()))


def _fault(point: EntryPoint) -> str:
    try:
        _plugin_case(point)
    except BrokenCaseError as error:
        return str(error)
    return ""


def _plugin_case(point: EntryPoint) -> Case[Any]:
    label = f"package {_package(point)!r}, case {point.name!r}: {point.value}"
    if (owner := _owner(point)) != _package(point):
        raise BrokenCaseError(f"{label}: package {owner!r} has a case of this name")
    try:
        case = point.load()
    except (Exception, SystemExit) as error:  # another package may raise anything
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise BrokenCaseError(f"{label} does not import: {reason}") from None
    if not isinstance(case, Case):
        must = "must be an instance of harness.cases.base.Case"
        raise BrokenCaseError(f"{label} is a {type(case).__name__}, {must}")
    if (name := getattr(case, "name", None)) != point.name:
        raise BrokenCaseError(f"{label} has the name {name!r}, must be the same")
    return case


def _owner(point: EntryPoint) -> str:
    """Return the package whose case of this name is used."""
    return "dem-harness" if point.name in homes() else _package(_plugins().get(point.name, point))


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist is not None else point.value.partition(":")[0]
