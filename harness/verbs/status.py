"""Which engines are here, in which version, how they are run, and why one is missing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from harness.engines.registry import open_engine
from harness.errors import EngineError, RequestError
from harness.observables.provenance import Provenance


@dataclass(frozen=True)
class EngineStatus:
    """One way to run an engine: who it is, or why it is missing."""

    engine: str
    how: str
    provenance: Provenance | None
    reason: str = ""

    def record(self) -> dict[str, Any]:
        """Return the status as a JSON-ready mapping."""
        found = self.provenance
        return {
            "engine": self.engine,
            "how": self.how,
            "available": found is not None,
            "engine_version": found.engine_version if found else None,
            "executable": found.executable if found else None,
            "packages": list(found.packages) if found else [],
            "reason": self.reason,
        }


def engines(*, lmp: str | None = None, launcher: str | None = None) -> list[EngineStatus]:
    """Return the status of LAMMPS in-process and as an executable, and of the reference DEM.

    The executable is ``lmp`` unless given.
    """
    ways = [("in-process", None, None), (launcher or "executable", lmp or "lmp", launcher)]
    lammps = [_status("lammps", how, path, start) for how, path, start in ways]
    return [*lammps, _status("reference", "compiled", None, None)]


def _status(name: str, how: str, lmp: str | None, launcher: str | None) -> EngineStatus:
    try:
        with open_engine(name, lmp=lmp, launcher=launcher) as engine:
            return EngineStatus(name, how, engine.identify())
    except (EngineError, RequestError) as error:
        return EngineStatus(name, how, None, str(error))
