"""The options of ``sweep`` that say where it runs."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Literal

from harness.cli.command import option

if TYPE_CHECKING:
    from harness.workflows.slurm_jobs import Settings

where_option = partial(option, panel="Where it runs")


@dataclass(frozen=True)
class ExecutorOptions:
    """Where runs are made, and what SLURM is asked for."""

    executor: Literal["local", "slurm"] = where_option(
        "local",
        "`local`: in this machine's workers. `slurm`: in arrays of jobs, with --output in a folder "
        "that the nodes see.",
    )
    partition: str | None = where_option(None, "SLURM's queue.", metavar="NAME")
    account: str | None = where_option(None, "Who is charged.", metavar="NAME")
    time: int = where_option(60, "Longest time of a job.", metavar="MINUTES", min=1)
    cpus: int = where_option(1, "Cores of a job, or of a rank.", metavar="COUNT", min=1)
    ranks: int = where_option(
        1,
        "MPI ranks of each run, started by `srun -n COUNT` unless --mpirun names another launcher, "
        "as `srun --mpi=pmi2 -n 4`.",
        metavar="COUNT",
        min=1,
    )
    chunk: int = where_option(50, "Runs of a job.", metavar="COUNT", min=1)
    sbatch: list[str] | None = where_option(
        None,
        "Another option of sbatch, as qos=long; repeat it for several.",
        metavar="KEY=VALUE",
    )

    def settings(self) -> Settings | None:
        """Return what SLURM is asked for, None for this machine.

        Raise RequestError for an option of SLURM without it, and where it is not here.
        """
        from harness.engines.typed import named_values
        from harness.errors import RequestError
        from harness.workflows.slurm_jobs import Settings
        from harness.workflows.slurm_queue import check_slurm

        if self.executor == "local":
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
