"""The parts of a verification: each leaves rows, whatever becomes of the others."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from harness.comparison.triage import Triage
from harness.comparison.verdicts import Check, Kind, Verdict, failed_run
from harness.errors import EngineError, EngineOutputError, RequestError

Progress = Callable[[str, int, int], None]
"""Called with the name of a stage, the parts done, and the parts in all; from any thread."""


def silent(stage: str, done: int, total: int) -> None:
    """Report no progress."""


class Part(NamedTuple):
    """A part of a verification: its name, what runs it, and how many rows it leaves at least."""

    name: str
    run: Callable[[], Sequence[Check]]
    rows: int = 0


def rows_of_parts(case: str, parts: Iterable[Part], unit: str = "") -> list[Check]:
    """Run the parts of a verification in order and return their rows.

    A part that raises becomes a failed row; the other parts go on.
    """
    rows: list[Check] = []
    for part in parts:
        try:
            rows += part.run()
        except Exception as error:
            rows.append(failed_part(f"{case}: {part.name}", error, unit))
    return rows


def asked(part: Part) -> Part:
    """Return a part whose RequestError is the engine's failure.

    The runs are ours: one that does not show what is measured in it is the engine's doing.
    """

    def run() -> Sequence[Check]:
        try:
            return part.run()
        except RequestError as error:
            raise EngineOutputError(str(error)) from error

    return part._replace(run=run)


def failed_part(name: str, error: Exception, unit: str = "", kind: Kind = Kind.CROSS_CODE) -> Check:
    """Return the failed row of a part that raised: of an engine that died, or of an error here."""
    if isinstance(error, EngineError):
        return failed_run(name, kind, error, unit)
    nan = math.nan
    told = f"{type(error).__name__}: {error}"
    return Check(name, kind, unit, nan, nan, nan, nan, Verdict.FAIL, "", told, Triage.HARNESS)
