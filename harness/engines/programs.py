"""Programs of engines: found by name, known by content, asked for their version.

A program is identified by its content: a modified release may print the same version.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any, ClassVar

from harness.engines.base import Engine
from harness.engines.jobs import cores
from harness.engines.output import Provenance
from harness.engines.process import Ended, Limits, Processes, first_text, fresh_folder
from harness.errors import EngineMissingError, RequestError

ASK_SECONDS, LOADER_SECONDS = 60.0, 10.0
# variables that decide which code runs, and likewise in a program that imports modules
ENVIRONMENT = ("LD_LIBRARY_PATH", "LD_PRELOAD", "DYLD_LIBRARY_PATH")
OF_PYTHON = (*ENVIRONMENT, "PYTHONPATH", "PYTHONHOME", "PYTHONUSERBASE")


# ---- programs by name


def find_program(option: str, name: str) -> str:
    """Return the absolute path of a program, on PATH or next to this Python.

    Raise RequestError naming the option, such as ``lmp`` or ``program NAME=``.
    """
    path = shutil.which(name) or shutil.which(name, path=str(Path(sys.executable).parent))
    if path is None:
        option += "" if option.endswith("=") else " "
        raise RequestError(
            f"--{option}{name!r}: no such executable; give a path, or a name found on PATH"
        )
    return str(Path(path).absolute())


def program_of_python(name: str) -> str:
    """Return the path of a program next to this Python, else its name, to be found on PATH."""
    path = Path(sys.executable).with_name(name)
    return str(path) if path.exists() else name


def program_words(option: str, command: str) -> list[str]:
    """Return the words of a command: the absolute path of its program, then its arguments.

    A file that exists, or a name on PATH, is taken whole, blanks included. Raise RequestError for
    a command that cannot be split into words, or whose program is not there.
    """
    with suppress(RequestError):
        return [find_program(option, command)]
    try:
        program, *arguments = shlex.split(command) or [""]
    except ValueError as error:
        raise RequestError(f"--{option} {command!r} cannot be read: {error}") from None
    return [find_program(option, program), *arguments]


def launcher_of(ranks: int, program: str | None = None) -> str:
    """Return a command that starts ranks of MPI: of the program's installation, else on PATH.

    Another MPI's launcher would start as many runs of one rank. Without a program that is a path,
    the installation is that of this Python.
    """
    path = program if program and Path(program).name != program else sys.executable
    mpirun = Path(path).with_name("mpirun")
    return f"{shlex.quote(str(mpirun)) if mpirun.exists() else 'mpirun'} -n {ranks}"


# ---- programs by content


def facts(
    engine: str,
    how: str,
    files: Sequence[Path],
    environment: Sequence[str] = ENVIRONMENT,
    options: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Return the identity of an engine, JSON-ready, by the contents of its files, program first.

    ``options`` are those of the engine that no job has and that decide a result.
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
    paths = (path for path in folder.rglob("*") if "__pycache__" not in path.parts)
    return sorted(path for path in paths if path.is_file())


def program_files(program: Path) -> list[Path]:
    """Return a program and all that the loader gives it; nothing for a script."""
    with program.open("rb") as stream:
        is_script = stream.read(2) == b"#!"
    libraries = [] if is_script else with_libraries(program.resolve())
    return [program, *libraries] if libraries else []


@cache  # the fingerprint of an engine is needed with every batch of runs
def with_libraries(program: Path, *more: Path) -> list[Path]:
    """Return a program or library, what the loader gives it, and ``more``; nothing on failure."""
    done = ask_program(["ldd", str(program)], LOADER_SECONDS)
    if done is None:
        return []
    if done.returncode != 0 and "not a dynamic executable" not in done.stderr + done.stdout:
        return []
    # as in "libm.so.6 => /lib/libm.so.6 (0x7f...)"
    lines = [line.split() for line in done.stdout.splitlines()]
    paths = [Path(next((w for w in words if w.startswith("/")), "")) for words in lines]
    return [program, *(path for path in paths if path.is_file()), *more]


def ask_program(words: Sequence[str], seconds: float) -> subprocess.CompletedProcess[str] | None:
    """Return the output and exit status of a program within so many seconds of wall time.

    None where it cannot be started or takes longer. It has no input.
    """
    with suppress(OSError, subprocess.TimeoutExpired):
        return subprocess.run(
            words,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="surrogateescape",  # as in the names of files
            timeout=seconds,
            check=False,
        )
    return None


@cache
def digest(path: Path) -> str:
    """Return the BLAKE2 digest of a file, half the time of SHA-256 for 40 MB of library."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, lambda: hashlib.blake2b(digest_size=32)).hexdigest()


