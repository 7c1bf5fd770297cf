"""Traits of an engine: what lists and pages say of it, and how exact its output is."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Traits:
    """What an engine is.

    ``install_hint`` says in one line how to get it, ``versions`` with which ones it was tried.
    ``integrator`` is the scheme of its steps, by the reference's name. ``digits`` are those of its
    output: a check's tolerance is not below them. ``microseconds_per_step`` is the cost of a step
    of ten particles, rounded up; 0 where runs have no step. ``lineage`` is the engine it grew out
    of: such a one is a regression partner, not independent evidence. ``title`` is the engine's name
    as its authors write it; empty where that is its name in capitals. ``caveats`` are traps that
    users fall into, a sentence each.
    """

    install_hint: str
    versions: tuple[str, ...]
    integrator: str = "velocity-verlet"
    digits: int = 15
    microseconds_per_step: float = 1.0
    lineage: str = ""
    title: str = ""
    caveats: tuple[str, ...] = field(default=())

    def missing(self, why: str) -> str:
        """Return why an engine is missing, with the install hint unless the reason has it."""
        return why if self.install_hint in why else f"{why}; to get it: {self.install_hint}"
