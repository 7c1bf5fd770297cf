"""Files that a command reads and writes."""

from __future__ import annotations

import contextlib
import itertools
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from harness.errors import RequestError, cannot_write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from harness.observables.reference import Points, ReferencePoints

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
        what = "a folder" if path.is_dir() else "a device, which a new file would replace"
        raise RequestError(f"{option} {path}: is {what}")
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
def output_folder(given: Path | None, kind: str = "") -> Iterator[Path]:
    """Yield the folder of a report: the one given, or one for now that no other run takes.

    ``kind`` ends the name of the second.

    The second is made at once, so that a run that starts in the same second takes another; it is
    removed again where nothing is written into it. Raise RequestError for one that holds
    something or cannot be made.
    """
    from harness.report.target import check_folder

    if given is not None:
        check_folder(given)
        yield given
        return
    folder, made = _new_folder(Path("reports") / "runs", f"{datetime.now():%Y-%m-%d-%H%M%S}{kind}")
    try:
        yield folder
    finally:
        # only what is empty goes
        with contextlib.suppress(OSError):
            for path in (folder, *made):
                path.rmdir()


def _new_folder(parent: Path, name: str) -> tuple[Path, list[Path]]:
    """Return a new folder of this name or a numbered one, and the parents made for it."""
    made = [path for path in (parent, *parent.parents) if not path.exists()]
    try:
        parent.mkdir(parents=True, exist_ok=True)
        for number in itertools.count(1):
            folder = parent / (name if number == 1 else f"{name}-{number}")
            with contextlib.suppress(FileExistsError):
                folder.mkdir()
                return folder, made
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
    from harness.atomic_write import held_folder

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
        from harness.report.figures.style import house_style

        with house_style():
            kind = suffix.lower()
            draw().savefig(path, format=kind.removeprefix("."), metadata=undated[kind])

    return write


def read_reference(path: Path) -> ReferencePoints:
    """Return the angles of ``--reference``; raise RequestError in one line for a bad file."""
    from harness.observables.reference import parse_reference

    return replace(parse_reference(*_text_of(path)), name=path.name)


def read_points(path: Path, across: str, up: str) -> Points:
    """Return the points of ``--reference``, two columns; RequestError in a line for a bad file."""
    from harness.observables.reference import parse_points

    return replace(parse_points(*_text_of(path), across, up), name=path.name)


def _text_of(path: Path) -> tuple[str, str]:
    """Return the text of the file of ``--reference``, and what it is called in an error."""
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
