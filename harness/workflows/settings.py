"""Settings as text: ``height=3``, ``contact.tail=clipped``, ``preset=kharaz``; what they allow."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, get_args

from harness.cases.base import Case
from harness.errors import CombinationError, RequestError
from harness.model.allowed import allowed_in
from harness.model.base import Parameters, unit

PRESET = "preset"
NONE = "none"  # text of a value that is left out
Tree = dict[str, Any]  # settings by name; nested ones are a tree of their own


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter: its default, unit, meaning, and what is ``allowed`` in words."""

    default: Any
    unit: str
    description: str
    allowed: str = ""


def parameters_of(case: Case[Any], settings: Mapping[str, str]) -> Parameters:
    """Return the parameters of a case with settings on top of its default or a preset.

    Raise RequestError, naming setting, value and what is allowed, for a wrong name or value;
    CombinationError for values that are not allowed together.
    """
    base = _preset(case, settings[PRESET]) if PRESET in settings else case.default
    changes = {name: text for name, text in settings.items() if name != PRESET}
    try:
        return _changed(base, _tree(changes))
    except RequestError as error:
        raise type(error)(f"--set {error}") from None


def split_settings(
    case: Case[Any], settings: Mapping[str, str], quantities: Iterable[str]
) -> tuple[dict[str, str], dict[str, Any]]:
    """Return the settings of parameters, and the options of the search for quantities.

    Raise RequestError for an option without a search, and for a parameter that a search varies.
    """
    searched = [q for name in quantities if (q := case.quantity(name)).varies]
    options = {n: t for n, t in settings.items() if n in case.search_options.model_fields}
    for quantity in searched:
        for name in quantity.varies:
            if name in settings:
                raise RequestError(f"--set {name}={settings[name]}: {quantity.name} varies it")
    if options and not searched:
        names = ", ".join(q.name for q in case.quantities if q.varies)
        raise RequestError(f"--set {next(iter(options))}: goes with --quantity {names} only")
    try:
        chosen = _changed(case.search_options(), _tree(options))
    except RequestError as error:
        raise type(error)(f"--set {error}") from None
    return {n: t for n, t in settings.items() if n not in options}, dict(chosen)


def quantity_names(case: Case[Any], text: str | Iterable[str]) -> list[str]:
    """Return the names of quantities in a text with commas; RequestError for an unknown one."""
    texts = text.split(",") if isinstance(text, str) else list(text)
    names = list(dict.fromkeys(name.strip() for name in texts if name.strip()))
    for name in names:
        case.quantity(name)
    kinds = {bool(case.quantity(name).varies) for name in names}
    if len(kinds) > 1:
        raise RequestError(f"--quantity {','.join(names)}: a search is another run than the others")
    return names


def parameter_infos(values: Parameters) -> dict[str, ParameterInfo]:
    """Return all parameters by name, of nested ones with a dot; their values are the defaults."""
    return dict(_infos(values, ""))


def flat_values(values: Parameters) -> dict[str, Any]:
    """Return the values of all parameters by name; lists and tables as JSON text."""
    return {name: _cell(info.default) for name, info in parameter_infos(values).items()}


def as_text(values: Any) -> str:
    """Return values of a TOML file or of Python as the text of the command line."""
    many = values if isinstance(values, Iterable) and not isinstance(values, str) else [values]
    return ",".join(NONE if value is None else str(value) for value in many)


def flat(tree: Mapping[str, Any], prefix: str = "") -> dict[str, str]:
    """Return the values of nested tables as text, with dots in their names."""
    values: dict[str, str] = {}
    for name, value in tree.items():
        if isinstance(value, Mapping):
            values |= flat(value, f"{prefix}{name}.")
        else:
            values[prefix + name] = as_text(value)
    return values


def _infos(values: Parameters, prefix: str) -> Iterator[tuple[str, ParameterInfo]]:
    kind = type(values)
    allowed = allowed_in(kind)
    for name, field in kind.model_fields.items():
        value = getattr(values, name)
        if isinstance(value, Parameters):
            yield from _infos(value, f"{prefix}{name}.")
            continue
        meaning = (field.description or "").partition("]")[2].strip()
        limits = allowed.get(name)
        text = ", ".join(limits.words) or limits.range if limits else ""
        info = ParameterInfo(value, unit(kind, name), meaning, text)
        yield prefix + name, info


def _cell(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return json.dumps(value, default=lambda x: x.model_dump(mode="json"))


def _preset(case: Case[Any], name: str) -> Parameters:
    if name not in case.presets:
        presets = ", ".join(case.presets)
        raise RequestError(f"--set preset={name}: case {case.name!r} has the presets {presets}")
    preset: Parameters = case.presets[name]
    return preset


def _tree(settings: Mapping[str, str]) -> Tree:
    tree: Tree = {}
    for name, text in settings.items():
        *outer, last = name.split(".")
        inner = tree
        for key in outer:
            inner = inner.setdefault(key, {})
            if not isinstance(inner, dict):
                raise RequestError(f"{name}: {key} is set as a whole already")
        if last in inner:
            raise RequestError(f"{name}: parts of it are set already")
        inner[last] = text
    return tree


def _changed(parameters: Parameters, tree: Tree) -> Parameters:
    kind, changes = type(parameters), {}
    for name, part in tree.items():
        inner = getattr(parameters, name, None)
        if not isinstance(part, dict):
            changes[name] = _value(kind, name, part)
        elif isinstance(inner, Parameters):
            changes[name] = _changed_part(inner, part, name)
        elif name in kind.model_fields:
            raise RequestError(f"{name}.{next(iter(part))}: {name} has no parts")
        else:
            changes[name] = part  # refused by name, with the names that there are
    return parameters.replace(**changes)


def _changed_part(inner: Parameters, part: Tree, name: str) -> Parameters:
    try:
        return _changed(inner, part)
    except CombinationError:
        raise
    except RequestError as error:  # its text begins with the name of the field
        raise RequestError(f"{name}.{error}") from None


def _value(kind: type[Parameters], name: str, text: str) -> Any:
    field = kind.model_fields.get(name)
    if field is None:
        return text
    if text == NONE and type(None) in get_args(field.annotation):
        return None
    if field.annotation is int or int in get_args(field.annotation):
        with suppress(ValueError):
            return int(text)
    if text[:1] in "[(":
        with suppress(ValueError):
            return json.loads(text.replace("(", "[").replace(")", "]"))
    return text
