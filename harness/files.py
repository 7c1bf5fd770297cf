"""Places where things are kept, whole folders, and what a process that died leaves behind.

A folder is filled aside and renamed, so that it is there whole or not at all, also after kill -9;
the shared memory of MPI libraries is cleared with the same care, and a worker process ends with the
one that started it.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import re
import shutil
import stat
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from harness.errors import RequestError, cannot_write

Writer = Callable[[Path], object]

# ---- a worker process ends with the one that started it, however that one ended

LOOK_SECONDS = 1.0
"""Between two looks at the parent."""


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


# ---- shared memory of MPI libraries
#
# MPICH unlinks its segment of /dev/shm in MPI_Finalize only. What is started for the harness
# carries the name of its folder in the environment, by which its segments are known; they are
# written down in that folder while it runs, and unlinked when it is gone.

SHARED = Path("/dev/shm")
MARK = "DEM_HARNESS_FOLDER"
"""Environment variable of every process that is started in a folder: that folder."""

RECORD = "segments"
"""File of a folder with the names of segments, one a line."""

NEEDED = 6 * 1024**2
"""[bytes] of a process: MPICH touches 1.0 MiB, UCX below it 4.1 MiB where they are free."""

_NAME = re.compile(r"mpich_shm_[0-9a-f]+_\d+")


def processes_with_room() -> int | None:
    """Return how many MPI processes find room, one at least; None where that is not known."""
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


def record_segments(folder: Path, *names: str) -> None:
    """Write down, in a folder, the segments that the processes marked with it have mapped.

    ``names`` are written down as well, whether there are such segments or not.
    """
    unknown = {path.name for path in _own_segments()} - _recorded(folder)
    segments = {*names, *_mapped(unknown, os.fsencode(f"{MARK}={folder}"))}
    if segments:
        with (folder / RECORD).open("a", encoding="utf-8") as stream:
            stream.writelines(f"{name}\n" for name in sorted(segments))


def remove_segments(folder: Path, *, mapped: bool = False) -> None:
    """Unlink the segments written down in a folder and those below it: only this user's.

    Raise BlockingIOError, with nothing unlinked, where a process has one mapped, unless that is
    allowed: of a process that was killed and is about to end.
    """
    names = {name for path in folder.rglob(RECORD) for name in _recorded(path.parent)}
    removed = [path for path in _own_segments() if path.name in names]
    if removed and not mapped and _mapped({path.name for path in removed}):
        raise BlockingIOError(f"{folder}: a process of it is still there")
    for path in removed:
        path.unlink(missing_ok=True)


def _own_segments() -> Iterator[Path]:
    with contextlib.suppress(OSError):
        for path in SHARED.iterdir():
            if _NAME.fullmatch(path.name) and path.lstat().st_uid == os.geteuid():
                yield path


def _recorded(folder: Path) -> set[str]:
    with contextlib.suppress(OSError):
        return set(_NAME.findall((folder / RECORD).read_text(encoding="utf-8", errors="replace")))
    return set()


def _mapped(names: set[str], mark: bytes = b"") -> set[str]:
    """Return those of the names that some process has mapped, one with the mark if given."""
    in_use: set[str] = set()
    for process in Path("/proc").glob("[0-9]*") if names else ():
        with contextlib.suppress(OSError):  # another user's, or gone by now
            if not mark or mark in (process / "environ").read_bytes().split(b"\0"):
                in_use |= names & set(_NAME.findall((process / "maps").read_text("utf-8")))
    return in_use


# ---- where things are kept
#
# In the cache are results, environments of engines' releases (releases) and compiled kernels
# (numba). It is found in this order: the option --cache, the environment variable
# DEM_HARNESS_HOME (the folder cache below it), else the place of the XDG base directory
# specification.

VARIABLE = "DEM_HARNESS_HOME"
NAME = "dem-harness"
KERNELS = "numba"
"""Folder of the cache for compiled kernels."""

GROUP, OTHERS = stat.S_IWGRP, stat.S_IWOTH


@dataclass(frozen=True)
class Place:
    """A file or folder, and what named it; ``named_by`` is empty for a default place."""

    path: Path
    named_by: str = ""

    def refused(self, why: str) -> RequestError:
        """Return the error for a place that was asked for and cannot be used."""
        return RequestError(f"{self.named_by} {self.path}: cannot be used ({why})")


def cache_place(option: Path | None = None) -> Place:
    """Return the folder of the cache, the value of ``--cache`` first."""
    if option is not None:
        return Place(option, "--cache")
    named = os.environ.get(VARIABLE)
    if named:
        return Place(Path(named) / "cache", VARIABLE)
    return Place(_cache_home() / NAME)


def _cache_home() -> Path:
    """Return the base directory of caches; the specification has relative values ignored."""
    value = os.environ.get("XDG_CACHE_HOME", "")
    return Path(value) if value.startswith("/") else Path("~").expanduser() / ".cache"


def make_private(folder: Path) -> None:
    """Make a folder and those above it that are missing, for this user alone."""
    for path in reversed([folder, *folder.parents]):
        if not path.exists():
            path.mkdir(mode=0o700, exist_ok=True)


def writable_by_others(folder: Path, mode: int = GROUP | OTHERS) -> str:
    """Return why others may put files into a folder; empty where only this user and root may.

    ``mode`` are the bits that must not be set. Of a link, its target is looked at. Raise OSError
    where there is no such folder.
    """
    state = folder.stat()
    if state.st_uid not in (os.geteuid(), 0):
        return f"it belongs to user {state.st_uid}"
    if state.st_mode & mode:
        return f"others may write it (mode {stat.S_IMODE(state.st_mode):o})"
    return ""


@contextlib.contextmanager
def lock_file(path: Path) -> Iterator[int]:
    """Yield a handle of a file to lock, made if need be; what it holds stays as it is.

    Raise OSError for a link, whose target is somebody's, and where it cannot be written.
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC
    handle = os.open(path, flags, 0o600)
    try:
        yield handle
    finally:
        os.close(handle)


