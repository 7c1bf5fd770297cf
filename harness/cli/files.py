"""What a command reads, writes and prints: checked paths, whole files, tables, JSON."""

from __future__ import annotations

import contextlib
import itertools
import shutil
import sys
import textwrap
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from harness.cli.command import File, options
from harness.errors import RequestError, cannot_write
from harness.report.plain import json_text, one_line

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from harness.observables.reference import Points, ReferencePoints
    from harness.report.film import Film

GAP = 2
"""Blanks between two columns."""


def print_json(record: Mapping[str, Any]) -> None:
    """Print one JSON object, strict JSON: what is not finite becomes null."""
    print(json_text(record), end="")


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


def print_record(record: Mapping[str, Any]) -> None:
    """Print a flat record as aligned lines, one a key; tables and long lists are left to JSON."""
    short = {key: value for key, value in record.items() if _is_short(value)}
    print_columns(
        [
            (key, f"{value:.8g}" if isinstance(value, float) else str(value))
            for key, value in short.items()
        ]
    )


def print_columns(lines: Sequence[Sequence[str]], right: Collection[str] = ()) -> None:
    """Print aligned columns; those that the first line names in ``right`` end at their right.

    On a terminal that is narrower, cells but the first of a line go on below; a pipe gets whole
    lines.
    """
    lines = [[one_line(cell) for cell in line] for line in lines]
    turns: list[Literal["left", "right"]] = ["right" if n in right else "left" for n in lines[0]]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    if sys.stdout.isatty() and sum(widths) + GAP * (len(widths) - 1) > terminal_width():
        _print_folded(lines, turns)
        return
    marks = ("<" if turn == "left" else ">" for turn in turns)
    form = (GAP * " ").join(f"{{:{m}{w}}}" for m, w in zip(marks, widths, strict=True))
    print("\n".join(form.format(*line).rstrip() for line in lines))


def _print_folded(
    lines: Iterable[Sequence[str]], turns: Sequence[Literal["left", "right"]]
) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, show_header=False, padding=(0, GAP, 0, 0), pad_edge=False)
    for number, turn in enumerate(turns):
        table.add_column(justify=turn, overflow="fold", no_wrap=number == 0)
    for line in lines:
        table.add_row(*line)
    Console(markup=False, highlight=False, emoji=False).print(table)


def print_frame(frame: pd.DataFrame, digits: int) -> None:
    """Print a table, its numbers to so many digits.

    On a terminal that is narrower, columns go on below; a pipe gets whole lines.
    """
    width = terminal_width() if sys.stdout.isatty() else None
    form = f"{{:.{digits}g}}".format
    print(frame.to_string(index=False, float_format=form, na_rep="-", line_width=width))


def print_line(text: str, *, indent: int = 0) -> None:
    """Print text after ``indent`` blanks: wrapped on a terminal, on one line in a pipe."""
    if sys.stdout.isatty():
        print_wrapped(text, indent=indent)
    else:
        print(" " * indent + one_line(text))


def terminal_width() -> int:
    """Return the columns of the terminal; 80 where there is none."""
    return shutil.get_terminal_size().columns


def print_wrapped(text: str, *, indent: int = 0) -> None:
    """Print printable text on lines that fit the terminal, the first after ``indent`` blanks."""
    width = min(terminal_width(), 120)
    lines = textwrap.wrap(
        one_line(text),
        width,
        initial_indent=" " * indent,
        subsequent_indent=" " * (indent + 2),
        break_on_hyphens=False,
    )
    print("\n".join(lines))


def _is_short(value: Any) -> bool:
    if isinstance(value, (list, tuple)):
        return len(value) <= 2 and not any(isinstance(item, Mapping) for item in value)
    return value is not None and value != "" and not isinstance(value, Mapping)


FORMATS = (".svg", ".png", ".pdf")
Writer = Callable[[Path], object]

LARGEST_REFERENCE = 10_000_000
"""Bytes of measured points that are read; a device has no end."""


def check_target(path: Path | None, option: str, suffixes: tuple[str, ...] = ()) -> None:
    """Raise RequestError, before any work is done, for a file that cannot be written."""
    if path is None:
        return
    if suffixes and path.suffix.lower() not in suffixes:
        raise RequestError(f"{option} {path}: must end in {', '.join(suffixes)}")
    if path.exists() and not path.is_file():
        kind = "a folder" if path.is_dir() else "a device, which a new file would replace"
        raise RequestError(f"{option} {path}: is {kind}")
    if not path.parent.is_dir():
        raise RequestError(f"{option} {path}: there is no folder {path.parent}")


def check_source(path: Path | None, option: str, *, folder: bool = False) -> None:
    """Raise RequestError for a file, or a folder, that is not there or may not be read."""
    if path is None:
        return
    try:
        if folder:
            next(path.iterdir(), None)
        else:
            with path.open("rb") as file:
                file.read(1)
    except OSError as error:
        raise RequestError(f"{option} {path}: {error.strerror or error}") from None


