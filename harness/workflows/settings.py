"""Settings as text: ``height=3``, ``contact.tail=clipped``, ``preset=kharaz``; what they allow."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any, get_args

from harness.cases.base import Case
from harness.cases.registry import ALL
from harness.engines.registry import engine_class, engine_names
from harness.errors import CombinationError, RequestError
from harness.model.allowed import allowed_in
from harness.model.base import Parameters, unit

PRESET = "preset"
NONE = "none"  # text of an optional value that is not given


def words_in(texts: str | Iterable[str]) -> list[str]:
    """Return the words of a text with commas, or of several texts, each once."""
    many = texts.split(",") if isinstance(texts, str) else texts
    return list(dict.fromkeys(text.strip() for text in many if text.strip()))


def selected_engines(engines: str | Iterable[str], solvers: Iterable[str] = ()) -> list[str]:
    """Return the names of engines and solvers; ``all`` is every one, in their order.

    Raise RequestError for an unknown name, and for none.
    """
    names, every = words_in(engines), [*engine_names(), *solvers]
    for name in names:
        if ":" in name:
            engine_class(name)  # module:Class, which raises where there is none
        elif name not in (ALL, *every):
            must = f"{ALL}, or one or more of {', '.join(every)}"
            raise RequestError(f"--engines {name!r} is not known: must be {must}")
    if not names:
        raise RequestError(f"--engines {engines!r}: names no engine")
    if ALL not in names:
        return names
    return list(dict.fromkeys([*every, *(name for name in names if name != ALL)]))


def quantity_names(case: Case[Any], text: str | Iterable[str]) -> list[str]:
    """Return the names of quantities in a text with commas; RequestError for an unknown one."""
    names = words_in(text)
    if len({bool(case.quantity(name).varies) for name in names}) > 1:
        raise RequestError(f"--quantity {','.join(names)}: a search is another run than the others")
    return names


def parameters_of(case: Case[Any], settings: Mapping[str, str]) -> Parameters:
    """Return the parameters of a case with settings on top of its default or a preset.

    Raise RequestError, naming setting, value and what is allowed, for a wrong name or value;
    CombinationError for values that are not allowed together.
    """
    base: Parameters = case.default
    if (preset := settings.get(PRESET)) is not None:
        if preset not in case.presets:
            names = ", ".join(case.presets)
            raise RequestError(f"--set preset={preset}: case {case.name!r} has the presets {names}")
        base = case.presets[preset]
    return changed(base, {name: text for name, text in settings.items() if name != PRESET})


def split_settings(
    case: Case[Any], settings: Mapping[str, str], quantities: Iterable[str]
) -> tuple[dict[str, str], dict[str, Any]]:
    """Return the settings of parameters, and the options of the search for quantities.

    Raise RequestError for an option without a search, and for a parameter that a search varies.
    """
    searched = [q for name in quantities if (q := case.quantity(name)).varies]
    fields = case.search_options.model_fields
    options = {name: text for name, text in settings.items() if name in fields}
    for quantity in searched:
        for name in quantity.varies:
            if name in settings:
                raise RequestError(f"--set {name}={settings[name]}: {quantity.name} varies it")
    if options and not searched:
        names = ", ".join(q.name for q in case.quantities if q.varies)
        raise RequestError(f"--set {next(iter(options))}: goes with --quantity {names} only")
    chosen = changed(case.search_options(), options)
    return {name: text for name, text in settings.items() if name not in options}, dict(chosen)


def changed(parameters: Parameters, texts: Mapping[str, str], path: str = "") -> Parameters:
    """Return parameters with settings on top; ``path`` leads to parameters that are nested."""
    kind = type(parameters)
    values = {name: _value(kind, name, text) for name, text in texts.items() if "." not in name}
    parts: dict[str, dict[str, str]] = {}
    for name, text in texts.items():
        outer, dot, inner = name.partition(".")
        if dot:
            parts.setdefault(outer, {})[inner] = text
    for name, inner_texts in parts.items():
        nested = getattr(parameters, name, None)
        if name in values:
            raise RequestError(f"--set {path}{name}: is set as a whole already")
        if isinstance(nested, Parameters):
            values[name] = changed(nested, inner_texts, f"{path}{name}.")
        elif name in kind.model_fields:
            raise RequestError(f"--set {path}{name}.{min(inner_texts)}: {name} has no parts")
        else:
            values[name] = inner_texts  # refused by name, with the names that there are
    try:
        return parameters.replace(**values)
    except CombinationError as error:
        raise CombinationError(f"--set {error}") from None
    except RequestError as error:
        raise RequestError(f"--set {path}{error}") from None


def parameter_records(values: Parameters, path: str = "") -> dict[str, dict[str, Any]]:
    """Return default, unit, description and what is allowed of all parameters, by name.

    The name of a nested parameter has a dot; the values are the defaults.
    """
    return dict(_records(values, path))


def flat_values(values: Parameters) -> dict[str, Any]:
    """Return the values of all parameters by name; lists and tables as JSON text."""
    return {name: _cell(record["default"]) for name, record in parameter_records(values).items()}


def as_text(values: Any) -> str:
    """Return values of a TOML file or of Python as the text of the command line."""
    many = values if isinstance(values, Iterable) and not isinstance(values, str) else [values]
    return ",".join(NONE if value is None else str(value) for value in many)


def flat(tree: Mapping[str, Any], path: str = "") -> dict[str, str]:
    """Return the values of nested tables as text, with dots in their names."""
    values: dict[str, str] = {}
    for name, value in tree.items():
        if isinstance(value, Mapping):
            values |= flat(value, f"{path}{name}.")
        else:
            values[path + name] = as_text(value)
    return values


def _records(values: Parameters, path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    kind = type(values)
    allowed = allowed_in(kind)
    for name, field in kind.model_fields.items():
        value, limits = getattr(values, name), allowed.get(name)
        if isinstance(value, Parameters):
            yield from _records(value, f"{path}{name}.")
            continue
        yield (
            path + name,
            {
                "default": value,
                "unit": unit(kind, name),
                "description": (field.description or "").partition("]")[2].strip(),
                "allowed": (", ".join(limits.words) or limits.range) if limits else "",
            },
        )


def _cell(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return json.dumps(value, default=lambda part: part.model_dump(mode="json"))


def _value(kind: type[Parameters], name: str, text: str) -> Any:
    field = kind.model_fields.get(name)
    types = () if field is None else (field.annotation, *get_args(field.annotation))
    if text == NONE and type(None) in types:
        return None
    if int in types:
        with suppress(ValueError):
            return int(text)
    if types and text[:1] in "[(":
        with suppress(ValueError):
            return json.loads(text.replace("(", "[").replace(")", "]"))
    return text
