"""What a command prints and writes: one JSON object, or facts and tables; checked, whole files."""

from __future__ import annotations

import json
import math
import shutil
import sys
import textwrap
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from itertools import chain, count
from pathlib import Path
from typing import Any

from harness.errors import RequestError
from harness.files import Writer, check_folder, write_files
from harness.report.content import one_line
from harness.results.rows import KEY, row_name

Record = Mapping[str, Any]
WIDEST = 120  # columns of wrapped text
MOST = 50  # rows of a table, or items of a list, that are printed; JSON has all
RUNS = Path("reports/runs")


# ---- what is printed


def tell(note: str) -> None:
    """Print a note on stderr."""
    print(f"dem-harness: {one_line(note)}", file=sys.stderr)


def show(record: Record, as_json: bool, text: Record | None = None, most: int = MOST) -> int:
    """Print a record as one strict JSON object, or its values by name; return its status.

    ``text`` is printed in place of the record where it is no JSON. A mapping and a list of mappings
    are tables, of which the first ``most`` rows are shown; each sentence of a list has its line.
    """
    if as_json:
        print(json.dumps(_plain(record), indent=2))
        return int(record.get("status", 0))
    for name, value in (record if text is None else text).items():
        if rows := _table_rows(value):
            print(f"\n{name}")
            _print_table(rows[:most])
        texts = [] if rows else _texts(value)
        for line in texts[:most]:
            width = min(shutil.get_terminal_size().columns, WIDEST)
            print(textwrap.fill(one_line(f"{name}: {line}"), width, subsequent_indent="  ",
                                break_on_hyphens=False))  # fmt: skip
        if (more := max(len(rows), len(texts)) - most) > 0:
            print(f"... {more} more: --json has all")
    return int(record.get("status", 0))


def row_details(row: Record) -> Iterator[str]:
    """Yield numbers, class of failure and note of a row of a verification, a line each."""
    if row["value"] is not None:
        text = f"{row['value']:.8g}"
        if row["expected"] is not None:
            text += f", expected {row['expected']:.8g}"
        text = f"{text} {row['unit'] if row['unit'] != '1' else ''}".rstrip()
        if row["difference"] is not None and row["tolerance"] is not None:
            text += f"; difference {row['difference']:.2g}, tolerance {row['tolerance']:.2g}"
        yield text
    yield from filter(None, (row["failure"], row["note"]))


def name_of(row: Record) -> str:
    """Return the name of a row for people."""
    return row_name(*(row[name] for name in KEY))


def picked(records: Any, columns: Any) -> list[dict[str, Any]]:
    """Return these columns of the records that have them."""
    return [{name: row[name] for name in columns if name in row} for row in records]


def _table_rows(value: Any) -> list[Record]:
    if isinstance(value, Mapping):
        return [{"name": name, **(item if isinstance(item, Mapping) else {"value": item})}
                for name, item in value.items()]  # fmt: skip
    is_table = isinstance(value, list) and all(isinstance(item, Mapping) for item in value)
    return value if is_table else []


def _print_table(rows: list[Record]) -> None:
    names = dict.fromkeys(name for row in rows for name in row)
    columns = [[name, *(_cell(row.get(name)) for row in rows)] for name in names]
    columns = [column for column in columns if any(column[1:])]  # those that have any text
    widths = [max(map(len, column)) for column in columns]
    for line in zip(*columns, strict=True):
        print("  ".join(map(str.ljust, line, widths)).rstrip())


def _texts(value: Any) -> list[str]:
    is_list = isinstance(value, list | tuple) and any(" " in str(item) for item in value)
    return [text for item in (value if is_list else [value]) if (text := _cell(item))]


def _cell(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name}={_cell(item)}" for name, item in value.items())
    if isinstance(value, list | tuple):
        return " ".join(map(_cell, value))
    if value is None:
        return ""
    return f"{value:.8g}" if isinstance(value, float) else one_line(str(value))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "item") and not isinstance(value, str):  # a number of numpy
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None  # JSON has no other numbers
    return value if value is None or isinstance(value, bool | int | str) else str(value)


# ---- what is written


def check_target(
    path: Path | None, option: str, suffixes: tuple[str, ...] = (), *others: Path | None
) -> None:
    """Raise RequestError, before any work is done, for a file that cannot be written.

    Likewise for one that another option reads or writes: ``others`` are theirs.
    """
    if path is None:
        return
    problem = ""
    try:
        if path.resolve() in [other.resolve() for other in others if other is not None]:
            problem = "is the file of another option already"
        elif suffixes and path.suffix.lower() not in suffixes:
            problem = f"must end in {', '.join(suffixes)}"
        elif path.exists() and not path.is_file():
            problem = "is a folder or a device"
        elif not path.parent.is_dir():
            problem = f"there is no folder {path.parent}"
    except (OSError, ValueError) as error:
        problem = str(error)
    if problem:
        raise RequestError(f"{option} {path!s:.200}: {problem}")


def write_all(files: Mapping[tuple[str, Path | None], Writer]) -> None:
    """Write each (option, path) that is given, all of them whole; see :func:`write_files`."""
    named = {(option, path): write for (option, path), write in files.items() if path is not None}
    write_files(named)
    for option, path in named:
        tell(f"{option} {path}: is written")


@contextmanager
def output_folder(named: Path | None, ending: str = "") -> Iterator[Path]:
    """Yield the folder of a report: the named one, or a new one of the date below reports/runs.

    The new one goes again where it stays empty. Raise RequestError for one that has files or cannot
    be made.
    """
    if named is not None:
        check_folder(named)
        yield named
        return
    missing = [path for path in (RUNS, *RUNS.parents) if not path.exists()]
    folder = _new_numbered_folder(RUNS / f"{datetime.now():%Y-%m-%d-%H%M%S}{ending}")
    try:
        yield folder
    finally:
        with suppress(OSError):  # what is empty goes
            for path in (folder, *missing):
                path.rmdir()


def _new_numbered_folder(folder: Path) -> Path:
    for path in chain([folder], (Path(f"{folder}-{number}") for number in count(2))):
        try:
            path.mkdir(parents=True)
            break
        except FileExistsError:
            continue
        except OSError as error:
            raise RequestError(f"--output {path}: cannot be written ({error.strerror})") from None
    return path
