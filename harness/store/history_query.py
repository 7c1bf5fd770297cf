"""Ask the history: which runs, and which quantities of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from harness.store.history import History

RUN_COLUMNS = (
    "run.id AS run, started, finished, command, options, engine, engine_version, how, status,"
    " seconds, cached, judged, failed, folder, harness_version, harness_commit, platform, note"
)
QUANTITY_COLUMNS = "name, kind, unit, value, uncertainty, expected, tolerance, verdict, triage"


@dataclass(frozen=True)
class HistoryQuery:
    """What to look for; None asks for nothing. ``limit`` keeps the newest.

    ``quantity`` is a pattern as in file names (``angle*``), ``engine_version``
    the beginning of one, ``since`` a time with its zone, ``status`` an exit
    status or ``unfinished``.
    """

    command: str | None = None
    engine: str | None = None
    engine_version: str | None = None
    quantity: str | None = None
    since: datetime | None = None
    verdict: str | None = None
    status: str | None = None
    limit: int | None = None


def runs(history: History, question: HistoryQuery) -> Iterator[dict[str, Any]]:
    """Yield the runs that fit, newest first, one row each.

    With a quantity or a verdict, those that have such a one.
    """
    where, values = _of_run(question)
    inner, more = _of_quantity(question)
    if inner:
        where.append(
            "id IN (SELECT run FROM measurement JOIN quantity ON quantity.id = quantity"
            f" WHERE {' AND '.join(inner)})"
        )
    query = f"SELECT {RUN_COLUMNS} FROM run{_where(where)} ORDER BY started DESC, id DESC"
    return history.each(query + _limit(question), [*values, *more])


def quantities(history: History, question: HistoryQuery) -> Iterator[dict[str, Any]]:
    """Yield the quantities that fit with the columns of their runs, newest first."""
    where, values = _of_run(question)
    inner, more = _of_quantity(question)
    query = (
        f"SELECT {RUN_COLUMNS}, {QUANTITY_COLUMNS} FROM measurement"
        " JOIN quantity ON quantity.id = quantity JOIN run ON run.id = measurement.run"
        f"{_where([*where, *inner])}"
        " ORDER BY started DESC, run.id DESC, quantity.id"
    )
    return history.each(query + _limit(question), [*values, *more])


def names(history: History) -> list[str]:
    """Return the names of all quantities ever recorded, sorted."""
    return [row["name"] for row in history.rows("SELECT DISTINCT name FROM quantity ORDER BY name")]


def _of_run(question: HistoryQuery) -> tuple[list[str], list[Any]]:
    where, values = [], []
    for column in ("command", "engine"):
        if getattr(question, column) is not None:
            where.append(f"{column} = ?")
            values.append(getattr(question, column))
    if question.engine_version is not None:
        where.append("substr(engine_version, 1, length(?)) = ?")
        values += [question.engine_version] * 2
    if question.since is not None:
        where.append("started >= ?")
        values.append(question.since.astimezone(UTC).isoformat(timespec="milliseconds"))
    if question.status == "unfinished":
        where.append("status IS NULL")
    elif question.status is not None:
        where.append("status = ?")
        values.append(int(question.status))
    return where, values


def _of_quantity(question: HistoryQuery) -> tuple[list[str], list[Any]]:
    where, values = [], []
    if question.quantity is not None:
        where.append("quantity.name GLOB ?")
        values.append(question.quantity)
    if question.verdict is not None:
        where.append("verdict = ?")
        values.append(question.verdict)
    return where, values


def _where(conditions: list[str]) -> str:
    return f" WHERE {' AND '.join(conditions)}" if conditions else ""


def _limit(question: HistoryQuery) -> str:
    return f" LIMIT {int(question.limit)}" if question.limit is not None else ""
