"""Traits of an engine: the rules it follows, which decide its references.

Of contacts with friction it declares the contact models that it states, each under rules of its
own; ``engines/README.md`` says what else lets an engine take part in their cases. A job that no
model states is not tested there, with the reason; the others are held against the integration of
the law under the model's rules, on a ladder of steps. Where these rules move a quantity against the
integration under the default rules, that is a finding. The powers of the step in the errors are
those of velocity Verlet, and what :class:`ContactModel` names beside them for springs that turn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.model.conventions import Rules as ModelRules
    from harness.model.scene import Scene
    from harness.parameters.law import Contact


ContactValues = Mapping[str, str | int | float]
States = dict[str, tuple[str | int | float, ...]]

LAW = ("normal", "tangential")
"""Values of every job with such a contact, and of no other."""

RESISTANCES = frozenset(
    kind + part
    for kind in ("rolling", "twisting")
    for part in ("", "_stiffness", "_damping", "_friction")
)
"""Values of resistance to rolling and twisting: ``unused_values`` of a code that has none."""


MIXED = "partner_youngs_modulus"
"""A value of jobs with two materials that a code is to mix, and of no other."""

PLANES = "planes"
"""How many walls there are."""

DASHPOTS = "none velocity mass_velocity coeff_restitution"
"""Dampings of a linear spring."""


def takes(normal: str, damping: str, tangential: str, **more: str) -> States:
    """Return ``states`` of a model from the words that each value may be, with blanks between.

    By default it resists slip alone, and the code has one interface; ``more`` are other values.
    """
    law = {"normal": normal, "damping": damping, "tangential": tangential}
    states = {**law, "rolling": "none", "twisting": "none", "interface": "current", **more}
    return {name: tuple(text.split()) for name, text in states.items()}


@dataclass(frozen=True)
class ContactModel:
    """A contact model of a code, by the name that its authors give it.

    ``states`` are the words or numbers that a value of a job may be, by its name (``damping``,
    ``rolling``, ``clipped``: yes or no, ``interface``, ``planes``, ``motion_1``, ...); one that is
    not named may be any. ``needs`` returns why values that fit so far cannot be stated (a
    coefficient that the code ties to another), or nothing; ``nearest`` what the code puts in place
    of such values. ``rules`` is what
    :class:`~harness.parameters.rules.Rules` is told. ``turning`` are powers of the step in
    the errors of springs that turn. ``mixes``: it takes the materials
    of two bodies; another takes one, which a job may state in place of both.
    """

    name: str
    states: States = field(default_factory=dict)
    rules: Mapping[str, Any] = field(default_factory=dict)
    needs: Callable[[ContactValues], str] | None = None
    turning: tuple[float, ...] = ()
    mixes: bool = False
    nearest: Callable[[ContactValues], ContactValues] | None = None

    def fitting(self, values: ContactValues) -> tuple[int, str]:
        """Return how many values fit before the first that does not, and the name of that one."""
        for number, (name, supported) in enumerate(self.states.items()):
            if name in values and values[name] not in supported:
                return number, name
        return len(self.states), ""

    def lacks(self, values: ContactValues, name: str) -> str:
        """Return why it cannot state values of which ``name`` is the first that does not fit.

        Empty where that follows from the words that the value may be, and where it can.
        """
        if name == PLANES and self.states[name] == (0,):
            return "takes two spheres, and no wall"
        if name == "effective_mass" and self.states[name] == ("half",):
            return f"takes {name} = half, not {values[name]}: {HALF} states it"
        if MIXED in values and not (name or self.mixes):
            return "gets one material for both bodies here (materials_as = stated)"
        return self.needs(values) if self.needs and not name else ""


def never_attracts(values: ContactValues) -> str:
    """Return why a code that clips forces does not support a dashpot, or nothing where it does."""
    if values["damping"] != "none" and values["clipped"] != "yes":
        return "never attracts (clipped = yes)"
    return ""


def stating(models: Sequence[ContactModel], values: ContactValues) -> tuple[ContactModel, str]:
    """Return the first model that supports a job's contact and "", or the closest and its reasons.

    Models that are equally close each give a reason. Without models an empty one supports all.
    """
    if not models:
        return ContactModel(""), ""
    closest: list[tuple[ContactModel, str]] = []
    best = -1
    for model in models:
        fit, name = model.fitting(values)
        if not name and not model.lacks(values, name):
            return model, ""
        if fit > best:
            closest, best = [], fit
        if fit == best:
            closest.append((model, name))
    return closest[0][0], "; ".join(_refusals(closest, values))


def _refusals(closest: Sequence[tuple[ContactModel, str]], values: ContactValues) -> Iterator[str]:
    """Yield why models do not support values, a reason for each value and lack in common."""
    groups: dict[tuple[str, str], list[ContactModel]] = {}
    for model, name in closest:
        groups.setdefault((name, model.lacks(values, name)), []).append(model)
    for (name, reason), those in groups.items():
        names = _either(model.name for model in those)
        if reason:
            yield f"its {names} {reason}"
            continue
        supported = _either(str(word) for model in those for word in model.states[name])
        yield f"its {names} takes {name} = {supported}, not {values[name]}"


def _either(words: Iterable[str]) -> str:
    """Return words, each once, as in "a, b or c"."""
    *others, last = dict.fromkeys(words)
    return f"{', '.join(others)} or {last}" if others else last


HALF = "--set contact.effective_mass=half (of critical-angle --half-mass)"
"""Options that state half the mass."""


FRICTIONLESS: States = {
    "tail": ("attractive", "clipped"),
    "effective_mass": ("full", "half"),
    "law": ("overlap",),
}
"""Of contacts without friction, linear spring and dashpot, unless a code takes less: the rule for
the attractive tail, the effective mass against a fixed sphere, the law of several in a row."""

CLIPPED_ALONE = ContactModel("contact", FRICTIONLESS | {"tail": ("clipped",)})
"""Of a code whose contacts never attract."""


@dataclass(frozen=True)
class Traits:
    """The rules of an engine.

    ``integrator`` is the reference DEM's name for the engine's own scheme, or
    empty where it has none. ``frictionless`` is what it states of the contacts without friction,
    ``contact_models`` of those with it. ``digits`` are those of its output.
    ``microseconds_per_step`` is the cost of a step of ten particles, as the table of engines in
    ``reports/example`` has it, rounded up; 0 where runs have no step. ``lineage`` is the engine it
    grew out of: such a one is a regression partner, not independent evidence. ``install_hint``
    says in one line how to get it, ``versions`` with which ones it was tried. ``title`` is the
    engine's name as its authors write it; empty where that is its name in capitals.
    """

    install_hint: str
    versions: tuple[str, ...]
    integrator: str
    frictionless: ContactModel = ContactModel("contact", FRICTIONLESS)
    digits: int = 15
    microseconds_per_step: float = 1.0
    lineage: str = ""
    title: str = ""
    contact_models: tuple[ContactModel, ...] = ()
    """Of contacts with friction: what scripts are told of, and by which rules (see
    :mod:`harness.engines.traits`); without any, all that the scripts declare."""
    conventions: Callable[[Scene], ModelRules] | None = None
    """Of contacts, by the scene of spheres and walls; raises Unsupported. None: it runs none."""
    caveats: tuple[str, ...] = field(default=())
    """Traps that users fall into, a sentence each; the report shows them."""

    def missing(self, why: str) -> str:
        """Return why an engine is missing, with the install hint unless the reason has it."""
        return why if self.install_hint in why else f"{why}; to get it: {self.install_hint}"

    def refuses(self, values: Mapping[str, Any]) -> str:
        """Return why the engine's rules exclude the values of a job, or nothing where they do not.

        Values by their names in scripts; one that a job does not have excludes nothing.
        """
        rubs = all(name in values for name in LAW)
        return stating(self.contact_models if rubs else (self.frictionless,), values)[1]

    def refuses_contact(self, contact: Contact) -> str:
        """Return why the engine cannot state a contact, or nothing where it can."""
        from harness.parameters.law import contact_values

        return self.refuses(contact_values(contact))

    @property
    def fixed_values(self) -> dict[str, str]:
        """Return the values that the rules leave no choice in: scripts need none of them."""
        states = self.frictionless.states
        return {
            name: str(supported[0]) for name, supported in states.items() if len(supported) == 1
        }
