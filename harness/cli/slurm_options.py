"""The options of ``sweep`` that say where it runs."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from harness.workflows.slurm_jobs import Settings


@dataclass(frozen=True)
class ExecutorOptions:
    """Where runs are made, and what SLURM is asked for."""

    executor: Literal["local", "slurm"] = "local"
    partition: str | None = None
    account: str | None = None
    time: int = 60
    cpus: int = 1
    ranks: int = 1
    chunk: int = 50
    sbatch: list[str] | None = None

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