# ---- folders that are there whole or not at all, and temporary ones
#
# A folder is filled in one aside, which is locked, and renamed; one that is replaced is exchanged
# with it in one step where the system can. The kernel releases the lock of a process that died, so
# that the next one may remove what it left, after putting back what it had moved out of the way.
# Folders aside are opened without following links, and only those of this user are touched.

PREFIX = ".dem-harness-"
WHOLE, OLD = "whole", "old"

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2


@contextlib.contextmanager
def whole_folder(target: Path, *, replace: bool = False) -> Iterator[Path]:
    """Yield a path to make a folder at; at the end of the block it becomes ``target``.

    ``target`` must not be there, or be an empty folder, unless it is to be
    replaced. On any exception nothing is left, and what was to be replaced is as
    before. What killed processes left beside ``target`` is removed.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with held_folder(target.parent) as aside:
        yield aside / WHOLE
        try:
            if replace and target.is_dir():
                _replace(target, aside)
            else:
                if target.is_dir():
                    target.rmdir()
                (aside / WHOLE).rename(target)
        except BaseException:
            _put_back(aside)
            raise


def write_files(files: Mapping[tuple[str, Path], Writer]) -> None:
    """Write each (option, path) aside, then put all in their places: none is half-written.

    Raise RequestError naming the one that fails, FullDiskError where there is no space.
    """
    target = ("", Path())
    with contextlib.ExitStack() as stack:
        try:
            asides = {}
            for target, write in files.items():
                target[1].parent.mkdir(parents=True, exist_ok=True)
                folder = stack.enter_context(held_folder(target[1].parent))
                asides[target] = folder / f"file{target[1].suffix}"
                write(asides[target])
            for target, aside in asides.items():
                aside.replace(target[1])
        except OSError as error:
            raise cannot_write(f"{target[0]} {target[1]}", error) from None


def text_writer(text: str) -> Writer:
    """Return a function that writes a text as UTF-8, its line ends as they are."""
    return lambda path: path.write_bytes(text.encode("utf-8"))


def sweep(parent: Path) -> None:
    """Remove folders aside that no living process holds, and the shared memory of what ran in them.

    A folder that a process still works for is left to a later run.
    """
    for path in parent.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError), _handle(path) as handle:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            _put_back(path)
            remove_segments(path)
            shutil.rmtree(path, ignore_errors=True)


def _replace(target: Path, aside: Path) -> None:
    new = aside / WHOLE
    if new.is_dir() and _exchange(new, target):
        return
    (aside / OLD).mkdir(mode=0o700)
    target.rename(aside / OLD / target.name)
    new.rename(target)


def _exchange(folder: Path, other: Path) -> bool:
    """Exchange two folders in one step; return whether system and file system can."""
    try:
        renameat2 = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    names = (os.fsencode(folder), os.fsencode(other))
    return bool(renameat2(_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE) == 0)


def _put_back(aside: Path) -> None:
    with contextlib.suppress(FileNotFoundError), _handle(aside / OLD) as old:
        for name in os.listdir(old):  # noqa: PTH208 - below a handle
            if not os.path.lexists(aside.parent / name):
                os.rename(name, aside.parent / name, src_dir_fd=old)


@contextlib.contextmanager
def held_folder(parent: Path) -> Iterator[Path]:
    """Yield a new folder that this process holds, removed at the end of the block.

    What killed processes left beside it is removed.
    """
    sweep(parent)
    with _new(parent) as folder:
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def _new(parent: Path) -> Iterator[Path]:
    """Yield a new folder under a lock; one that is swept before it is locked is made again."""
    while True:
        folder = Path(tempfile.mkdtemp(dir=parent, prefix=PREFIX))
        with contextlib.ExitStack() as held:
            with contextlib.suppress(FileNotFoundError):
                handle = held.enter_context(_handle(folder))
                with contextlib.suppress(OSError):  # a file system without locks: nobody sweeps
                    fcntl.flock(handle, fcntl.LOCK_EX)
            if folder.is_dir():
                yield folder
                return


@contextlib.contextmanager
def _handle(folder: Path) -> Iterator[int]:
    """Open a folder that this user alone may write; raise OSError for any other, or a link."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        state = os.fstat(handle)
        others_write = stat.S_IMODE(state.st_mode) & (stat.S_IWGRP | stat.S_IWOTH)
        if state.st_uid != os.geteuid() or others_write:
            raise PermissionError(f"{folder} is not this user's alone")
        yield handle
    finally:
        os.close(handle)


def safe_path(name: str) -> str:
    """Return a name as a relative path of plain characters, below any folder."""
    parts = (re.sub(r"[^A-Za-z0-9._+=-]+", "-", part).lstrip(".") for part in name.split("/"))
    return "/".join(part or "-" for part in parts)


def check_folder(folder: Path) -> None:
    """Raise RequestError when a folder cannot take a report: it holds something, or is not ours."""
    if folder.is_dir() and any(folder.iterdir()):
        raise RequestError(f"--output {folder}: holds something already; name a new folder")
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a new folder")
    check_writable(folder)


def check_writable(folder: Path) -> None:
    """Raise RequestError when a folder cannot be made where it is asked for."""
    # nothing is made yet: what is asked for may turn out to be wrong in another way
    parents = folder.absolute().parents
    if not parents:
        raise RequestError(f"--output {folder}: is the root of all folders; name a new folder")
    there = next(parent for parent in parents if parent.exists())
    try:
        with tempfile.TemporaryDirectory(dir=there, prefix=f".{folder.name}."):
            pass
    except OSError as error:
        raise RequestError(f"--output {folder}: cannot be written ({error.strerror})") from None
