"""Known defects of codes: cause, releases, and the switch of the reference that reproduces them.

A run that fails, and passes against the reference with the switch, has the defect: it is counted,
never a pass. A run that passes although the switch would move it is free of the defect.
``inputs/known-defects.toml`` has the entries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import product
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from harness.engines.output import release_of
from harness.model.base import Parameters
from harness.model.conventions import Faults, Rules
from harness.model.law import Law
from harness.model.scene import Motion, Scene
from harness.results.rows import Row
from harness.results.switches import FITS, check_switch, switched_motion

SWITCHES: Mapping[str, type[Parameters]] = {"faults": Faults, "rules": Rules, "law": Law}
Motions = Mapping[Scene, Motion]
Holds = Callable[[Motions], bool]
Patterns = tuple[str, ...]


class KnownDefect(Parameters):
    """A defect: in which rows of which releases it acts, why, and what it makes of a run.

    ``laws`` and ``systems`` are patterns of the two parts of a setup "LAW, SYSTEM", ``variations``
    of a row's ``check``; * and ? match. Exactly one effect is given: fields of ``faults``,
    ``rules`` and ``law`` of the reference, a text where a value or coefficient of the scene is
    meant; the name of an unknown to ``fit``; an ``error``, part of the message with which the run
    ends; or the reason why the effect is ``undetermined``.
    """

    # fmt: off
    name: str = Field(description="[-]")
    engine: str = Field(description="[-]")
    cases: Patterns = Field(("*",), min_length=1, description="[-]")
    laws: Patterns = Field(("*",), min_length=1, description="[-]")
    systems: Patterns = Field(("*",), min_length=1, description="[-]")
    variations: Patterns = Field(
        ("",), min_length=1, description="[-] that it breaks; empty: the plain run, and all others")
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
        effects = [self.switched, bool(self.fit), bool(self.error), bool(self.undetermined)]
        if sum(effects) != 1:
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
        """Return its effect on a run in words."""
        if self.error:
            return f"the run ends with “{self.error}”"
        if self.undetermined:
            return f"not computed: {self.undetermined}"
        if self.fit:
            return f"{self.fit}, fitted on the first sample that shows it; all later ones agree"
        values = {f"{part}.{k}": v for part in SWITCHES for k, v in getattr(self, part).items()}
        return ", ".join(name if v is True else f"{name} = {v}" for name, v in values.items())

    @property
    def note(self) -> str:
        """Return its line in a report."""
        pointer = f"; {self.script} shows it" if self.script else ""
        word = "known defect" if self.kind == "defect" else self.kind
        return f"{word} {self.name}: {self.cause}; upstream: {self.upstream}{pointer}"

    def concerns(self, row: Row) -> bool:
        """Return whether it may act in a row: its case, setup, engine, check and version."""
        checks = ("*",) if "" in self.variations else self.variations
        return (
            row.engine == self.engine
            and _any_matches(row.case, self.cases)
            and _any_matches(row.setup, map(_setup_pattern, product(self.laws, self.systems)))
            and _any_matches(row.check, checks)
            and self._has_release(row.version)
        )

    def _has_release(self, version: str) -> bool:
        release, last = release_of(version), release_of(self.until)
        if last and not release:
            return False  # a version without numbers is not known to have it
        return release >= release_of(self.since) and (not last or release[: len(last)] <= last)


@dataclass(frozen=True)
class Trial:
    """A run of one or more scenes that is to be explained.

    ``holds`` returns whether all its rows pass against other motions of the reference. ``motion``
    is that of its only scene, None for several scenes, or without a motion of the run.
    """

    rules: Mapping[Scene, Rules]
    holds: Holds
    motion: Motion | None = None

    def holds_with(self, defects: Sequence[KnownDefect], **fitted: Any) -> bool:
        """Return whether all rows pass with the switches of defects."""
        motions = self.motions(defects, **fitted)
        return motions is not None and self.holds(motions)

    def motions(self, defects: Sequence[KnownDefect], **fitted: Any) -> Motions | None:
        """Return the motions with defects, the first of which prevail; None where there is none."""
        changes: dict[str, dict[str, Any]] = {part: {} for part in SWITCHES}
        for defect in reversed(defects):
            for part, values in changes.items():
                values.update(getattr(defect, part))
        motions = {}
        for scene, rules in self.rules.items():
            motion = switched_motion(scene, rules, changes, fitted)
            if motion is None:
                return None
            motions[scene] = motion
        return motions


def explanation(defects: Sequence[KnownDefect], trial: Trial) -> KnownDefect | None:
    """Return the known defect of a failing run, None where none explains all its rows.

    Of defects that act together, the first without which the run does not hold is returned.
    """
    return next(_explanations(defects, trial), None)


def error_defect(defects: Sequence[KnownDefect], message: str) -> KnownDefect | None:
    """Return the defect whose error is part of the message of a run that failed."""
    return next((d for d in defects if d.error and d.error in message), None)


def _explanations(defects: Sequence[KnownDefect], trial: Trial) -> Iterator[KnownDefect]:
    switched = tuple(d for d in defects if d.switched)
    groups: list[tuple[KnownDefect, ...]] = [(d,) for d in switched]
    if len(switched) > 1:
        groups += [switched, *(_without(switched, d) for d in switched)]
    for group in groups:
        if trial.holds_with(group):
            needed = [d for d in group if not trial.holds_with(_without(group, d))]
            yield (needed or group)[0]
    yield from (d for d in defects if d.fit and _fits(d, switched, trial))


def _fits(defect: KnownDefect, switched: Sequence[KnownDefect], trial: Trial) -> bool:
    """Return whether a run passes with the unknown of a defect, alone or with others."""
    if trial.motion is None:
        return False
    (scene,) = trial.rules
    fit, observed = FITS[defect.fit], trial.motion

    def run_with(others: Sequence[KnownDefect]) -> Callable[..., Motion | None]:
        return lambda **fitted: (trial.motions(others, **fitted) or {}).get(scene)

    def holds(motion: Motion) -> bool:
        return trial.holds({scene: motion})

    return any(fit(run_with(others), scene, observed, holds) for others in ((), switched))


def _without(group: tuple[KnownDefect, ...], other: KnownDefect) -> tuple[KnownDefect, ...]:
    return tuple(defect for defect in group if defect is not other)


def _any_matches(name: str, patterns: Any) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def _setup_pattern(parts: tuple[str, str]) -> str:
    """Return the pattern of "LAW, SYSTEM"; any setup, also of one part, where both are free."""
    return "*" if parts == ("*", "*") else ", ".join(parts)
