"""What a command reads, writes and prints: checked paths, whole files, tables, JSON."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import shutil
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from harness.errors import RequestError

if TYPE_CHECKING:
    import pandas as pd

    from harness.files import Writer

GAP = 2  # blanks between two columns
WIDEST = 120  # columns of wrapped text
MOST_ITEMS = 20  # of a list that a terminal shows; JSON has all
MOST_ROWS = 40  # of a table that a terminal shows
FORMULA = tuple("=+-@")  # first characters of what a spreadsheet takes for a formula


class Result(Protocol):
    """What a command prints."""

    def summary(self) -> Mapping[str, str]:
        """Return the main values as text, by name."""

    def to_json(self) -> Mapping[str, Any]:
        """Return the result as a JSON-ready mapping."""


def tell(note: str) -> None:
    """Print a note on stderr."""
    print(f"dem-harness: {one_line(note)}", file=sys.stderr)


@contextlib.contextmanager
def closed_pipe_allowed() -> Iterator[None]:
    """Go on where the reader of stdout has seen enough: the exit status is still to come."""
    try:
        yield
    except BrokenPipeError:
        pass
    except SystemExit as ending:  # as rich ends then
        if not isinstance(ending.__context__, BrokenPipeError):
            raise


def print_json(record: Mapping[str, Any]) -> None:
    """Print one JSON object: strict JSON, null for what is not finite."""
    print(json.dumps(_plain(record), indent=2))


def print_record(record: Mapping[str, Any]) -> None:
    """Print a flat record as aligned lines; tables are left to JSON."""
    lines = [(name, _cell(value)) for name, value in record.items() if _is_flat(value)]
    print_columns(lines)


def print_columns(lines: Sequence[Sequence[str]]) -> None:
    """Print aligned columns; on a terminal that is narrower the last one goes on below."""
    rows = [[one_line(cell) for cell in line] for line in lines]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    indent = sum(widths[:-1]) + GAP * (len(widths) - 1)
    for row in rows:
        text = (GAP * " ").join(map(str.ljust, row, widths)).rstrip()
        if sys.stdout.isatty() and len(text) > terminal_width() > indent + 20:
            last = textwrap.wrap(row[-1], terminal_width() - indent) or [""]
            text = f"\n{' ' * indent}".join([text[:indent] + last[0], *last[1:]])
        print(text)


def print_frame(frame: pd.DataFrame, most: int = MOST_ROWS, rest: str = "--json has all") -> None:
    """Print the first rows of a table, its numbers to seven digits, and where the others are."""
    width = terminal_width() if sys.stdout.isatty() else None
    form = "{:.7g}".format
    first = frame.head(most)
    print(first.to_string(index=False, float_format=form, na_rep="-", line_width=width))
    if len(frame) > most:
        print(f"... {len(frame) - most} more: {rest}")


def show(found: Result, json: bool, **more: Any) -> None:
    """Print one JSON object, with ``more`` keys; or the summary of a result, a line each."""
    if json:
        print_json({**found.to_json(), **more})
        return
    for name, text in found.summary().items():
        print_wrapped(f"{name}: {text}")


def print_wrapped(text: str, *, indent: int = 0) -> None:
    """Print text on lines that fit the terminal, the first after ``indent`` blanks."""
    width = min(terminal_width(), WIDEST)
    first, others = " " * indent, " " * (indent + 2)
    lines = textwrap.wrap(one_line(text), width, initial_indent=first, subsequent_indent=others,
                          break_on_hyphens=False)  # fmt: skip
    print("\n".join(lines))


def terminal_width() -> int:
    """Return the columns of the terminal; 80 without one."""
    return shutil.get_terminal_size().columns


def one_line(text: str) -> str:
    """Return printable text on one line."""
    return " ".join(printable(text).split())


def printable(text: str) -> str:
    """Return text without the control characters that would change a terminal."""
    return "".join(c if c.isprintable() or c in "\n\t" else "?" for c in str(text))


def short(value: Any) -> str:
    """Return a value for a table: numbers to eight digits."""
    return "none" if value is None else f"{value:.8g}" if isinstance(value, float) else str(value)


def check_target(path: Path | None, option: str, suffixes: tuple[str, ...] = ()) -> None:
    """Raise RequestError, before any work is done, for a file that cannot be written."""
    if path is None:
        return
    if suffixes and path.suffix.lower() not in suffixes:
        raise RequestError(f"{option} {path}: must end in {', '.join(suffixes)}")
    try:
        taken, has_parent = path.exists() and not path.is_file(), path.parent.is_dir()
        kind = "a folder" if path.is_dir() else "a device, which a new file would replace"
    except (OSError, ValueError) as error:
        raise RequestError(f"{option} {path!s:.200}: {error}") from None
    if taken:
        raise RequestError(f"{option} {path}: is {kind}")
    if not has_parent:
        raise RequestError(f"{option} {path}: there is no folder {path.parent}")


def write_all(files: Mapping[tuple[str, Path | None], Writer]) -> None:
    """Write each (option, path) that is given, all of them whole; see :func:`write_files`."""
    from harness.files import write_files

    given = {(option, path): write for (option, path), write in files.items() if path is not None}
    write_files(given)
    for option, path in given:
        tell(f"{option} {path}: is written")


def write_csv(frame: pd.DataFrame, path: Path) -> None:
    """Write a table with all digits; text that a spreadsheet would compute gets an apostrophe."""
    texts = {
        name: [f"'{v}" if isinstance(v, str) and v[:1] in FORMULA else v for v in frame[name]]
        for name in frame.select_dtypes(exclude="number")
    }
    frame.assign(**{str(name): column for name, column in texts.items()}).to_csv(path, index=False)


@contextlib.contextmanager
def output_folder(named: Path | None, ending: str = "") -> Iterator[Path]:
    """Yield the folder of a report: the named one, or a new one of the date below reports/runs.

    It is removed again where nothing is written into it. Raise RequestError for one that holds
    something or cannot be made.
    """
    from harness.files import check_folder

    if named is not None:
        check_folder(named)
        yield named
        return
    parent = Path("reports") / "runs"
    made = [path for path in (parent, *parent.parents) if not path.exists()]
    folder = _new_folder(parent, f"{datetime.now():%Y-%m-%d-%H%M%S}{ending}")
    try:
        yield folder
    finally:
        with contextlib.suppress(OSError):  # what is empty goes
            for path in (folder, *made):
                path.rmdir()


def _new_folder(parent: Path, name: str) -> Path:
    try:
        parent.mkdir(parents=True, exist_ok=True)
        for number in itertools.count(1):
            folder = parent / (name if number == 1 else f"{name}-{number}")
            with contextlib.suppress(FileExistsError):
                folder.mkdir()
                return folder
    except OSError as error:
        raise RequestError(
            f"--output {parent / name}: cannot be made ({error.strerror}); name another folder"
        ) from None
    raise AssertionError("numbers do not end")


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "item") and not isinstance(value, str):  # a number of numpy
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)


def _is_flat(value: Any) -> bool:
    is_list = isinstance(value, list | tuple)
    nested = isinstance(value, Mapping) or (is_list and any(isinstance(x, Mapping) for x in value))
    return not nested and value is not None and value != ""


def _cell(value: Any) -> str:
    if isinstance(value, list | tuple):
        more = f" ... ({len(value)} in all)" if len(value) > MOST_ITEMS else ""
        return " ".join(map(short, value[:MOST_ITEMS])) + more
    return short(value)
