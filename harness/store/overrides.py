"""Read named overrides of the regression tolerances from a TOML file."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.comparison.regression_tolerances import Override
from harness.comparison.tolerances import Tolerance
from harness.errors import RequestError
from harness.store.bounded_text import bounded_text

SHORTEST_REASON = 20


def read_overrides(path: Path) -> tuple[Override, ...]:
    """Return the overrides of a file.

    Each is a table ``[override.NAME]`` with ``case`` (the record's name) and ``quantity``
    (patterns with * and ?), ``absolute``, ``relative`` and a ``reason``. Raise RequestError,
    naming file and override, for anything else.
    """
    try:
        record = tomllib.loads(bounded_text(path))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        said = error.strerror if isinstance(error, OSError) else error
        raise RequestError(f"--tolerances {path}: cannot be read: {said}") from None
    tables = record.pop("override", {})
    if record or not isinstance(tables, dict):
        raise RequestError(f"--tolerances {path}: holds tables [override.NAME] and nothing else")
    return tuple(_override(path, name, table) for name, table in tables.items())


def _override(path: Path, name: str, table: Mapping[str, Any]) -> Override:
    where = f"--tolerances {path}, [override.{name}]"
    keys = {"case": str, "quantity": str, "reason": str}
    for key, kind in keys.items():
        if not isinstance(table.get(key), kind):
            raise RequestError(f"{where}: {key} = {table.get(key)!r}: must be a text")
    widths = {key: table.get(key, 0.0) for key in ("absolute", "relative")}
    for key, width in widths.items():
        number = isinstance(width, (int, float)) and not isinstance(width, bool)
        if not number or not (math.isfinite(width) and width >= 0):
            raise RequestError(f"{where}: {key} = {width!r}: must be finite and at least 0")
    unknown = sorted(set(table) - {*keys, *widths})
    if unknown:
        raise RequestError(f"{where}: {unknown[0]} is not known")
    if len(table["reason"]) < SHORTEST_REASON:
        raise RequestError(f"{where}: reason = {table['reason']!r}: say why, in a sentence")
    width = Tolerance("", float(widths["absolute"]), float(widths["relative"]), table["reason"])
    return Override(name, table["case"], table["quantity"], width)
