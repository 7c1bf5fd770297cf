"""What a command prints and writes: JSON or lines, tables, checked paths, whole files."""

from __future__ import annotations

import json
import math
import shutil
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.errors import RequestError
from harness.report.content import one_line

if TYPE_CHECKING:
    import pandas as pd

    from harness.files import Writer

WIDEST = 120  # columns of wrapped text
MOST_ITEMS = 20  # of a list that a terminal shows; JSON has all
MOST_ROWS = 40  # of a table that a terminal shows
RUNS = Path("reports/runs")


def tell(note: str) -> None:
    """Print a note on stderr."""
    print(f"dem-harness: {one_line(note)}", file=sys.stderr)


def show(record: Mapping[str, Any], as_json: bool, text: Mapping[str, Any] | None = None) -> int:
    """Print a record as one strict JSON object, or a line for each value; return its status.

    ``text`` is printed in place of the record where it is no JSON. A mapping in it is a table: of
    values, or of mappings with the same keys; a list of mappings is in JSON alone.
    """
    if as_json:
        print(json.dumps(_plain(record), indent=2))
        return int(record.get("status", 0))
    for name, value in (record if text is None else text).items():
        if isinstance(value, Mapping) and value:
            print(f"\n{name.replace('_', ' ')}")
            print_columns(_lines(value))
        elif cell := _cell(value):
            print_wrapped(f"{name}: {cell}")
    return int(record.get("status", 0))


def print_columns(lines: Sequence[Sequence[str]]) -> None:
    """Print aligned columns."""
    rows = [[one_line(cell) for cell in line] for line in lines]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(map(str.ljust, row, widths)).rstrip())


def print_frame(frame: pd.DataFrame, most: int = MOST_ROWS, rest: str = "--json has all") -> None:
    """Print the first rows of a table, its numbers to seven digits, and where the others are."""
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    form = "{:.7g}".format
    first = frame.head(most)
    print(first.to_string(index=False, float_format=form, na_rep="-", line_width=width))
    if len(frame) > most:
        print(f"... {len(frame) - most} more: {rest}")


def print_wrapped(text: str, *, indent: int = 0) -> None:
    """Print text on lines that fit the terminal, the first after ``indent`` blanks."""
    width = min(shutil.get_terminal_size().columns, WIDEST)
    first, others = " " * indent, " " * (indent + 2)
    print(textwrap.fill(one_line(text), width, initial_indent=first, subsequent_indent=others,
                        break_on_hyphens=False))  # fmt: skip


def check_target(
    path: Path | None, option: str, suffixes: tuple[str, ...] = (), *, other: Path | None = None
) -> None:
    """Raise RequestError, before any work is done, for a file that cannot be written, or twice."""
    if path is None:
        return
    if other is not None and path.resolve() == other.resolve():
        raise RequestError(f"{option} {path}: is written by another option already")
    if suffixes and path.suffix.lower() not in suffixes:
        raise RequestError(f"{option} {path}: must end in {', '.join(suffixes)}")
    try:
        taken, has_parent = path.exists() and not path.is_file(), path.parent.is_dir()
    except (OSError, ValueError) as error:
        raise RequestError(f"{option} {path!s:.200}: {error}") from None
    if taken:
        raise RequestError(f"{option} {path}: is a folder or a device")
    if not has_parent:
        raise RequestError(f"{option} {path}: there is no folder {path.parent}")


def write_all(files: Mapping[tuple[str, Path | None], Writer]) -> None:
    """Write each (option, path) that is given, all of them whole; see :func:`write_files`."""
    from harness.files import write_files

    named = {(option, path): write for (option, path), write in files.items() if path is not None}
    write_files(named)
    for option, path in named:
        tell(f"{option} {path}: is written")


@contextmanager
def output_folder(named: Path | None, ending: str = "") -> Iterator[Path]:
    """Yield the folder of a report: the named one, or a new one of the date below reports/runs.

    The new one is made at once, for no other command to take it, and goes again where it stays
    empty. Raise RequestError for one that has files or cannot be made.
    """
    from harness.files import check_folder

    if named is not None:
        check_folder(named)
        yield named
        return
    missing = [path for path in (RUNS, *RUNS.parents) if not path.exists()]
    name = f"{datetime.now():%Y-%m-%d-%H%M%S}{ending}"
    names = chain([name], (f"{name}-{number}" for number in count(2)))
    folder = next(path for path in map(RUNS.joinpath, names) if _is_made(path))
    try:
        yield folder
    finally:
        with suppress(OSError):  # what is empty goes
            for path in (folder, *missing):
                path.rmdir()


def _is_made(folder: Path) -> bool:
    """Make a folder; return whether it is new, and raise RequestError where it cannot be made."""
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        return False
    except OSError as error:
        raise RequestError(f"--output {folder}: cannot be written ({error.strerror})") from None
    return True


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: null for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "item") and not isinstance(value, str):  # a number of numpy
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def _lines(table: Mapping[str, Any]) -> list[list[str]]:
    """Return the lines of a table, below the names of its columns where it has several."""
    first = next(iter(table.values()))
    if not isinstance(first, Mapping):
        return [[name, _cell(value)] for name, value in table.items()]
    return [["name", *first], *([name, *map(_cell, row.values())] for name, row in table.items())]


def _cell(value: Any) -> str:
    """Return a value, or values in a list or by name, as text; empty for a list of mappings."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name}={_cell(item)}" for name, item in value.items())
    items = value if isinstance(value, list | tuple) else [value]
    if value is None or any(isinstance(item, Mapping) for item in items):
        return ""
    texts = [f"{item:.8g}" if isinstance(item, float) else str(item) for item in items]
    more = f" ... ({len(texts)} in all)" if len(texts) > MOST_ITEMS else ""
    return " ".join(texts[:MOST_ITEMS]) + more
