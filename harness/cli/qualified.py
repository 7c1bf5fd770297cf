"""End a command that ran one engine: whether that qualifies is told beside what it measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from harness.cli.output import print_json
from harness.errors import EngineError, HarnessError
from harness.report.plain import printable

if TYPE_CHECKING:
    from harness.cli.recording import Recording
    from harness.engines.contract import Engine


def completed(record: Mapping[str, Any], engine: Engine | None, told: Recording) -> dict[str, Any]:
    """Return a record with whether its engine qualifies, and how many runs were made or kept.

    An engine that does not qualify sets the status to 3. Nothing is added for a solver of the
    harness. Ask after the result, which raises RequestError for a wrong request at once; kept
    runs are not repeated.
    """
    from harness.cli.engine_options import runs_made

    full = {**record, **qualification(engine, told), **runs_made(engine)}
    told.engine = full
    return full


def answer(
    record: Mapping[str, Any], engine: str, json: bool, show: Callable[[Mapping[str, Any]], None]
) -> None:
    """Print a record, and end with status 3 and the reason where its engine did not qualify."""
    import typer

    from harness.store.entries import tell_stderr

    (print_json if json else show)(record)
    if not record.get("qualified", True):
        reason = printable(record["qualification_failures"])
        tell_stderr(f"engine {engine!r} did not qualify, its result is not to be used: {reason}")
        raise typer.Exit(HarnessError.exit_status)


def qualification(engine: Engine | None, told: Recording) -> dict[str, Any]:
    """Qualify an engine and return what a record says of it; one that fails sets the status to 3.

    Nothing of those that others are held against.
    """
    from harness.cases.qualification import qualify
    from harness.engines.registry import ALWAYS
    from harness.store.entries import tell_stderr

    if engine is None or engine.name in ALWAYS:
        return {}
    told.progress(f"qualification of {engine.name}", 0, 1)
    try:
        reason = qualify(engine, tell=tell_stderr).reason
    except EngineError as error:
        reason = str(error)
    if reason:
        told.status = HarnessError.exit_status
    return {"qualified": not reason, "qualification_failures": reason}
