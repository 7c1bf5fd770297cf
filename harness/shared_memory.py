"""Shared memory of MPI libraries: how much room there is, and what dead processes left in it.

MPICH unlinks its segment of ``/dev/shm`` in MPI_Finalize only. What is started for the harness
carries the name of its folder in the environment, by which its segments are known; they are
written down in that folder while it runs, and unlinked when it is gone.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

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
    found = {*names, *_mapped(unknown, os.fsencode(f"{MARK}={folder}"))}
    if found:
        with (folder / RECORD).open("a", encoding="utf-8") as stream:
            stream.writelines(f"{name}\n" for name in sorted(found))


def remove_segments(folder: Path, *, mapped: bool = False) -> None:
    """Unlink the segments written down in a folder and those below it: only this user's.

    Raise BlockingIOError, with nothing unlinked, where a process has one mapped, unless that is
    allowed: of a process that was killed and is about to end.
    """
    names = {name for path in folder.rglob(RECORD) for name in _recorded(path.parent)}
    left = [path for path in _own_segments() if path.name in names]
    if left and not mapped and _mapped({path.name for path in left}):
        raise BlockingIOError(f"{folder}: a process of it is still there")
    for path in left:
        path.unlink(missing_ok=True)


def _own_segments() -> Iterator[Path]:
    """Yield MPICH's segments that are this user's."""
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
    found: set[str] = set()
    for process in Path("/proc").glob("[0-9]*") if names else ():
        with contextlib.suppress(OSError):  # another user's, or gone by now
            if not mark or mark in (process / "environ").read_bytes().split(b"\0"):
                found |= names & set(_NAME.findall((process / "maps").read_text("utf-8")))
    return found
