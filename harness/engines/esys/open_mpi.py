"""Open MPI, under which ESyS-Particle runs: its launcher, its environment, its words."""

from __future__ import annotations

import os
import shlex
import shutil
from collections.abc import Mapping
from pathlib import Path

from harness.engines.programs import find_program
from harness.errors import EngineMissingError, RequestError

LAUNCHERS = ("mpirun.openmpi", "mpirun")
"""Debian's ESyS-Particle belongs to Open MPI, whose launcher has this name there."""

RANKS = ("-np", "2")

OPEN_MPI = {
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
"""Runs go side by side on few cores: a rank that waits gives way, and none is bound to a core."""

TEMPORARY = ("OMPI_MCA_orte_tmpdir_base", "OMPI_MCA_btl_vader_backing_directory")
"""Where Open MPI keeps its files; a process that is killed leaves them, in its folder here."""

AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
"""In a container there is nobody else."""


def environment(folder: Path) -> Mapping[str, str]:
    """Return the environment of an Open MPI that keeps its files in a folder."""
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    temporary = dict.fromkeys(TEMPORARY, str(folder))
    return {**os.environ, **OPEN_MPI, **temporary, **(AS_ROOT if root else {})}


def without_frame(said: str) -> str:
    """Return what a process said without the lines of dashes that the launcher frames it in."""
    return "".join(f"{line}\n" for line in said.splitlines() if line.strip("-"))


def find_launcher(words: str | None) -> list[str]:
    """Return the launcher's words, its program as a path."""
    if words is not None:
        try:
            first, *options = shlex.split(words) or [""]
        except ValueError as error:
            raise RequestError(f"--mpirun {words!r}: {str(error).lower()}") from None
        return [find_program("mpirun", first), *options]
    for name in LAUNCHERS:
        path = shutil.which(name)
        if path is not None:
            return [path]
    raise EngineMissingError(
        "ESyS-Particle needs the launcher of Open MPI, mpirun.openmpi: apt install openmpi-bin"
    )