class ProgramEngine(Engine):
    """An engine that is its ``program``, by default the first of ``programs`` on PATH.

    ``workers`` processes run in parallel, by default as many as there are cores. Runs are cached
    under the contents of ``installed_files``, the ``deciding_variables`` of the environment, and
    ``deciding_options``: those of the engine that no job has and that decide a result. Raise
    RequestError for no worker and a named program that is not there, EngineMissingError where none
    is named and there is none.
    """

    programs: ClassVar[tuple[str, ...]] = ()
    deciding_variables: ClassVar[tuple[str, ...]] = ENVIRONMENT

    def __init__(
        self, program: str | None = None, workers: int | None = None, limits: Limits | None = None
    ) -> None:
        if workers is not None and workers < 1:
            raise RequestError(f"workers = {workers!r}: must be at least 1")
        self.program = self.find(program)
        self.limits = limits or Limits()
        self.workers = workers or cores()
        self.processes = Processes()
        self.deciding_options: Mapping[str, str] = {}

    @abstractmethod
    def ask_version(self) -> Provenance:
        """Return who the program is; raise EngineMissingError where it is another, or broken."""

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the absolute path of the program that is named, or of a known one."""
        if program is not None:
            return find_program(f"program {cls.name}=", program)
        for name in cls.programs:
            with suppress(RequestError):
                return find_program("program", name)
        raise EngineMissingError(cls.traits.missing(f"no {' or '.join(cls.programs)} on PATH"))

    def environment(self, folder: Path) -> Mapping[str, str] | None:  # noqa: ARG002
        """Return the environment of a process that works in a folder; None: the harness's own."""
        return None

    def identify(self) -> Provenance:
        """Return version and executable, read once."""
        return self._identity

    @cached_property
    def _identity(self) -> Provenance:
        identity = self.ask_version()
        # the version text of a program goes to terminals and pages
        version = "".join(c if c.isprintable() else "?" for c in identity.engine_version)
        return replace(identity, engine_version=version, integrator=self.traits.integrator)

    def installed_files(self) -> list[Path]:
        """Return the files that decide a result, the program first; none where not all are known.

        Those of a program that needs no others are :func:`program_files`.
        """
        return []

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return the contents of the program and all that it runs, read once."""
        return self._fingerprint

    @cached_property
    def _fingerprint(self) -> Mapping[str, Any] | None:
        files = self.installed_files()
        if not files:
            return None
        return facts(self.name, "executable", files, self.deciding_variables, self.deciding_options)

    def ask(
        self, words: Sequence[str], files: Mapping[str, str] | None = None
    ) -> tuple[str, Ended]:
        """Run a command once in a folder with these files; return its first output and its end."""
        with fresh_folder() as folder:
            for name, text in (files or {}).items():
                (folder / name).write_text(text, encoding="utf-8")
            ended = self.start(words, folder, ASK_SECONDS)
            return first_text(folder / "said", 100_000), ended

    def start(self, words: Sequence[str], folder: Path, seconds: float) -> Ended:
        """Run a command in a folder."""
        return self.processes.run(
            words,
            folder,
            seconds=seconds,
            memory=self.limits.memory,
            environment=self.environment(folder),
        )

    def close(self) -> None:
        """End what runs; whoever waits for it removes its files."""
        self.processes.close()
