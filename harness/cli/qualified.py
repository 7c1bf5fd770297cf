"""Whether the engine that a command ran qualifies: told beside what it measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.cli.recording import Recording
    from harness.engines.contract import Engine


def qualification(engine: Engine | None, told: Recording) -> dict[str, Any]:
    """Qualify an engine and return what a record says of it; one that fails sets the status to 3.

    Nothing for a solver of the harness and the engines that others are held against. Ask after
    the result, which raises RequestError for a wrong request at once; kept runs are not repeated.
    """
    from harness.cases.qualification import qualify
    from harness.engines.registry import ALWAYS
    from harness.errors import EngineError, HarnessError

    if engine is None or engine.name in ALWAYS:
        return {}
    try:
        reason = qualify(engine).reason
    except EngineError as error:
        reason = str(error)
    if reason:
        told.status = HarnessError.exit_status
    return {"qualified": not reason, "qualification_failures": reason}


def end_unqualified(record: Mapping[str, Any], engine: str) -> None:
    """End with status 3, and the reason on stderr, where the engine of a record did not qualify."""
    import typer

    from harness.errors import HarnessError
    from harness.report.plain import printable
    from harness.store.entries import tell_stderr

    if not record.get("qualified", True):
        reason = printable(record["qualification_failures"])
        tell_stderr(f"engine {engine!r} did not qualify, its result is not to be used: {reason}")
        raise typer.Exit(HarnessError.exit_status)
