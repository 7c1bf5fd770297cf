"""Identify programs by content: a version does not tell a release from one with a line changed."""

from __future__ import annotations

import hashlib
import os
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

LOADER_SECONDS = 10.0
"""That a dynamic loader takes at most to name libraries."""

ENVIRONMENT = ("LD_LIBRARY_PATH", "LD_PRELOAD", "DYLD_LIBRARY_PATH")
"""What else decides which code runs."""

OF_PYTHON = (*ENVIRONMENT, "PYTHONPATH", "PYTHONHOME", "PYTHONUSERBASE")
"""Likewise, in a program that imports modules."""


def facts(
    engine: str,
    how: str,
    files: Sequence[Path],
    environment: Sequence[str] = ENVIRONMENT,
    options: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Return who runs, JSON-ready, by the contents of its files, the program first.

    ``options`` are those of the engine that no job states and that decide a result.
    """
    return {
        "engine": engine,
        "how": how,
        "program": str(files[0]),
        "files": sorted({f"{digest(path)} {path.name}" for path in files}),
        "options": dict(options or {}),
        "environment": {name: os.environ[name] for name in environment if name in os.environ},
    }


def tree_files(folder: Path) -> list[Path]:
    """Return the files below a folder, in order, but for byte code, which follows from them."""
    found = (path for path in folder.rglob("*") if "__pycache__" not in path.parts)
    return sorted(path for path in found if path.is_file())


def program_files(program: Path) -> list[Path]:
    """Return a program and all that the loader gives it; nothing for a script."""
    with program.open("rb") as stream:
        if stream.read(2) == b"#!":
            return []
    found = with_libraries(program.resolve())
    return [program, *found] if found else []


@cache
def with_libraries(program: Path, *more: Path) -> list[Path]:
    """Return a program or library, what the loader gives it, and ``more``; nothing on failure.

    The loader is asked once: the fingerprint of an engine is asked for with every batch of runs.
    """
    done = ask_program(["ldd", str(program)], LOADER_SECONDS)
    if done is None:
        return []
    if done.returncode != 0 and "not a dynamic executable" not in done.stderr + done.stdout:
        return []
    return [program, *_paths(done.stdout.splitlines()), *more]


def ask_program(words: Sequence[str], seconds: float) -> subprocess.CompletedProcess[str] | None:
    """Return what a program says and its exit status, within so many seconds of wall time.

    None where it cannot be started or takes longer. It is given no input.
    """
    try:
        return subprocess.run(
            words,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="surrogateescape",  # as in the names of files
            timeout=seconds,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None


def _paths(lines: Iterable[str]) -> Iterator[Path]:
    """Yield the files that ``ldd`` names, as in ``libm.so.6 => /lib/libm.so.6 (0x7f...)``."""
    for line in lines:
        words = line.split()
        path = next((word for word in words if word.startswith("/")), None)
        if path is not None and Path(path).is_file():
            yield Path(path)


@cache
def digest(path: Path) -> str:
    """Return the BLAKE2 digest of a file, half the time of SHA-256 for 40 MB of library."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, lambda: hashlib.blake2b(digest_size=32)).hexdigest()
