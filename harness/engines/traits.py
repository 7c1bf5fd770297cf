"""What an engine declares of itself: the rules it follows, which decide what it is held against."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from harness.parameters.contact import Contact, EffectiveMass, Tail


@dataclass(frozen=True)
class Traits:
    """The rules of an engine.

    ``integrator`` is the reference DEM's name for the engine's own scheme, or
    empty where it has none. ``effective_masses`` are those against a fixed sphere that it
    can be told; ``restitution_floor`` the least nominal restitution that
    it takes, ``most_damping`` its largest damping ratio. ``digits`` are those of its
    output. ``lineage`` is the engine it grew out of: such a one is a regression partner, not
    independent evidence. ``install_hint`` says in one line how to get it, ``versions`` with which
    ones it was tried.
    """

    install_hint: str
    versions: tuple[str, ...]
    integrator: str
    tails: tuple[Tail, ...] = ("attractive", "clipped")
    effective_masses: tuple[EffectiveMass, ...] = ("full", "half")
    spring: Literal["linear", "Hertz"] = "linear"
    restitution_floor: float = 0.0
    most_damping: float = 100.0
    digits: int = 15
    lineage: str = ""
    caveats: tuple[str, ...] = field(default=())
    """Traps that users fall into, a sentence each; the report shows them."""

    def missing(self, why: str) -> str:
        """Return why an engine is missing, with how to get it where that is not said yet."""
        return why if self.install_hint in why else f"{why}; to get it: {self.install_hint}"

    def refuses(self, contact: Contact) -> str:
        """Return why the engine cannot state a contact, or nothing where it can."""
        if contact.tail not in self.tails:
            return f"its contacts always have the {self.tails[0]} tail"
        if contact.effective_mass not in self.effective_masses:
            return f"its effective mass against a fixed sphere is {self.effective_masses[0]}"
        if contact.zeta > self.most_damping:
            return f"its damping ratio is at most {self.most_damping:g}"
        nominal = contact.restitution if contact.damping_ratio is None else None
        if nominal is not None and nominal < self.restitution_floor:
            return f"its restitution is at least {self.restitution_floor:g}"
        return ""
