"""Known defects of codes: cause, releases, and the switch of the reference that has them.

A run that fails and holds to its tolerance against the reference with the switch is that defect:
shown, counted apart, never a pass. Where it holds without, though the switch moves it, the defect
is gone. ``inputs/known-defects.toml`` has the entries.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import partial
from typing import Any, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from harness.comparison.defect_fits import FITS, Holds
from harness.comparison.defect_values import check_switch, value_in, with_law
from harness.comparison.verdicts import Check
from harness.errors import EngineError, EngineNaNError, RequestError
from harness.model.base import Parameters
from harness.model.conventions import Faults, Rules
from harness.model.law import Law
from harness.model.motion import Motion
from harness.model.scene import Scene
from harness.observables.provenance import release_of

SWITCHES: Mapping[str, type[Parameters]] = {"faults": Faults, "rules": Rules, "law": Law}


class Place(NamedTuple):
    """A row of the matrix; ``variation`` is empty for the plain run."""

    case: str
    submodel: str
    system: str
    engine: str
    variation: str = ""


class KnownDefect(Parameters):
    """A defect: where and in which releases it acts, why, and what it makes of a run.

    One of these: fields of ``faults``, ``rules`` and ``law`` that the reference takes, a number
    where it needs one by the name of a value or of a coefficient; an unknown that is a ``fit``;
    an ``error``, part of the message of the run; the reason why it is ``undetermined``.
    """

    # fmt: off
    name: str = Field(description="[-]")
    engine: str = Field(description="[-]")
    cases: tuple[str, ...] = Field(("*",), min_length=1, description="[-] with * and ?")
    submodels: tuple[str, ...] = Field(("*",), min_length=1, description="[-] with * and ?")
    systems: tuple[str, ...] = Field(("*",), min_length=1, description="[-] with * and ?")
    variations: tuple[str, ...] = Field(
        ("",), min_length=1, description="[-] that it breaks; empty for the plain run, and all")
    kind: Literal["defect", "documented limitation"] = Field("defect", description="[-]")
    cause: str = Field(min_length=20, description="[-]")
    since: str = Field("", description="[-] first release known to have it, empty for all")
    until: str = Field("", description="[-] last release known to have it, empty for all")
    upstream: str = Field(min_length=5, description="[-] what its developers wrote of it")
    script: str = Field("", description="[-] file that shows it with the engine alone")
    faults: dict[str, Any] = Field({}, description="[-]")
    rules: dict[str, Any] = Field({}, description="[-]")
    law: dict[str, Any] = Field({}, description="[-]")
    fit: Literal["", "torsion_reversed_at", "setup_torque"] = Field("", description="[-]")
    error: str = Field("", description="[-]")
    undetermined: str = Field("", description="[-]")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Self:
        given = [self.switched, bool(self.fit), bool(self.error), bool(self.undetermined)]
        if sum(given) != 1:
            raise ValueError("needs one of faults, rules and law; fit; error; undetermined")
        for part, kind in SWITCHES.items():
            check_switch(part, kind, getattr(self, part))
        return self

    @property
    def switched(self) -> bool:
        """Return whether the reference has a switch of it without an unknown."""
        return bool(self.faults or self.rules or self.law)

    @property
    def effect(self) -> str:
        """Return in words what it makes of a run."""
        if self.error:
            return f"the run ends with “{self.error}”"
        if self.undetermined:
            return f"not computed: {self.undetermined}"
        if self.fit:
            return f"{self.fit}, fitted on the first sample that shows it, and held by all later"
        values = {f"{part}.{k}": v for part in SWITCHES for k, v in getattr(self, part).items()}
        return ", ".join(name if v is True else f"{name} = {v}" for name, v in values.items())

    @property
    def note(self) -> str:
        """Return its line in a report."""
        pointer = f"; {self.script} shows it" if self.script else ""
        word = "known defect" if self.kind == "defect" else self.kind
        return f"{word} {self.name}: {self.cause}; upstream: {self.upstream}{pointer}"

    def concerns(self, place: Place, version: str) -> bool:
        """Return whether it acts at a place, in a release that is known to have it."""
        broken = ("*",) if "" in self.variations else self.variations
        patterns = (self.cases, self.submodels, self.systems, (self.engine,), broken)
        for name, allowed in zip(place, patterns, strict=True):
            if not any(fnmatchcase(name, pattern) for pattern in allowed):
                return False
        here, last = release_of(version), release_of(self.until)
        if last and not here:
            return False  # a version that cannot be read is not known to have it
        return here >= release_of(self.since) and (not last or here[: len(last)] <= last)


def defect_of(check: Check) -> str:
    """Return the name of the known defect that a check is marked with; empty without one."""
    return check.cell.defect if check.cell is not None else ""


def concerned(
    defects: Sequence[KnownDefect], place: Sequence[str], version: str
) -> tuple[KnownDefect, ...]:
    """Return the defects that may act at a place (case, submodel, system, engine, variation)."""
    return tuple(d for d in defects if d.concerns(Place(*place), version))


def explain(
    defects: Sequence[KnownDefect], place: Sequence[str], version: str, scene: Scene, rules: Rules,
    outcome: Motion | EngineError, holds: Holds,
) -> KnownDefect | None:  # fmt: skip
    """Return the known defect that a run has, None where none makes this of it.

    ``holds`` tells whether all rows of the run hold against a motion of the reference. Of defects
    that act together the first is returned without which it does not hold. One that is
    undetermined is returned where no other explains the run: it is not tested.
    """
    here = concerned(defects, place, version)
    if isinstance(outcome, EngineError):
        message = f"{outcome.kind}: {outcome}"
        return next((d for d in here if d.error and d.error in message), None)
    if holding := next(_explanations(here, scene, rules, outcome, holds), None):
        return holding
    return next((d for d in here if d.undetermined), None)


def is_fixed(defect: KnownDefect, scene: Scene, rules: Rules, holds: Holds) -> bool:
    """Return whether a run that holds does not have a defect that acts at its place."""
    if not defect.switched:
        return bool(defect.error)  # what is fitted may be zero
    motion = _motion((defect,), scene, rules)
    return motion is not None and not holds(motion)


def _explanations(
    here: Sequence[KnownDefect], scene: Scene, rules: Rules, theirs: Motion, holds: Holds
) -> Iterator[KnownDefect]:
    def explains(chosen: Sequence[KnownDefect]) -> bool:
        motion = _motion(chosen, scene, rules)
        return motion is not None and holds(motion)

    switched = tuple(d for d in here if d.switched)
    groups: list[tuple[KnownDefect, ...]] = [(d,) for d in switched]
    if len(switched) > 1:
        groups += [switched, *(_without(switched, d) for d in switched)]
    for group in groups:
        if explains(group):
            needed = [d for d in group if not explains(_without(group, d))]
            yield (needed or group)[0]
    for defect in here:
        if defect.fit and any(
            FITS[defect.fit](partial(_motion, others, scene, rules), scene, theirs, holds)
            for others in ((), switched)
        ):
            yield defect


def _without(group: tuple[KnownDefect, ...], one: KnownDefect) -> tuple[KnownDefect, ...]:
    return tuple(defect for defect in group if defect is not one)


def _motion(
    defects: Sequence[KnownDefect], scene: Scene, rules: Rules, **fitted: Any
) -> Motion | None:
    """Return the reference with defects, of which the first prevail; None without a motion."""
    from harness.solvers import reference  # compiled: slow to import

    changes: dict[str, dict[str, Any]] = {part: {} for part in SWITCHES}
    for defect in reversed(defects):
        for part, values in changes.items():
            values |= {n: value_in(scene, v, n) for n, v in getattr(defect, part).items()}
    try:
        scene = with_law(scene, changes["law"]) if changes["law"] else scene
        faults = Faults(**changes["faults"], **fitted)
        return reference.run(scene, rules.replace(**changes["rules"]), faults)
    except (RequestError, EngineNaNError):
        return None
