"""Folders in which long runs leave restart files, from which a run that was cut goes on.

A script that can has the variables ``restart_every`` (steps, 0: never), ``restart_files`` (how
their names begin) and ``resume``. It begins anew at each restart file, whether it was cut there or
not, so the numbers of a run depend on ``restart_every`` and not on where it was cut. A folder
belongs to one script, its values and one LAMMPS; it is removed when the run has ended.

Two restart files take turns. Before a run goes on, the last one is looked at: where it is cut
short, the one before is taken, by the state of that time, where the script keeps it (``before``).
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import re
import shutil
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

from harness.engines.contract import RESTART_EVERY
from harness.engines.output import Output
from harness.engines.scripts import Script, Task
from harness.errors import EngineError, EngineInputError, EngineOutputError
from harness.files import lock_file

EVERY, FILES, RESUME = RESTART_EVERY, "restart_files", "resume"
NAME = "run"
STATE, BEFORE = f"{NAME}.state", f"{NAME}.before"
"""Written last: with it, the rest is whole; and the state before it."""

END = b"LammpS RestartT\0"
"""The last bytes of a restart file that is whole."""

BEGUN, SPENT = "begun", "seconds"
"""Files: when the part began that runs, and the wall time [s] of those before."""

PREFIX = "restarts-"
"""How the names of links to such folders begin, beside the script: paths may have spaces."""

ABANDONED_SECONDS = 60 * 86400.0


def can_resume(task: Task) -> bool:
    """Return whether a task writes restart files at all."""
    supported = leaves_restarts(task.script, sampled=task.job.sampled)
    return supported and int(task.values.get(EVERY, 0)) > 0


def leaves_restarts(script: Script, *, sampled: bool) -> bool:
    """Return whether a script can leave restart files, and keeps its series with them."""
    supported = {EVERY, FILES, RESUME} <= script.variables
    return supported and (not sampled or f"${{{FILES}}}.rows" in script.text)


def check_restored(log: str, program: str) -> None:
    """Raise EngineOutputError where a restart file holds what no fix of the run took.

    Such as the history of contacts.
    """
    lost = re.search(r"^Unused restart file .* fix info:\n((?:  .*\n)+)", log, re.MULTILINE)
    if lost is not None:
        unused = " ".join(lost[1].split())
        raise EngineOutputError(f"{program} lost what a restart file holds: {unused}")


class RestartFolder:
    """The folder of a task below ``place``, held until the end of the block.

    ``held`` is False where another process runs the same: it is not written into then. ``seconds``
    is the wall time up to the restart file that a run goes on from.
    """

    def __init__(self, place: Path, task: Task, identity: Mapping[str, Any]) -> None:
        facts = (task.script.sha256, sorted(task.values.items()), sorted(identity.items()))
        self.path = place.absolute() / hashlib.sha256(repr(facts).encode()).hexdigest()[:32]
        self._task = task
        self._files = contextlib.ExitStack()
        self.held = False
        self.seconds = 0.0

    def __enter__(self) -> Self:
        # without a place that can be written, and beside another process, it runs all the same
        with contextlib.suppress(OSError):
            self.path.mkdir(parents=True, exist_ok=True)
            lock = self._files.enter_context(lock_file(self.path.with_suffix(".lock")))
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self.held = True
            self._drop_abandoned()
            self._drop_cut()
            self.seconds = self._seconds_before()
        return self

    def __exit__(self, *_: object) -> None:
        self._files.close()

    @property
    def left_at(self) -> float:
        """Return when the last restart file was left [s]; 0 without one."""
        with contextlib.suppress(OSError):
            return (self.path / STATE).stat().st_mtime
        return 0.0

    @property
    def link(self) -> str:
        """Return the name of the link to it beside the script."""
        return f"{PREFIX}{self.path.name}"

    @property
    def task(self) -> Task:
        """Return the task with the names of its restart files, which goes on if they are there."""
        if not self.held:
            return self._task
        resume = "yes" if (self.path / STATE).is_file() else "no"
        files = {FILES: f"{self.link}/{NAME}", RESUME: resume}
        return replace(self._task, values={**self._task.values, **files})

    def ended(self, outcome: Output | EngineError) -> Output | EngineError:
        """Return an outcome with the wall time of all its parts.

        The files of a run that has ended, or that LAMMPS refuses to go on with, are removed.
        """
        refused = isinstance(outcome, EngineInputError | EngineOutputError)
        if self.held and (refused or isinstance(outcome, Output)):
            shutil.rmtree(self.path, ignore_errors=True)
            self.path.with_suffix(".lock").unlink(missing_ok=True)
        if isinstance(outcome, EngineError):
            return outcome
        return replace(outcome, seconds=outcome.seconds + self.seconds)

    def _seconds_before(self) -> float:
        """Return the wall time [s] of the parts before, and note when this one begins."""
        begun, spent, state = (self.path / name for name in (BEGUN, SPENT, STATE))
        seconds = 0.0
        with contextlib.suppress(OSError, ValueError):
            seconds = float(spent.read_text()) if spent.is_file() else 0.0
            seconds += max(0.0, state.stat().st_mtime - begun.stat().st_mtime)
        spent.write_text(repr(seconds))
        begun.touch()
        return seconds

    def _drop_cut(self) -> None:
        """Go back to the state before where the last restart file is cut short; to none if need be.

        A script that is killed between the moves of its two states has left the one before alone.
        """
        state, before = self.path / STATE, self.path / BEFORE
        if not is_whole(state):
            state.unlink(missing_ok=True)
            if is_whole(before):
                before.replace(state)

    def _drop_abandoned(self) -> None:
        oldest = time.time() - ABANDONED_SECONDS
        for other in self.path.parent.iterdir():
            with contextlib.suppress(OSError):
                if other.is_dir() and other.stat().st_mtime < oldest:
                    shutil.rmtree(other)


def is_whole(state: Path) -> bool:
    """Return whether a state is there and its restart file has its end."""
    with contextlib.suppress(OSError):
        turn = re.search(r"^variable turn equal ([01])$", state.read_text("utf-8"), re.MULTILINE)
        if turn is None:
            return False
        with (state.parent / f"{NAME}.{turn[1]}").open("rb") as file:
            file.seek(-len(END), os.SEEK_END)
            return file.read() == END
    return False


def link_into(folder: Path, path: Path) -> None:
    """Make the link to a folder of restart files beside a script."""
    link = folder / f"{PREFIX}{path.name}"
    if not link.is_symlink():
        link.symlink_to(path)


def progress_in(folder: Path) -> int:
    """Return a number that changes whenever a run of a folder has left restart files."""
    total = 0
    for state in folder.glob(f"{PREFIX}*/{STATE}"):
        with contextlib.suppress(OSError):
            total += state.stat().st_mtime_ns
    return total
