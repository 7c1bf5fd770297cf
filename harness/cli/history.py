"""``dem-harness history``."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

from cyclopts import Parameter

from harness.cli.command import File, Json, options
from harness.cli.files import (
    FORMATS,
    check_target,
    print_columns,
    print_json_rows,
    save_figure,
    write_all,
)
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.store.history import HistoryQuery
    from harness.workflows.history_search import HistoryAnswer

SHOWN = 30
LONGEST = 56
"""Characters of a command in the list."""


@options("Look for")
class SearchOptions:
    """Which runs are looked for, and whether their quantities are listed."""

    command: str | None = None
    """Runs of this command."""
    engine: str | None = None
    """Runs of this engine or solver."""
    engine_version: str | None = None
    """A release, or how it begins: "22 Jul 2025"."""
    quantity: Annotated[str | None, Parameter(metavar="PATTERN")] = None
    """List these quantities of the runs, as `incline*`; `*` is all of them."""
    since: Annotated[str | None, Parameter(metavar="DATE")] = None
    """From this date or time on, as 2025-07-22."""
    verdict: str | None = None
    """`pass`, `fail`, `known defect`, `fixed`, `not tested` or `finding`."""
    status: str | None = None
    """Exit status, or `unfinished`: still running, or killed."""
    limit: int | None = None
    """The newest so many. [default: 30 in the list, all elsewhere]"""

    def find(self, limit: int | None) -> HistoryAnswer:
        """Return what the history holds; ``limit`` counts where none was given."""
        from harness.workflows import history as ask

        wanted = self.wanted
        wanted.setdefault("limit", limit)
        return ask(**wanted)

    @property
    def wanted(self) -> HistoryQuery:
        """Return the query of the history."""
        return cast("HistoryQuery", {k: v for k, v in vars(self).items() if v is not None})


@options("Draw and export")
class ExportOptions:
    """Where what was found is drawn and written."""

    plot: File = None
    """Draw the one --quantity: .svg, .png or .pdf."""
    against: Literal["date", "version"] = "date"
    """What to draw it against."""
    csv: File = None
    """Write the rows here."""


def history(
    search: SearchOptions = SearchOptions(),
    files: ExportOptions = ExportOptions(),
    *,
    json: Json = False,
) -> int:
    """List the recorded runs, or how a quantity went over date or release.

    Every verify, critical-angle, tower and impulse is recorded when it starts
    and when it ends, in DEM_HARNESS_HOME/history.sqlite, else
    ~/.local/share/dem-harness/history.sqlite.

    For example:

        dem-harness history --command verify --limit 5
        dem-harness history --quantity 'critical angle*' --plot angle.svg --against version
    """
    from harness.workflows.history_search import open_history, write_csv

    plot, csv, quantity = files.plot, files.csv, search.quantity
    check_target(plot, "--plot", FORMATS)
    check_target(csv, "--csv")
    if plot is not None and quantity is None:
        raise RequestError("--plot: needs --quantity, the name of what to draw")
    writers: dict[tuple[str, Path], Any] = {}
    if csv is not None:
        writers["--csv", csv] = partial(write_csv, **search.wanted)
    if plot is not None:
        runs = search.find(None)
        drawn = runs.plot(files.against)
        writers["--plot", plot] = save_figure(lambda: drawn, plot.suffix)
    write_all(writers)
    if json:
        with open_history(**search.wanted) as (file, rows):
            name = "runs" if quantity is None else "quantities"
            print_json_rows({"history": str(file)}, name, rows)
    elif not writers:
        _print(search.find(SHOWN))
    return 0


def _print(runs: HistoryAnswer) -> None:
    if not runs.rows:
        none = (
            f"no run is recorded yet: {runs.file} is written by the first verify, tower and so on"
        )
        print(f"no such run in {runs.file}" if runs.file.is_file() else none)
        return
    oldest_first = sorted(runs.rows, key=lambda row: (row["started"], row["run"]))
    if runs.quantities is None:
        head: tuple[str, ...] = ("started", "command", "engine", "status", "verdicts", "took")
        lines = [_run(row) for row in oldest_first]
    else:
        head = ("started", "release", "quantity", "value", "expected", "tolerance", "", "verdict")
        lines = [_quantity(row) for row in oldest_first]
    print_columns([head, *lines], right={"value", "expected", "tolerance", "took"})


def _run(row: Mapping[str, Any]) -> tuple[str, ...]:
    verdicts = f"{row['judged'] - row['failed']} of {row['judged']}" if row["judged"] else ""
    took = "" if row["seconds"] is None else f"{row['seconds']:.1f} s"
    return (
        _when(row),
        _cut(f"{row['command']} {row['options']}"),
        ", ".join(part for part in (row["engine"], row["engine_version"], row["how"]) if part),
        "unfinished" if row["status"] is None else str(row["status"]),
        verdicts,
        f"cached, {took}" if row["cached"] else took,
    )


def _quantity(row: Mapping[str, Any]) -> tuple[str, ...]:
    value = _number(row["value"], 8)
    if row["uncertainty"]:
        value += f" ± {row['uncertainty']:.2g}"
    return (
        _when(row),
        (row["engine_version"] or row["engine"]) + (", cached" if row["cached"] else ""),
        row["name"],
        value,
        _number(row["expected"], 8),
        _number(row["tolerance"], 2),
        row["unit"],
        row["verdict"],
    )


def _cut(text: str) -> str:
    """Return a text cut to the width that the other columns leave; JSON has it in full."""
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}g}"


def _when(row: Mapping[str, Any]) -> str:
    from datetime import datetime

    return datetime.fromisoformat(row["started"]).astimezone().isoformat(" ")[:19]
