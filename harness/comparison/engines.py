"""What an engine declares of itself, and what became of it here."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import computed_field


@dataclass(frozen=True)
class DeclaredEngine:
    """An engine's declared rules, copied for the report, and whether its results were used.

    ``version`` is empty where it could not be run, ``missing`` says why; ``unqualified``
    names the checks of its qualification that failed. ``lineage`` is the engine
    that it grew out of.
    """

    engine: str
    version: str
    how: str
    install_hint: str
    versions: tuple[str, ...]
    integrator: str
    tails: tuple[str, ...]
    effective_masses: tuple[str, ...]
    spring: str
    digits: int
    lineage: str
    caveats: tuple[str, ...]
    missing: str = ""
    unqualified: str = ""

    @computed_field  # type: ignore[prop-decorator]
    @property
    def summary(self) -> str:
        """Return whether the engine was used, and why not."""
        if self.missing:
            return "missing"
        return "did not qualify" if self.unqualified else "qualified"
