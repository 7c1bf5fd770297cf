"""A run of one of upstream's tests in LAMMPS: states at the ends of its segments, and the log."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.engines.lammps.language import closing_error, error_from_text
from harness.engines.process import Limits, Processes, fresh_folder, text_of
from harness.engines.programs import program_words
from harness.errors import EngineNaNError, EngineOutputError
from harness.upstream.definition import COLUMNS, State, UpstreamTest


@dataclass(frozen=True)
class RunOutput:
    """The state before the first step and after each segment, the log, and the step [time]."""

    states: tuple[State, ...]
    log: str
    timestep: float


def run_test(
    test: UpstreamTest, lmp: str, *, newton: str = "off", limits: Limits | None = None
) -> RunOutput:
    """Run a test once; ``newton`` is on or off. Raise EngineError for a run that failed."""
    with fresh_folder() as folder:
        log = _run_script(test.script(newton), lmp, folder, limits or Limits())
        states = tuple(
            read_state(folder / f"state.{number}", test.columns)
            for number in range(len(test.segments) + 1)
        )
    found = re.search(r"^TIMESTEP (\S+)$", log, flags=re.MULTILINE)
    if found is None:
        raise EngineOutputError("LAMMPS's log has no timestep")
    return RunOutput(states, log, float(found[1]))


def read_state(file: Path, columns: Sequence[str] = COLUMNS) -> State:
    """Return the columns of a dump, (N,) each.

    Raise EngineError for a dump that is cut or has a value that is not finite.
    """
    try:
        lines = file.read_text("utf-8").splitlines()
        rows = np.array([[float(word) for word in line.split()] for line in lines[9:]])
        box = np.array([[float(word) for word in line.split()] for line in lines[5:8]])
    except (OSError, ValueError):
        raise EngineOutputError(f"LAMMPS left no {file.name} that can be read") from None
    rows = rows.reshape(0, len(columns)) if not lines[9:] else rows
    if rows.ndim != 2 or rows.shape[1] != len(columns):
        raise EngineOutputError(f"LAMMPS left {file.name} without the columns of the script")
    if not np.isfinite(rows).all():
        raise EngineNaNError(f"LAMMPS wrote {file.name} with a value that is not a number")
    periodic = [flags == "pp" for flags in lines[4].split()[-3:]]
    length = box[:, 1] - box[:, 0] if box.shape[1] == 2 else np.inf  # of a box that is not tilted
    state = dict(zip(columns, rows.T, strict=True))
    return {**state, "period": np.where(periodic, length, np.nan)}


def _run_script(text: str, lmp: str, folder: Path, limits: Limits) -> str:
    """Run a script in a folder and return its log, with the commands."""
    (folder / "in.lmp").write_text(text, encoding="utf-8")
    options = ["-in", "in.lmp", "-log", "log.lammps", "-echo", "log", "-nocite"]
    words = [*program_words("lmp", lmp), *options]
    ended = Processes().run(words, folder, seconds=limits.seconds, memory=limits.memory)
    log = text_of(folder / "log.lammps") if (folder / "log.lammps").is_file() else ""
    error = ended.error("LAMMPS")
    if error is not None:
        if not ended.timed_out and closing_error(log or ended.said):
            error = error_from_text(log or ended.said, ended.code)
        raise error.with_log(f"{log}\n{ended.said}")
    return log
