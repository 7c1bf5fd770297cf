"""Environments of engines' releases in the cache folder: made once, dropped when it is too full.

Each is a folder with a file :data:`COMPLETE`, written last, whose time is that of the last use.
Whoever uses or makes one holds a lock beside it; only one that nobody holds is dropped.
"""

from __future__ import annotations

import contextlib
import fcntl
import shutil
from collections.abc import Iterator
from pathlib import Path

from harness.home import cache_place, lock_file, make_private

FOLDER = "releases"
COMPLETE = "complete"


def environments_folder() -> Path:
    """Return where environments are kept unless told otherwise."""
    return cache_place().path / FOLDER


USED, MADE = LOCKS = ".used", ".lock"
"""Endings of the locks of those who use an environment, and of the one who makes it."""


@contextlib.contextmanager
def held(home: Path, lock: str, how: int = fcntl.LOCK_EX) -> Iterator[None]:
    """Hold a lock of an environment; raise BlockingIOError with LOCK_NB where another does."""
    make_private(home.parent)
    with lock_file(home.with_name(home.name + lock)) as file:
        fcntl.flock(file, how)
        yield


def last_use_and_size(home: Path) -> tuple[float, int]:
    """Return when an environment was last used [s since 1970], and its size [bytes].

    Raise OSError for one that is not complete.
    """
    used = (home / COMPLETE).stat().st_mtime
    return used, sum(path.lstat().st_size for path in home.rglob("*") if not path.is_dir())


def drop(home: Path) -> None:
    """Remove an environment; raise BlockingIOError where somebody uses or makes it."""
    now = fcntl.LOCK_EX | fcntl.LOCK_NB
    with held(home, USED, now), held(home, MADE, now):
        (home / COMPLETE).unlink(missing_ok=True)
        shutil.rmtree(home, ignore_errors=True)
