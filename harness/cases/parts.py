"""The parts of a verification: each leaves rows, whatever becomes of the others."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from harness.comparison.triage import Triage
from harness.comparison.verdicts import Check, Kind, Verdict, failed_run
from harness.errors import EngineError

Part = tuple[str, Callable[[], Sequence[Check]]]
"""A part of a verification: its name, and what runs it and returns its rows."""


def rows_of_parts(case: str, parts: Sequence[Part], unit: str = "") -> list[Check]:
    """Run the parts of a verification in order and return their rows.

    A part that raises becomes a failed row; the other parts go on.
    """
    rows: list[Check] = []
    for name, part in parts:
        try:
            rows += part()
        except Exception as error:
            rows.append(failed_part(f"{case}: {name}", error, unit))
    return rows


def failed_part(name: str, error: Exception, unit: str = "", kind: Kind = Kind.CROSS_CODE) -> Check:
    """Return the failed row of a part that raised: of an engine that died, or of an error here."""
    if isinstance(error, EngineError):
        return failed_run(name, kind, error, unit)
    nan = math.nan
    told = f"{type(error).__name__}: {error}"
    return Check(name, kind, unit, nan, nan, nan, nan, Verdict.FAIL, "", told, Triage.HARNESS)
