"""Settings of a case as the command line gives them: texts by name, read by its parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from harness.cases.contract import Case
from harness.errors import RequestError
from harness.parameters.base import Parameters
from harness.parameters.nested import nested
from harness.workflows.case_list import default_of

PRESET = "preset"
NONE = "none"
"""Text of a value that is left out."""

Tree = dict[str, Any]
"""Settings by name; a nested one is a tree of its own."""


def parameters_of(case: Case[Any], settings: Mapping[str, str]) -> Parameters:
    """Return the parameters of a case with settings as ``height=3`` and ``contact.tail=clipped``.

    ``preset`` chooses the set that they change. Raise RequestError, naming the setting and what
    is allowed, for a name or value that is not, CombinationError for values that are not together.
    """
    base = _preset(case, settings[PRESET]) if PRESET in settings else default_of(case)
    tree = _tree((name, text) for name, text in settings.items() if name != PRESET)
    try:
        if base is None:
            return case.parameters(**_values(case.parameters, tree))
        return _changed(base, tree, "")
    except RequestError as error:
        raise type(error)(f"--set: {error}") from None


def _tree(settings: Iterable[tuple[str, str]]) -> Tree:
    try:
        return nested(settings)
    except ValueError as error:
        raise RequestError(f"--set {error}") from None


def _preset(case: Case[Any], name: str) -> Parameters:
    if name not in case.presets:
        known = ", ".join(case.presets) or "none"
        raise RequestError(f"--set preset={name}: case {case.name!r} has the presets {known}")
    found: Parameters = case.presets[name]
    return found


def _changed(parameters: Parameters, tree: Tree, prefix: str) -> Parameters:
    """Return parameters with the changes of a tree, nested ones part by part."""
    fields = type(parameters).model_fields
    changes = _values(type(parameters), {k: v for k, v in tree.items() if not isinstance(v, dict)})
    for name, part in tree.items():
        if not isinstance(part, dict):
            continue
        nested = getattr(parameters, name, None)
        if name in fields and not isinstance(nested, Parameters):
            raise RequestError(f"{prefix}{name} has no parts (given: {', '.join(part)})")
        # a name that is not known is refused, with those that are, by replace()
        changes[name] = _changed(nested, part, f"{prefix}{name}.") if nested is not None else part
    return parameters.replace(**changes)


def _values(kind: type[Parameters], tree: Tree) -> Tree:
    """Return settings as values: whole numbers, and ``none`` where one may be left out."""
    return {name: _value(kind, name, text) for name, text in tree.items()}


def _value(kind: type[Parameters], name: str, text: Any) -> Any:
    field = kind.model_fields.get(name)
    if field is None or not isinstance(text, str):
        return text
    if text == NONE and type(None) in _kinds(field.annotation):
        return None
    # a strict whole number is not read from a text
    whole = field.annotation is int and text.strip().lstrip("+-").isdecimal()
    return int(text) if whole else text


def _kinds(annotation: Any) -> tuple[Any, ...]:
    return getattr(annotation, "__args__", ())
