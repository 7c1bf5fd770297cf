"""Write parameters as one line of text, and read them back exactly.

``contact.tail = attractive; height = 17; step_s = 1e-06``: names of nested parameters joined by
dots, sorted; a value as JSON, a text without its quotes where nothing else could be meant.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from harness.parameters.nested import nested

SEPARATOR, EQUALS = "; ", " = "

_NAME = re.compile(r"[^\s.=;]+")
_PLAIN = re.compile(r"[^\W\d_][\w ,.+/()-]*(?<! )")
_WORDS = frozenset({"true", "false", "null", "NaN", "Infinity"})


def parameter_text(parameters: Mapping[str, Any]) -> str:
    """Return parameters as text; raise ValueError for a name or value that it cannot state."""
    return SEPARATOR.join(f"{name}{EQUALS}{value}" for name, value in _flat(parameters, ""))


def parameters_of(text: str) -> dict[str, Any]:
    """Return the parameters of a text; raise ValueError where it is damaged."""
    return nested(map(_parameter, text.split(SEPARATOR) if text else []))


def _parameter(part: str) -> tuple[str, Any]:
    name, equals, value = part.partition(EQUALS)
    if not equals:
        raise ValueError(f"{part!r} is no parameter")
    return name, value if _is_plain(value) else json.loads(value)


def _flat(parameters: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, str]]:
    for name, value in sorted(parameters.items()):
        if not _NAME.fullmatch(name):
            raise ValueError(f"{name!r} is no name of a parameter")
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, _text(value)


def _text(value: Any) -> str:
    if isinstance(value, str) and _is_plain(value):
        return value
    text = json.dumps(value, ensure_ascii=False, sort_keys=True, allow_nan=False)
    # inside a JSON text, a semicolon stands in a string
    return text.replace(";", "\\u003b")


def _is_plain(text: str) -> bool:
    return bool(_PLAIN.fullmatch(text)) and text not in _WORDS
