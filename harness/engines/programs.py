"""Find the programs of engines, ask them who they are, and run them."""

from __future__ import annotations

import shlex
import shutil
import sys
import tempfile
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from harness.atomic_write import held_folder
from harness.engines.fingerprints import ENVIRONMENT, facts, program_files
from harness.engines.parallel import cores
from harness.engines.process import Ended, Limits, Processes, first_text
from harness.engines.script import ScriptSource
from harness.errors import EngineCrashError, EngineError, EngineMissingError, RequestError
from harness.observables.provenance import Provenance

ASK_SECONDS = 60.0
NO_FILES: Mapping[str, str] = {}


class ProgramEngine(ScriptSource):
    """The part of an engine that is its ``program``, by default the first of ``programs`` on PATH.

    ``workers`` processes run side by side, as many as there are cores unless told otherwise.
    ``self_contained`` says that the program with its libraries is all that decides a result, else
    ``installed_files`` may name what does: runs are cached under their contents. Raise
    RequestError for no worker, a named program that is not there, EngineMissingError where none is
    named and there is none.
    """

    programs: ClassVar[tuple[str, ...]] = ()
    self_contained: ClassVar[bool] = False
    deciding_variables: ClassVar[tuple[str, ...]] = ENVIRONMENT
    """Of the environment, that decide which code runs."""

    def __init__(
        self, program: str | None = None, workers: int | None = None, limits: Limits | None = None
    ) -> None:
        if workers is not None and workers < 1:
            raise RequestError(f"workers = {workers!r}: must be at least 1")
        self.program = self.find(program)
        self.limits = limits or Limits()
        self.workers = workers or cores()
        self.processes = Processes()
        self._logs: dict[str, str] = {}

    @abstractmethod
    def ask_version(self) -> Provenance:
        """Return who the program is; raise EngineMissingError where it is another, or broken."""

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the absolute path of the program that is named, or of a known one."""
        if program is not None:
            return find_program(f"program {cls.name}=", program)
        for name in cls.programs:
            try:
                return find_program("program", name)
            except RequestError:
                continue
        raise EngineMissingError(cls.traits.missing(f"no {' or '.join(cls.programs)} on PATH"))

    def environment(self, folder: Path) -> Mapping[str, str] | None:  # noqa: ARG002
        """Return the environment of a process that works in a folder; None: the harness's own."""
        return None

    def identify(self) -> Provenance:
        """Return version and executable, asked once."""
        return self._identity

    @cached_property
    def _identity(self) -> Provenance:
        who = self.ask_version()
        # what a program says of itself goes to terminals and pages
        version = "".join(c if c.isprintable() else "?" for c in who.engine_version)
        return replace(who, engine_version=version, integrator=self.traits.integrator)

    @classmethod
    def fingerprint_of(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return the contents of the program and all that it runs, where that is known."""
        files = cls.installed_files(Path(cls.find(options.get("program"))))
        if not files:
            return None
        return facts(cls.name, "executable", files, cls.deciding_variables, cls.deciding(**options))

    @classmethod
    def installed_files(cls, program: Path) -> list[Path]:
        """Return the files that decide a result, the program first; none where not all are known.

        Here the program with its libraries, where that is ``self_contained``.
        """
        return program_files(program) if cls.self_contained else []

    @classmethod
    def deciding(cls, **options: Any) -> Mapping[str, str]:  # noqa: ARG003
        """Return the options, given or not, that decide a result and that no job states."""
        return {}

    def given(self) -> Mapping[str, Any]:
        """Return the options that this engine was opened with, for :meth:`deciding`."""
        return {}

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return :meth:`fingerprint_of` this program, read once."""
        return self._fingerprint

    @cached_property
    def _fingerprint(self) -> Mapping[str, Any] | None:
        return self.fingerprint_of(program=self.program, **self.given())

    def ask(self, words: Sequence[str], files: Mapping[str, str] = NO_FILES) -> tuple[str, Ended]:
        """Run a command once, beside these files; return what it says first and how it ended."""
        with fresh_folder() as folder:
            for name, text in files.items():
                (folder / name).write_text(text, encoding="utf-8")
            ended = self.start(words, folder, ASK_SECONDS)
            return first_text(folder / "said", 100_000), ended

    def closed_error(self) -> EngineError:
        """Return the error of a job that is given after :meth:`close`."""
        return EngineCrashError(f"{self.title} was closed")

    def close(self) -> None:
        """End what runs; whoever waits for it removes its files."""
        self.processes.close()

    def start(self, words: Sequence[str], folder: Path, seconds: float) -> Ended:
        """Run a command in a folder; a new file there is progress."""
        return self.processes.run(
            words,
            folder,
            seconds=seconds,
            memory=self.limits.memory,
            environment=self.environment(folder),
            progress=lambda: self.progress(folder),
        )

    def progress(self, folder: Path) -> int:
        """Return a number that changes as a process gets on: here how many files there are."""
        return len(list(folder.iterdir()))


def fresh_folder() -> AbstractContextManager[Path]:
    """Return a temporary folder, removed when its context ends, or by a run after kill -9."""
    return held_folder(Path(tempfile.gettempdir()))


def find_program(option: str, name: str) -> str:
    """Return the absolute path of a program, on PATH or beside this Python.

    Raise RequestError naming the option, such as ``lmp`` or ``program NAME=``.
    """
    beside = str(Path(sys.executable).parent)
    path = shutil.which(name) or shutil.which(name, path=beside)
    if path is None:
        option += "" if option.endswith("=") else " "
        raise RequestError(
            f"--{option}{name!r}: no such executable; give a path, or a name found on PATH"
        )
    return str(Path(path).absolute())


def launcher_of(ranks: int, program: str | None = None) -> str:
    """Return a command that starts ranks of MPI: of the program's installation, else on PATH.

    Another MPI's launcher would start as many runs of one rank. Without a program that is a path,
    the installation is that of this Python.
    """
    named = program if program and Path(program).name != program else sys.executable
    beside = Path(named).with_name("mpirun")
    return f"{shlex.quote(str(beside)) if beside.exists() else 'mpirun'} -n {ranks}"


def launcher_words(launcher: str | None) -> list[str]:
    """Return the words of an MPI launcher, its program as a path; raise RequestError for none."""
    try:
        words = shlex.split(launcher or "")
    except ValueError as error:
        raise RequestError(f"--mpirun {launcher!r} cannot be read: {error}") from None
    return [find_program("mpirun", words[0]), *words[1:]] if words else []
