"""Nested parameters by names that are joined by dots, as in ``contact.tail``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


def nested(named: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Return values by name, nested ones in mappings of their own.

    Raise ValueError, naming the part, where a name comes twice or is both a value and a mapping.
    """
    tree: dict[str, Any] = {}
    for name, value in named:
        *outer, last = name.split(".")
        inner = tree
        for key in outer:
            inner = inner.setdefault(key, {})
            if not isinstance(inner, dict):
                raise ValueError(f"{name}: {key} is set as a whole already")
        if last in inner:
            raise ValueError(f"{name}: {last} is set already, or parts of it are")
        inner[last] = value
    return tree
