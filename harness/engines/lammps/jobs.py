"""What is handed to LAMMPS, and what comes back: one run of one script."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from harness.engines.lammps.scripts import Script
from harness.errors import EngineError
from harness.observables.provenance import Provenance


@dataclass(frozen=True)
class Job:
    """A script, the variables set for it, and whether it writes a series.

    ``deformable`` (height, stiffness [N/m], diameter [m]) has LAMMPS's ``fix
    external`` call the deformable law; only a library can.
    """

    script: Script
    variables: Mapping[str, str]
    series: bool = False
    deformable: tuple[int, float, float] | None = None


@dataclass(frozen=True)
class Output:
    """What a finished job left: its log, its series (if asked for), its wall time [s]."""

    log: str
    series: str | None
    seconds: float


Done = Callable[[int], None]
"""Called with the number of jobs just finished."""


class Runner(Protocol):
    """A way to run LAMMPS scripts: in-process or through an executable."""

    def identify(self) -> Provenance:
        """Return version, packages and executable."""
        ...

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the jobs; return what each left, or what went wrong with it, in order."""
        ...

    def close(self) -> None:
        """End all processes and remove all temporary files."""
        ...
