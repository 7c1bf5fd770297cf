"""Where things are kept: the cache, and the history of runs.

In the cache are results, environments of engines' releases (``releases``) and compiled kernels
(``numba``). Both are found in this order: the option ``--cache`` (the cache only), the
environment variable ``DEM_HARNESS_HOME`` (``cache`` and ``history.sqlite``
under that folder), else the places of the XDG base directory specification.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from harness.errors import RequestError

VARIABLE = "DEM_HARNESS_HOME"
NAME = "dem-harness"
KERNELS = "numba"
"""Folder of the cache for compiled kernels."""

RESTARTS = "restarts"
"""Folder of the cache for the restart files of runs that have not ended."""

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
    return Place(_base("XDG_CACHE_HOME", ".cache") / NAME)


def history_place() -> Place:
    """Return the file of the history."""
    named = os.environ.get(VARIABLE)
    if named:
        return Place(Path(named) / "history.sqlite", VARIABLE)
    return Place(_base("XDG_DATA_HOME", ".local/share") / NAME / "history.sqlite")


def _base(variable: str, below_home: str) -> Path:
    """Return a base directory; the specification has relative values ignored."""
    value = os.environ.get(variable, "")
    return Path(value) if value.startswith("/") else Path("~").expanduser() / below_home


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
