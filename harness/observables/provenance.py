"""Provenance of a result: engine, version, how it was run, script."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Provenance:
    """Identify the engine behind a result.

    ``how`` is ``in-process``, ``executable``, the launcher that started it, or
    ``compiled``.
    """

    engine: str
    engine_version: str
    packages: tuple[str, ...] = field(default=(), repr=False)
    executable: str = ""
    how: str = ""
    script: str = ""
    script_sha256: str = ""
    integrator: str = ""

    @property
    def told(self) -> str:
        """Return the engine with its version, and how it was run."""
        return ", ".join(filter(None, (f"{self.engine} {self.engine_version}".strip(), self.how)))

    def record(self) -> dict[str, Any]:
        """Return the fields as a JSON-ready mapping."""
        return {**asdict(self), "packages": list(self.packages)}
