"""A folder that is there whole or not at all, also after kill -9.

It is filled in a folder aside, which is locked, and renamed. The kernel lets
go of the lock of a process that died, so that the next one may remove what it
left.
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


@contextlib.contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """Yield a path to make a folder at; at the end of the block it becomes ``target``.

    ``target`` must not be there, or be an empty folder. On any exception
    nothing is left. What killed processes left beside ``target`` is removed.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    sweep(target.parent)
    with _locked(target.parent) as aside:
        yield aside / "whole"
        if target.is_dir():
            target.rmdir()
        (aside / "whole").rename(target)


def sweep(parent: Path) -> None:
    """Remove folders aside that no living process holds."""
    for path in parent.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError), _handle(path) as handle:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(path, ignore_errors=True)


@contextlib.contextmanager
def _locked(parent: Path) -> Iterator[Path]:
    """Yield a new folder that this process holds, removed at the end of the block."""
    while True:
        folder = Path(tempfile.mkdtemp(dir=parent, prefix=PREFIX))
        with contextlib.suppress(FileNotFoundError), _handle(folder) as handle:
            with contextlib.suppress(OSError):  # a file system without locks: nobody sweeps
                fcntl.flock(handle, fcntl.LOCK_EX)
            if not folder.is_dir():  # swept between its making and its locking
                continue
            try:
                yield folder
            finally:
                shutil.rmtree(folder, ignore_errors=True)
            return


@contextlib.contextmanager
def _handle(folder: Path) -> Iterator[int]:
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield handle
    finally:
        os.close(handle)
