"""The options of ``sweep`` that say where it runs."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from harness.workflows.slurm_jobs import Settings

_PANEL = "Where it runs"


class Where(StrEnum):
    """What runs the jobs."""

    LOCAL = "local"
    SLURM = "slurm"


def _option(name: str, metavar: str, told: str, **more: Any) -> Any:
    return typer.Option(name, metavar=metavar, help=told, rich_help_panel=_PANEL, **more)


@dataclass(frozen=True)
class ExecutorOptions:
    """Where runs are made, and what SLURM is asked for."""

    executor: Annotated[
        Where,
        typer.Option(
            help="`local`: in this machine's workers. `slurm`: in arrays of jobs, with "
            "--output in a folder that the nodes see.",
            rich_help_panel=_PANEL,
        ),
    ] = Where.LOCAL
    partition: Annotated[str | None, _option("--partition", "NAME", "SLURM's queue.")] = None
    account: Annotated[str | None, _option("--account", "NAME", "Who is charged.")] = None
    time: Annotated[int, _option("--time", "MINUTES", "Longest time of a job.", min=1)] = 60
    cpus: Annotated[int, _option("--cpus", "COUNT", "Cores of a job, or of a rank.", min=1)] = 1
    ranks: Annotated[
        int,
        _option(
            "--ranks",
            "COUNT",
            "MPI ranks of each run, started by `srun -n COUNT` unless --mpirun names another "
            "launcher, as `srun --mpi=pmi2 -n 4`.",
            min=1,
        ),
    ] = 1
    chunk: Annotated[int, _option("--chunk", "COUNT", "Runs of a job.", min=1)] = 50
    sbatch: Annotated[
        list[str] | None,
        _option(
            "--sbatch", "KEY=VALUE", "Another option of sbatch, as qos=long; repeat it for several."
        ),
    ] = None

    def settings(self) -> Settings | None:
        """Return what SLURM is asked for, None for this machine.

        Raise RequestError for an option of SLURM without it, and where it is not here.
        """
        from harness.cli.lists import named_values
        from harness.errors import RequestError
        from harness.workflows.slurm_jobs import Settings
        from harness.workflows.slurm_queue import check_slurm

        if self.executor is Where.LOCAL:
            for one in fields(self):
                value = getattr(self, one.name)
                if value not in (one.default, []):
                    raise RequestError(f"--{one.name} {value}: goes with --executor slurm only")
            return None
        check_slurm()
        extra = named_values(self.sbatch or (), "--sbatch")
        return Settings(
            self.partition, self.account, self.time, self.cpus, self.ranks, self.chunk, extra
        )

    def launcher(self, named: str | None) -> str | None:
        """Return the launcher of an MPI run: the one that is named, or the scheduler's."""
        return f"srun -n {self.ranks}" if named is None and self.ranks > 1 else named
