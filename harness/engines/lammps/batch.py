"""Many runs in one process of LAMMPS, or of a code with its language: input, and what it left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from harness.engines.lammps.jobs import Job, Output
from harness.engines.lammps.read import LAST_RESULT, error_from_text
from harness.engines.lammps.scripts import Script
from harness.engines.process import Ended, text_of
from harness.errors import EngineError, EngineTimeoutError


def write_batch(jobs: Sequence[Job], folder: Path, forget: Callable[[Script], list[str]]) -> None:
    """Write ``batch.in``, which runs the jobs in turn, each from a clean slate, and the scripts.

    ``forget`` names the variables that an earlier run may have left.
    """
    lines: list[str] = []
    for index, job in enumerate(jobs):
        script = folder / f"{job.script.sha256[:16]}-{job.script.name}"
        if not script.exists():
            script.write_text(job.script.text, encoding="utf-8")
        variables = dict(job.variables)
        if job.series:
            variables |= {"series": f"{index}.csv"}
        lines += [f"log {index}.log", "clear"]
        lines += [f"variable {name} delete" for name in forget(job.script)]
        lines += [f"variable {name} index {value}" for name, value in variables.items()]
        lines.append(f"include {script.name}")
    (folder / "batch.in").write_text("\n".join(lines) + "\n", encoding="utf-8")


def read_batch(
    jobs: Sequence[Job],
    folder: Path,
    ended: Ended,
    *,
    who: str,
    program: str,
    seconds: float,
    clean: Callable[[str], str] = str,
) -> list[Output | EngineError]:
    """Return what the finished jobs left, and one error if the process died.

    ``who`` is the code, ``seconds`` the time that each job was given; logs are cleaned first.
    """
    done: list[Output | EngineError] = []
    for index, job in enumerate(jobs):
        log = clean(text_of(folder / f"{index}.log"))
        if LAST_RESULT not in log:
            error = error_from_text(log if "ERROR" in log else ended.said, ended.code, who)
            if ended.timed_out:
                error = EngineTimeoutError(f"{who} ({program}) did not finish within {seconds:g} s")
            error.log = "\n".join(text for text in (log, ended.said) if text)
            return [*done, error]
        series = text_of(folder / f"{index}.csv") if job.series else None
        done.append(Output(log, series, ended.seconds / len(jobs)))
    return done
