"""The cache folder, complete files and folders, and what killed processes leave behind.

A folder is filled under another name and renamed, so that it is complete or not there, also after
kill -9; the shared memory of MPI libraries is cleared, and a worker process ends with the one that
started it.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import re
import shutil
import stat
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from harness.errors import FULL, FullDiskError, RequestError

Writer = Callable[[Path], object]

# ---- worker processes, and the shared memory of MPI libraries

LOOK_SECONDS = 1.0  # between two looks at the parent
SHARED = Path("/dev/shm")
NEEDED = 6 * 1024**2  # [bytes] of a process: MPICH touches 1.0 MiB, UCX below it 4.1 MiB
_SEGMENT = re.compile(r"mpich_shm_[0-9a-f]+_\d+")


def end_with(parent: int, clear: Callable[[], object] = lambda: None) -> None:
    """Exit once ``parent``, a process number, is no longer this process's parent.

    A thread looks for it: a worker in compiled code, or one that waits for a pipe that other
    workers hold open, would not notice a SIGKILL of the parent. ``clear`` runs before the exit.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_SECONDS)
        clear()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def processes_with_room() -> int | None:
    """Return how many MPI processes shared memory has room for, at least 1; None if unknown."""
    try:
        return max(1, shutil.disk_usage(SHARED).free // NEEDED)
    except OSError:
        return None


def advice() -> str:
    """Return the size of the shared memory and what helps where a process died for want of it."""
    try:
        room = shutil.disk_usage(SHARED)
    except OSError:
        return "shared memory is short: take fewer workers"
    return (
        f"{SHARED} holds {room.total / 1e6:.0f} MB, {room.free / 1e6:.0f} MB of it free, and a "
        f"process takes up to {NEEDED / 1e6:.0f} MB: take fewer workers "
        "(--engine-option NAME.workers=N), or a larger one (docker run --shm-size=1g)"
    )


def remove_segments() -> None:
    """Unlink this user's segments of MPICH that no process has open or mapped.

    MPICH unlinks them in MPI_Finalize alone: a program that is killed or crashes leaves them. A
    process that makes one has it open until it is mapped: files are read first, then maps.
    """
    segments: dict[str, Path] = {}
    with contextlib.suppress(OSError):
        for path in SHARED.iterdir():
            if _SEGMENT.fullmatch(path.name) and path.lstat().st_uid == os.geteuid():
                segments[path.name] = path
    for process in Path("/proc").glob("[0-9]*") if segments else ():
        with contextlib.suppress(OSError):  # another user's, or gone by now
            for handle in (process / "fd").iterdir():
                with contextlib.suppress(OSError):  # closed by now
                    segments.pop(handle.readlink().name, None)
            for name in _SEGMENT.findall((process / "maps").read_text("utf-8", errors="replace")):
                segments.pop(name, None)
    for path in segments.values():
        path.unlink(missing_ok=True)


# ---- the cache folder
#
# It has results, environments of engines' releases (releases) and compiled kernels (numba).

VARIABLE = "DEM_HARNESS_HOME"
NAME = "dem-harness"
KERNELS = "numba"  # folder of the cache for compiled kernels
GROUP, OTHERS = stat.S_IWGRP, stat.S_IWOTH
PACKAGE, COPIES = Path(__file__).parent, "store/committed"


class Place(NamedTuple):
    """A folder, and the option or variable that named it; empty for the default one."""

    path: Path
    named_by: str = ""


def cache_place(option: Path | None = None) -> Place:
    """Return the cache folder: ``option``, else that below DEM_HARNESS_HOME, else that of XDG.

    The XDG base directory specification ignores relative values.
    """
    if option is not None:
        return Place(option, "--cache")
    if named := os.environ.get(VARIABLE):
        return Place(Path(named) / "cache", VARIABLE)
    base = os.environ.get("XDG_CACHE_HOME", "")
    return Place((Path(base) if base.startswith("/") else Path.home() / ".cache") / NAME)


def make_private(folder: Path) -> None:
    """Make a folder and those above it that are missing, for this user alone."""
    for path in reversed([folder, *folder.parents]):
        if not path.exists():
            path.mkdir(mode=0o700, exist_ok=True)


def writable_by_others(folder: Path, mode: int = GROUP | OTHERS) -> str:
    """Return why others may put files into a folder; empty where only this user and root may.

    ``mode`` are the forbidden permission bits. Raise OSError where there is no such folder.
    """
    state = folder.stat()
    if state.st_uid not in (os.geteuid(), 0):
        return f"it belongs to user {state.st_uid}"
    if state.st_mode & mode:
        return f"others may write it (mode {stat.S_IMODE(state.st_mode):o})"
    return ""


@contextlib.contextmanager
def lock_file(path: Path) -> Iterator[int]:
    """Yield a handle of a file to lock, made if need be; its content stays as it is.

    Raise OSError for a link, and where it cannot be written.
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC
    handle = os.open(path, flags, 0o600)
    try:
        yield handle
    finally:
        os.close(handle)


# ---- committed files


def committed(path: str) -> Path:
    """Return a file or folder of the checkout; of an installed package, its copy."""
    return PACKAGE.parent / path if is_checkout() else PACKAGE / COPIES / Path(path).name


def is_checkout() -> bool:
    """Return whether this package lies in a checkout of the project."""
    return (PACKAGE.parent / "pyproject.toml").is_file()


# ---- complete folders and files, and temporary ones
#
# Each is written in a temporary folder next to its place, and renamed. The process holds a lock of
# that folder, which the kernel releases when the process dies, so that a later one may remove it.
# Folders are opened without following links, and only those of this user are removed.

PREFIX = ".dem-harness-"
HOLDS_SOMETHING = "--output {}: holds something already; name a new folder"


@contextlib.contextmanager
def whole_folder(target: Path, *, replace: bool = False) -> Iterator[Path]:
    """Yield a new folder; at the end of the block it becomes ``target``.

    ``target`` must be missing or empty, unless it is to be replaced. On any exception nothing
    remains, and a folder to be replaced is as before. Raise FullDiskError where there is no space,
    RequestError for a target that is no longer empty.
    """
    place = target.resolve()  # a link stays one, and "." can be renamed
    try:
        with made_folder(place.parent), held_folder(place.parent) as aside:
            new, old = aside / "new", aside / "old"
            new.mkdir()
            yield new
            if replace and place.is_dir():
                place.rename(old)
            try:
                new.rename(place)  # also onto an empty folder
            except BaseException:
                if old.is_dir():
                    old.rename(place)
                raise
    except OSError as error:
        if error.errno in FULL:
            raise FullDiskError(f"{target}: {error.strerror}") from None
        if error.errno == errno.ENOTEMPTY:  # another process was faster
            raise RequestError(HOLDS_SOMETHING.format(target)) from None
        raise


@contextlib.contextmanager
def made_folder(folder: Path) -> Iterator[None]:
    """Make a folder and those above it; on any exception remove the new ones that are empty."""
    new = [path for path in (folder, *folder.parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        with contextlib.suppress(OSError):
            for path in new:
                path.rmdir()
        raise


def write_files(files: Mapping[tuple[str, Path], Writer]) -> None:
    """Write the file of each (option, path), then put all in their places: none is half-written.

    Raise RequestError naming the one that fails, FullDiskError where there is no space.
    """
    target = ("", Path())
    with contextlib.ExitStack() as stack:
        try:
            parts = {}
            for target, write in files.items():
                stack.enter_context(made_folder(target[1].parent))
                folder = stack.enter_context(held_folder(target[1].parent))
                parts[target] = folder / f"file{target[1].suffix}"
                write(parts[target])
            for target, part in parts.items():
                part.replace(target[1])
        except OSError as error:
            kind = FullDiskError if error.errno in FULL else RequestError
            option, path = target
            raise kind(f"{option} {path}: {error.strerror or error}") from None


def text_writer(text: str) -> Writer:
    """Return a function that writes a text as UTF-8, its line ends as they are."""
    return lambda path: path.write_bytes(text.encode("utf-8"))


@contextlib.contextmanager
def held_folder(parent: Path) -> Iterator[Path]:
    """Yield a new folder that this process locks; remove it at the end of the block.

    Folders of killed processes next to it are removed.
    """
    sweep(parent)
    with contextlib.ExitStack() as stack:
        while True:
            folder = Path(tempfile.mkdtemp(dir=parent, prefix=PREFIX))
            with contextlib.suppress(OSError):  # a file system without locks, where none is swept
                fcntl.flock(stack.enter_context(_handle(folder)), fcntl.LOCK_EX)
            if folder.is_dir():  # and not swept before it was locked
                break
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        yield folder


def sweep(parent: Path) -> None:
    """Remove temporary folders of dead processes, and the shared memory of their programs."""
    for path in parent.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError), _handle(path) as handle:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            remove_segments()
            shutil.rmtree(path, ignore_errors=True)


@contextlib.contextmanager
def _handle(folder: Path) -> Iterator[int]:
    """Open a folder that this user alone may write; raise OSError for any other, or a link."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        state = os.fstat(handle)
        if state.st_uid != os.geteuid() or stat.S_IMODE(state.st_mode) & (GROUP | OTHERS):
            raise PermissionError(f"{folder} is not this user's alone")
        yield handle
    finally:
        os.close(handle)


def safe_path(name: str) -> str:
    """Return a name as a relative path of plain characters, below any folder."""
    parts = (re.sub(r"[^A-Za-z0-9._+=-]+", "-", part).lstrip(".") for part in name.split("/"))
    return "/".join(part or "-" for part in parts)


def check_folder(folder: Path) -> None:
    """Raise RequestError for a folder that cannot take a report: not empty, or not replaceable."""
    check_replaceable(folder)
    if folder.is_dir() and any(folder.iterdir()):
        raise RequestError(HOLDS_SOMETHING.format(folder))


def check_replaceable(folder: Path) -> None:
    """Raise RequestError for a folder in whose place no other can be put.

    A mount point is none that :func:`whole_folder` can replace.
    """
    check_writable(folder)
    if folder.resolve().is_mount():
        raise RequestError(f"--output {folder}: is a mount point; name a folder in it")


def check_writable(folder: Path) -> None:
    """Raise RequestError for a folder that cannot be made; make nothing yet."""
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a folder")
    existing = next((parent for parent in folder.absolute().parents if parent.exists()), folder)
    try:
        with tempfile.TemporaryDirectory(dir=existing, prefix=f".{folder.name}."):
            pass
    except OSError as error:
        raise RequestError(f"--output {folder}: cannot be written ({error.strerror})") from None
