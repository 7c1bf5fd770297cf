"""Check that a report can be written into a folder; no figure library is imported for it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from harness.errors import RequestError


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
