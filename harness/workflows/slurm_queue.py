"""What SLURM says of jobs: which are in its queue, and how one ended."""

from __future__ import annotations

import getpass
import re
import shutil
import subprocess
from collections.abc import Sequence

from harness.errors import RequestError

ASK_SECONDS = 60.0
MISSING = (
    "--executor slurm: there is no sbatch on PATH; run it where SLURM is, or leave --executor out"
)

USUAL = ("None", "Priority", "Resources", "BeginTime", "Prolog", "JobArrayTaskLimit")
"""Why a job waits that will run."""


def check_slurm() -> None:
    """Raise RequestError where SLURM or submitit is not here."""
    if shutil.which("sbatch") is None:
        raise RequestError(MISSING)
    try:
        import submitit  # noqa: F401
    except ImportError:
        raise RequestError(
            "--executor slurm: submitit is not installed: pip install 'dem-harness[slurm]'"
        ) from None


def queued() -> dict[str, str] | None:
    """Return why each job of this user waits, by its id as ``12`` or ``12_3``; None: no answer.

    The reason of one that runs is ``None`` in SLURM's words.
    """
    user = getpass.getuser()
    said = _said(["squeue", "--noheader", "--array", "--format=%i %r", f"--user={user}"])
    if said is None:
        return None
    return {line.partition(" ")[0]: line.partition(" ")[2] for line in said.splitlines()}


def end_of(job: str) -> str:
    """Return how a job ended in SLURM's word, as ``TIMEOUT`` or ``CANCELLED``."""
    told = _said(["scontrol", "--oneliner", "show", "job", job]) or ""
    shown = re.search(r"JobState=(\w+)", told)
    if shown:
        return shown[1]
    accounted = _said(["sacct", "--noheader", "--allocations", "--format=State", f"--jobs={job}"])
    return next(iter((accounted or "").split()), "GONE")


def _said(words: Sequence[str]) -> str | None:
    """Return what a command of SLURM prints; None where it fails or gives no answer."""
    try:
        done = subprocess.run(
            words, capture_output=True, text=True, timeout=ASK_SECONDS, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None
