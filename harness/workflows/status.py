"""Which engines are here, in which version, how they are run, and why one is missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from harness.engines.registry import ENGINES, engine_class, open_engine
from harness.engines.traits import Traits
from harness.errors import EngineError, RequestError
from harness.observables.provenance import Provenance

NOT_RUN = "-"
"""How an engine is run that is not here."""


@dataclass(frozen=True)
class EngineStatus:
    """One way to run an engine: who it is, or why it is missing; and what it declares."""

    engine: str
    how: str
    provenance: Provenance | None
    traits: Traits
    reason: str = ""

    def record(self) -> dict[str, Any]:
        """Return the status as a JSON-ready mapping."""
        found, declares = self.provenance, self.traits
        return {
            "engine": self.engine,
            "how": self.how,
            "available": found is not None,
            "engine_version": found.engine_version if found else None,
            "executable": found.executable if found else None,
            "packages": list(found.packages) if found else [],
            "reason": self.reason,
            "install_hint": declares.install_hint,
            "lineage": declares.lineage,
            "tails": list(declares.tails),
            "effective_masses": list(declares.effective_masses),
            "spring": declares.spring,
            "integrator": declares.integrator,
            "digits": declares.digits,
        }


def engines(
    *,
    lmp: str | None = None,
    launcher: str | None = None,
    programs: Mapping[str, str] | None = None,
) -> list[EngineStatus]:
    """Return the status of LAMMPS in-process and as an executable, and of every other engine.

    LAMMPS's executable is ``lmp`` unless given; ``programs`` are those of other engines by name.
    """
    found = [
        _status("lammps", "in-process", None, None, {}),
        _status("lammps", launcher or "executable", lmp or "lmp", launcher, {}),
    ]
    others = [name for name in ENGINES if name != "lammps"]
    return found + [_status(name, "", None, None, programs or {}) for name in others]


def _status(
    name: str, how: str, lmp: str | None, launcher: str | None, programs: Mapping[str, str]
) -> EngineStatus:
    traits = engine_class(name).traits
    try:
        with open_engine(name, lmp=lmp, launcher=launcher, programs=programs) as engine:
            who = engine.identify()
    except (EngineError, RequestError) as error:
        return EngineStatus(name, how or NOT_RUN, None, traits, traits.missing(str(error)))
    return EngineStatus(name, how or who.how, who, traits)
