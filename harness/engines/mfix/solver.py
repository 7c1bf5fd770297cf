"""Run ``mfixsolver``: ask for its version, and run an input in a fresh folder."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from harness.engines.mfix.scripts import FORCE, GRAIN, KEYWORDS
from harness.engines.mfix.vtp import Frame, read_frames
from harness.engines.process import Ended, Limits, Processes, first_text, first_words, way_of_death
from harness.engines.programs import fresh_folder
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
)

HELP_SECONDS = 60.0
SAID = 100_000
"""Bytes that are read of an answer."""

IN_HELP = ("mfix.dat", "<KEYWORD>=<VALUE>", "--print-flags")
"""What the help of a batch solver speaks of, and that of no other program (``mfix.f``)."""

OLDEST = (21, 3)
"""The version whose source the inputs follow; older ones lack some of the keywords."""

UNVERSIONED = "unversioned"
"""The version of a build that was not told its own: cmake then writes 0.0, or in a checkout
without tags nothing."""

TRAPPED = (
    "its builds stop at a division by zero, an overflow or a value that is not a number; look for "
    "a restitution of 0, a step too coarse for the contact, numbers beyond 1e38 in its output"
)
"""What raises SIGFPE: cmake compiles with ``-ffpe-trap=invalid,zero,overflow``, in 21.3.2."""

REFUSAL = re.compile(r"^.*\b(?:Error|ERROR) \d+:.*$", re.MULTILINE)
"""What a numbered refusal of an input begins with."""

UNNUMBERED = re.compile(
    r"^ *(?:Illegal or unknown input|Invalid|Required input not specified)\b.*$", re.MULTILINE
)
"""What a refusal without a number begins with; the solver ends without a run."""


@dataclass(frozen=True)
class Run:
    """What a run left: frames of particles and of forces, wall time [s], and its words."""

    frames: list[Frame]
    forces: list[Frame]
    seconds: float
    log: str


def version_of(program: str) -> str:
    """Return the version that a solver names, UNVERSIONED where it was built without one.

    Raise EngineMissingError where it is no MFiX, which is known by its help, or too old a version.
    """
    help_text, usage = _answer(program, "--help")
    if usage.timed_out:
        raise EngineMissingError(
            f"--program mfix={program} does not run: no answer within {HELP_SECONDS:g} s"
        )
    if not all(word in help_text for word in IN_HELP):
        raise EngineMissingError(
            f"--program mfix={program} is not an MFiX solver: its --help does not speak of "
            f"{IN_HELP[0]}{first_words(help_text)}"
        )
    text, answer = _answer(program, "--version")
    found = re.fullmatch(r"v?(\d+)\.(\d+)[\w.+-]*", text.strip())
    if answer.code != 0:
        raise EngineMissingError(
            f"--program mfix={program} is not an MFiX solver: --version gave no version"
            f"{first_words(text)}"
        )
    if found is None or found[1] == found[2] == "0":
        return UNVERSIONED
    if (int(found[1]), int(found[2])) < OLDEST:
        raise EngineMissingError(
            f"--program mfix={program} is version {found[0]}: must be 21.3 or later (tried: 21.3.2)"
        )
    return found[0]


def _answer(program: str, option: str) -> tuple[str, Ended]:
    """Return what a program says to an option, and how it ended."""
    with fresh_folder() as folder:
        ended = Processes().run(
            [program, option], folder, seconds=HELP_SECONDS, memory=Limits().memory
        )
        return first_text(folder / "said", SAID), ended


class Solver:
    """Runs inputs, one process and one fresh folder each: MFiX takes one input a start.

    A folder of its own for each: what an earlier run left (``.RES``) stops a new one.
    """

    def __init__(self, program: str, limits: Limits) -> None:
        self._program, self._limits = program, limits
        self._files = ExitStack()
        self._folder = self._files.enter_context(fresh_folder())
        self._processes = Processes()

    def run(self, texts: Mapping[str, str]) -> Run | EngineError:
        """Run files; return what they left, or the error with them and last words as its log."""
        if self._processes.closed:
            return EngineCrashError(f"MFiX ({self._program}) was closed")
        with tempfile.TemporaryDirectory(dir=self._folder) as name:
            folder = Path(name)
            for file, text in texts.items():
                (folder / file).write_text(text, encoding="utf-8")
            ended = self._processes.run(
                [self._program, "-f", KEYWORDS],
                folder,
                seconds=self._limits.seconds,
                memory=self._limits.memory,
            )
            again = f"# {Path(self._program).name} -f {KEYWORDS}"
            log = "\n".join(
                [again, *(f"# {file}\n{text}" for file, text in texts.items()), ended.said]
            )
            try:
                return self._output(folder, ended, log)
            except EngineError as error:
                error.log = log
                return error

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self._processes.close()
        self._files.close()

    def _output(self, folder: Path, ended: Ended, log: str) -> Run:
        refusal = REFUSAL.search(ended.said)
        if refusal is None and (ended.code != 0 or not any(folder.glob(f"{GRAIN}_*.vtp"))):
            refusal = UNNUMBERED.search(ended.said)
        if refusal is not None and not ended.timed_out:
            raise EngineInputError(f"MFiX refused its input: {refusal[0].strip()[:160]}")
        if way_of_death(ended.code) == "signal SIGFPE" and not ended.timed_out:
            raise EngineNaNError(f"MFiX died: signal SIGFPE: {TRAPPED}")
        error = ended.error(f"MFiX ({self._program})", self._limits.seconds)
        if error is not None:
            raise error
        frames = read_frames(folder, GRAIN)
        if not frames:
            raise EngineOutputError(f"MFiX wrote no particles{first_words(ended.said)}")
        return Run(frames, read_frames(folder, FORCE), ended.seconds, log)
