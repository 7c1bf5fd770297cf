"""A folder that is there whole or not at all, also after kill -9.

It is filled in a folder aside, which is locked, and renamed. The kernel lets
go of the lock of a process that died, so that the next one may remove what it
left, after putting back what it had moved out of the way.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

PREFIX = ".dem-harness-"
OLD = "old"


@contextlib.contextmanager
def whole_folder(target: Path, *, replace: bool = False) -> Iterator[Path]:
    """Yield a path to make a folder at; at the end of the block it becomes ``target``.

    ``target`` must not be there, or be an empty folder, unless it is to be
    replaced. On any exception nothing is left, and what was to be replaced is as
    before. What killed processes left beside ``target`` is removed.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    sweep(target.parent)
    with _locked(target.parent) as aside:
        yield aside / "whole"
        try:
            if replace and target.is_dir():
                (aside / OLD).mkdir()
                target.rename(aside / OLD / target.name)
            elif target.is_dir():
                target.rmdir()
            (aside / "whole").rename(target)
        except BaseException:
            _put_back(aside)
            raise


def sweep(parent: Path) -> None:
    """Remove folders aside that no living process holds."""
    for path in parent.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError), _handle(path) as handle:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            _put_back(path)
            shutil.rmtree(path, ignore_errors=True)


def _put_back(aside: Path) -> None:
    """Move what was to be replaced back to its place, unless the new one is there already."""
    for old in (aside / OLD).glob("*"):
        if not (aside.parent / old.name).exists():
            old.rename(aside.parent / old.name)


@contextlib.contextmanager
def _locked(parent: Path) -> Iterator[Path]:
    """Yield a new folder that this process holds, removed at the end of the block."""
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
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield handle
    finally:
        os.close(handle)
