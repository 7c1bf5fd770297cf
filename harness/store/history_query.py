"""Query the history for runs, and for quantities of runs."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any, TypedDict

from harness.store.history import History

RUN_COLUMNS = (
    "run.id AS run, started, finished, command, options, engine, engine_version, how, status,"
    " seconds, cached, judged, failed, folder, harness_version, harness_commit, platform, note"
)
QUANTITY_COLUMNS = "name, kind, unit, value, uncertainty, expected, tolerance, verdict, triage"


class HistoryQuery(TypedDict, total=False):
    """What is asked of the history; None asks for nothing.

    ``quantity`` is a pattern as in file names (``*``, ``?``), ``engine_version``
    the beginning of a release, ``since`` a date or time (ISO 8601, local unless
    it has a zone), ``status`` an exit status or ``unfinished``. ``limit`` keeps
    the newest.
    """

    command: str | None
    engine: str | None
    engine_version: str | None
    quantity: str | None
    since: datetime | str | None
    verdict: str | None
    status: int | str | None
    limit: int | None


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
    where: list[str] = []
    values: list[Any] = []
    for column in ("command", "engine"):
        if question.get(column) is not None:
            where.append(f"{column} = ?")
            values.append(question[column])
    if (version := question.get("engine_version")) is not None:
        where.append("substr(engine_version, 1, length(?)) = ?")
        values += [version] * 2
    if (since := question.get("since")) is not None:
        assert isinstance(since, datetime)
        where.append("started >= ?")
        values.append(since.astimezone(UTC).isoformat(timespec="milliseconds"))
    if (status := question.get("status")) == "unfinished":
        where.append("status IS NULL")
    elif status is not None:
        where.append("status = ?")
        values.append(int(status))
    return where, values


def _of_quantity(question: HistoryQuery) -> tuple[list[str], list[Any]]:
    asked = {
        "quantity.name GLOB ?": question.get("quantity"),
        "verdict = ?": question.get("verdict"),
    }
    given = {condition: value for condition, value in asked.items() if value is not None}
    return list(given), list(given.values())


def _where(conditions: list[str]) -> str:
    return f" WHERE {' AND '.join(conditions)}" if conditions else ""


def _limit(question: HistoryQuery) -> str:
    limit = question.get("limit")
    return "" if limit is None else f" LIMIT {int(limit)}"
