"""``dem-harness history`` and ``dem-harness cache``: what is kept of earlier runs."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

from cyclopts import Parameter

from harness.cli.command import File, Folder, Json, Name, options
from harness.cli.files import (
    FORMATS,
    check_target,
    print_columns,
    print_json,
    print_json_rows,
    save_figure,
    write_all,
)
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.store.cache import Kept
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


DAY = 86_400.0


@options()
class CacheCommandOptions:
    """Which cache, and what of it is removed."""

    cache: Folder = None
    """The cache. [default: DEM_HARNESS_HOME/cache, else ~/.cache/dem-harness]"""
    clear: bool = False
    """Remove what fits the two options below; all without them."""
    older_than: Annotated[float | None, Parameter(metavar="DAYS")] = None
    """Only what was not used for so many days."""
    case: Name = None
    """Only results of a case that `dem-harness cases` lists."""

    def fitting(self, entries: list[Kept]) -> list[Kept]:
        """Return what fits the options; raise RequestError for an age that is none."""
        from harness.cases.registry import get_case

        if self.older_than is not None and not self.older_than >= 0.0:
            raise RequestError(f"--older-than {self.older_than}: must be 0 days or more")
        if self.case is not None:
            template = get_case(self.case).template.name
            entries = [entry for entry in entries if {self.case, template} & set(entry.cases)]
        if self.older_than is not None:
            newest = time.time() - DAY * self.older_than
            entries = [entry for entry in entries if entry.used <= newest]
        return entries


def cache(choice: CacheCommandOptions = CacheCommandOptions(), *, json: Json = False) -> int:
    """Say what is kept: path, size and cases of the cache; or clear it, by age or case.

    Besides results the cache holds environments of `releases` and compiled kernels. What is
    cleared is computed, installed or compiled again when it is asked for.

    For example:

        dem-harness cache --json
        dem-harness cache --clear --older-than 30
    """
    from harness.files import cache_place
    from harness.store.cache import clear, contents

    folder = cache_place(choice.cache).path
    entries = choice.fitting(contents(folder))
    record: dict[str, Any] = {"cache": str(folder), **_sums(entries)}
    if choice.clear:
        gone = clear(folder, entries)
        record = {"cache": str(folder), "cleared": _sums(gone), **_sums(contents(folder))}
    if json:
        print_json(record)
        return 0
    print(f"{folder}: {_size_text(record)}")
    for sort, part in record["sorts"].items():
        print(f"  {sort}: {_size_text(part)}")
    for case, part in record["cases"].items():
        print(f"  of case {case}: {_size_text(part)}")
    if choice.clear:
        print(f"cleared: {_size_text(record['cleared'])}")
    return 0


def _sums(entries: list[Kept]) -> dict[str, Any]:
    sorts = sorted({entry.sort for entry in entries})
    cases = sorted({case for entry in entries for case in entry.cases})
    return {
        **_sum(entries),
        "sorts": {sort: _sum([entry for entry in entries if entry.sort == sort]) for sort in sorts},
        "cases": {
            case: _sum([entry for entry in entries if case in entry.cases]) for case in cases
        },
    }


def _sum(entries: list[Kept]) -> dict[str, int]:
    return {"count": len(entries), "size_bytes": sum(entry.size for entry in entries)}


def _size_text(part: dict[str, Any]) -> str:
    return f"{part['count']} kept, {part['size_bytes'] / 1e6:.1f} MB"
