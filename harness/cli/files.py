"""Files that a command reads and writes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from harness.observables.reference import ReferencePoints

FORMATS = (".svg", ".png", ".pdf")
Writer = Callable[[Path], object]


def check_target(path: Path | None, option: str, suffixes: tuple[str, ...] = ()) -> None:
    """Raise RequestError, before any work is done, for a file that cannot be written."""
    from harness.errors import RequestError

    if path is None:
        return
    if suffixes and path.suffix.lower() not in suffixes:
        raise RequestError(f"{option} {path}: must end in {', '.join(suffixes)}")
    if path.is_dir():
        raise RequestError(f"{option} {path}: is a folder")
    if not path.parent.is_dir():
        raise RequestError(f"{option} {path}: there is no folder {path.parent}")


def write_all(files: Mapping[tuple[str, Path], Writer]) -> None:
    """Write each (option, path) aside, then rename them all: none is half-written.

    Raise RequestError naming the one that fails.
    """
    from harness.errors import RequestError

    asides = {path: path.with_name(f".{path.name}.part") for _, path in files}
    target = ("", Path())
    try:
        for target, writer in files.items():
            writer(asides[target[1]])
        for target in files:
            asides[target[1]].replace(target[1])
    except OSError as error:
        raise RequestError(f"{target[0]} {target[1]}: {error.strerror or error}") from None
    finally:
        for aside in asides.values():
            aside.unlink(missing_ok=True)


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
    """Return the points of ``--reference``; raise RequestError in one line for a bad file."""
    from harness.errors import RequestError
    from harness.observables.reference import parse_reference

    name = f"--reference {path}"
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RequestError(f"{name}: {error.strerror or error}") from None
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
    return replace(parse_reference(text, name), name=path.name)
