"""Presets of the literature, from the table beside this module."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any, TypeVar

from harness.cases.contacts.parameters import ContactSystem

P = TypeVar("P", bound=ContactSystem)


def presets_of(
    case: str, kind: type[P], usual: Mapping[str, Mapping[str, Any]]
) -> tuple[dict[str, P], dict[str, str]]:
    """Return the presets of a case, the ``usual`` ones first, and the sources of the others."""
    published = _table().get(case, {})
    sources = {name: values["source"] for name, values in published.items()}
    given = {
        name: {key: value for key, value in values.items() if key != "source"}
        for name, values in published.items()
    }
    return {name: kind(**values) for name, values in {**usual, **given}.items()}, sources


@cache
def _table() -> dict[str, dict[str, dict[str, Any]]]:
    text = (files(__package__) / "presets.toml").read_text("utf-8")
    table: dict[str, dict[str, dict[str, Any]]] = tomllib.loads(text)
    return table
