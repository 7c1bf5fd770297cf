"""LAMMPS on several MPI ranks: what its launcher must do, and how ranks wait for one another."""

from __future__ import annotations

import re

from harness.engines.process import Ended, first_words
from harness.errors import EngineMissingError

SLEEPING = {
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE": "1",
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE_NO_PROGRESS_COUNT": "100",
}
"""Environment in which ranks of MPICH that wait sleep after so many looks.

Where there are more ranks than cores, those that look without end keep the others from their core:
four ranks of a contact on two cores take a fifth of the time with it. Other libraries ignore it.
"""


def check_greeting(said: str, ended: Ended, launcher: str, program: str) -> None:
    """Raise EngineMissingError unless what was said is that of one LAMMPS on all ranks.

    A launcher of another MPI library than LAMMPS's starts as many separate LAMMPS as it has ranks,
    which would write over each other's files.
    """
    greetings = len(re.findall(r"^LAMMPS \(", said, re.MULTILINE))
    if greetings == 1 and ended.code == 0 and not ended.timed_out:
        return
    if greetings > 1:
        raise EngineMissingError(
            f"--mpirun {launcher!r} started {greetings} separate LAMMPS instead of one on all "
            f"ranks: launcher and {program} belong to different MPI libraries"
        )
    reason = "it gave no answer"
    if not ended.timed_out:
        reason = f"exit status {ended.code}{first_words(said)}"
    raise EngineMissingError(f"--mpirun {launcher!r} does not run {program}: {reason}")
