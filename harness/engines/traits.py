"""What an engine declares of itself: the rules it follows, which decide what it is held against."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from harness.engines.contact_model import ContactModel, stating

if TYPE_CHECKING:
    from harness.parameters.contact import Contact, EffectiveMass, Spring, Tail


HALF = "--set contact.effective_mass=half (of critical-angle --half-mass)"
"""Options that state half the mass."""


@dataclass(frozen=True)
class Traits:
    """The rules of an engine.

    ``integrator`` is the reference DEM's name for the engine's own scheme, or
    empty where it has none. ``effective_masses`` are those against a fixed sphere that it
    can be told; ``restitution_floor`` the least nominal restitution that
    it takes, ``most_damping`` its largest damping ratio. ``digits`` are those of its
    output. ``laws`` are those of several particles in a row. ``force_from_velocity`` says that
    its forces are changes of velocity over a step, which round as such.
    ``microseconds_per_step`` is the cost of a step of ten particles, as the table of engines in
    ``reports/example`` has it, rounded up; 0 where runs have no step. ``lineage`` is the engine it
    grew out of: such a one is a regression partner, not independent evidence. ``install_hint``
    says in one line how to get it, ``versions`` with which ones it was tried. ``title`` is the
    engine's name as its authors write it; empty where that is its name in capitals.
    """

    install_hint: str
    versions: tuple[str, ...]
    integrator: str
    tails: tuple[Tail, ...] = ("attractive", "clipped")
    effective_masses: tuple[EffectiveMass, ...] = ("full", "half")
    laws: tuple[str, ...] = ("overlap",)
    spring: Spring = "linear"
    restitution_floor: float = 0.0
    most_damping: float = 100.0
    digits: int = 15
    force_from_velocity: bool = False
    microseconds_per_step: float = 1.0
    lineage: str = ""
    title: str = ""
    contact_models: tuple[ContactModel, ...] = ()
    """Of contacts with friction: what scripts are told of, and by which rules (see
    :mod:`harness.engines.contact_model`); without any, all that the scripts declare."""
    contact_powers: tuple[float, ...] = ()
    """Of the step in the errors of such contacts, beside those of velocity Verlet."""
    caveats: tuple[str, ...] = field(default=())
    """Traps that users fall into, a sentence each; the report shows them."""

    def missing(self, why: str) -> str:
        """Return why an engine is missing, with how to get it where that is not said yet."""
        return why if self.install_hint in why else f"{why}; to get it: {self.install_hint}"

    def refuses(self, values: Mapping[str, Any]) -> str:
        """Return why the engine's rules exclude the values of a job, or nothing where they do not.

        Values by their names in scripts; one that a job does not have excludes nothing.
        """
        rules: tuple[tuple[str, tuple[str, ...], str], ...] = (
            ("tail", self.tails, "its contacts always have the {} tail"),
            ("effective_mass", self.effective_masses, "its effective mass on a fixed sphere is {}"),
            ("law", self.laws, "it has the {} law only"),
        )
        for name, known, text in rules:
            if name in values and values[name] not in known:
                told = f"{text.format(known[0])} ({name} = {values[name]!r})"
                return f"{told}; {HALF} states it" if known[0] == "half" else told
        nominal = values.get("restitution") if values.get("damping") == "restitution" else None
        if nominal is not None and nominal < self.restitution_floor:
            return f"its restitution is at least {self.restitution_floor:g}"
        if values.get("damping") == "ratio" and values["damping_ratio"] > self.most_damping:
            return f"its damping ratio is at most {self.most_damping:g}"
        if nominal == 0.0 and self.most_damping < 1.0:
            return f"its damping ratio is at most {self.most_damping:g}"
        return stating(self.contact_models, values)[1]

    def refuses_contact(self, contact: Contact) -> str:
        """Return why the engine cannot state a contact, or nothing where it can."""
        from harness.parameters.contact import contact_values

        return self.refuses(contact_values(contact))

    @property
    def fixed_values(self) -> dict[str, str]:
        """Return the values that the rules leave no choice in: scripts need none of them."""
        rules = {"tail": self.tails, "effective_mass": self.effective_masses, "law": self.laws}
        return {name: known[0] for name, known in rules.items() if len(known) == 1}
