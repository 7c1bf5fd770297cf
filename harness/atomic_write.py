"""A folder that is there whole or not at all, and temporary folders, also after kill -9.

It is filled in a folder aside, which is locked, and renamed; one that is replaced is exchanged
with it in one step where the system can. The kernel releases the lock of a process that died, so
that the next one may remove what it left, after putting back what it had moved out of the way.
Folders aside are opened without following links, and only those of this user are touched.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

from harness.shared_memory import remove_segments

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
    """Put the new folder in the place of the old one, which goes aside."""
    whole = aside / WHOLE
    if whole.is_dir() and _exchange(whole, target):
        return
    (aside / OLD).mkdir(mode=0o700)
    target.rename(aside / OLD / target.name)
    whole.rename(target)


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two folders in one step; return whether system and file system can."""
    try:
        renameat2 = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    names = (os.fsencode(one), os.fsencode(other))
    return bool(renameat2(_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE) == 0)


def _put_back(aside: Path) -> None:
    """Move what was to be replaced back to its place, unless the new one is there already."""
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
        found = os.fstat(handle)
        others_write = stat.S_IMODE(found.st_mode) & (stat.S_IWGRP | stat.S_IWOTH)
        if found.st_uid != os.geteuid() or others_write:
            raise PermissionError(f"{folder} is not this user's alone")
        yield handle
    finally:
        os.close(handle)