@contextlib.contextmanager
def output_folder(named: Path | None, kind: str = "") -> Iterator[Path]:
    """Yield the folder of a report: the one given, or one for now that no other run takes.

    ``kind`` ends the name of the second.

    The second is made at once, so that a run that starts in the same second takes another; it is
    removed again where nothing is written into it. Raise RequestError for one that holds
    something or cannot be made.
    """
    from harness.files import check_folder

    if named is not None:
        check_folder(named)
        yield named
        return
    folder, parents = _new_folder(
        Path("reports") / "runs", f"{datetime.now():%Y-%m-%d-%H%M%S}{kind}"
    )
    try:
        yield folder
    finally:
        # only what is empty goes
        with contextlib.suppress(OSError):
            for path in (folder, *parents):
                path.rmdir()


def _new_folder(parent: Path, name: str) -> tuple[Path, list[Path]]:
    """Return a new folder of this name or a numbered one, and the parents made for it."""
    parents = [path for path in (parent, *parent.parents) if not path.exists()]
    try:
        parent.mkdir(parents=True, exist_ok=True)
        for number in itertools.count(1):
            folder = parent / (name if number == 1 else f"{name}-{number}")
            with contextlib.suppress(FileExistsError):
                folder.mkdir()
                return folder, parents
    except OSError as error:
        raise RequestError(
            f"--output {parent / name}: cannot be made ({error.strerror}); name another folder"
        ) from None
    raise AssertionError("numbers do not end")


def write_all(files: Mapping[tuple[str, Path], Writer]) -> None:
    """Write each (option, path) aside, then rename them all: none is half-written.

    What was written is named on stderr. Raise RequestError naming the one that fails,
    FullDiskError where there is no space.
    """
    from harness.files import held_folder

    target = ("", Path())
    with contextlib.ExitStack() as stack:
        try:
            asides = {}
            for target in files:
                # a folder of its own: two runs may write the same file at once
                folder = stack.enter_context(held_folder(target[1].parent))
                asides[target] = folder / f"file{target[1].suffix}"
            for target, writer in files.items():
                writer(asides[target])
            for target, aside in asides.items():
                aside.replace(target[1])
                print(f"{target[0]}: {target[1]} is written", file=sys.stderr)
        except OSError as error:
            raise cannot_write(f"{target[0]} {target[1]}", error) from None


def save_figure(draw: Callable[[], Figure], suffix: str) -> Writer:
    """Return what writes a figure in the house style; the same figure is the same file."""
    undated = {".svg": {"Date": None}, ".png": {"Software": None}, ".pdf": {"CreationDate": None}}

    def write(path: Path) -> None:
        from harness.report.style import house_style

        with house_style():
            kind = suffix.lower()
            draw().savefig(path, format=kind.removeprefix("."), metadata=undated[kind])

    return write


def read_reference(path: Path) -> ReferencePoints:
    """Return the angles of ``--reference``; raise RequestError in one line for a bad file."""
    from harness.observables.reference import parse_reference

    return replace(parse_reference(*_text_of(path)), name=path.name)


def read_points(path: Path, across: str, up: str, error: str = "") -> Points:
    """Return the points of ``--reference``, two columns, and their errors if it has the third.

    Raise RequestError in a line for a bad file.
    """
    from harness.observables.reference import parse_points

    return replace(parse_points(*_text_of(path), across, up, error), name=path.name)


def _text_of(path: Path) -> tuple[str, str]:
    name = f"--reference {path}"
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_REFERENCE + 1)
    except OSError as error:
        raise RequestError(f"{name}: {error.strerror or error}") from None
    if len(data) > LARGEST_REFERENCE:
        raise RequestError(f"{name}: is longer than {LARGEST_REFERENCE} bytes")
    if data.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in data[:4096]:
        raise RequestError(f"{name}: is UTF-16 or no text at all, UTF-8 is expected")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = data.count(b"\n", 0, error.start) + 1
        byte = data[error.start]
        raise RequestError(
            f"{name}, row {row}: byte 0x{byte:02x} is not UTF-8 (Latin-1 perhaps), "
            "UTF-8 is expected"
        ) from None
    return text, name


@options("Film")
class FilmOptions:
    """A film of the motion, and its length."""

    film: File = None
    """Write a film of the motion to this file: .gif, or .mp4 where ffmpeg is on the path. A .png is
    one picture of it."""
    frames: int | None = None
    """Pictures of the film, 20 a second. [default: 120]"""

    def check(self) -> None:
        """Raise RequestError, before anything is run, for a film that cannot be written."""
        if self.film is None:
            if self.frames is not None:
                raise RequestError(f"--frames {self.frames}: goes with --film only")
            return
        from harness.report.film import check_film

        check_film(self.film, self.pictures, "--film")

    @property
    def pictures(self) -> int:
        """Return the number of pictures."""
        return 120 if self.frames is None else self.frames

    def write(self, make: Callable[[int], Film]) -> None:
        """Write the film that ``make`` returns for a number of pictures, if one is requested."""
        if self.film is not None:
            write_all({("--film", self.film): make(self.pictures).write})
