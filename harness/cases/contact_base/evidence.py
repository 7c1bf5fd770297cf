"""What trials of a contact case leave: limits of their quantities, or why there are none."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from harness.cases.contact_base.motion import Motion
from harness.cases.contact_base.scans import Scanned
from harness.cases.contact_base.submodels import Trial
from harness.cases.contract import Reference
from harness.comparison.convergence import Limit
from harness.parameters.contact_rules import Rules


@dataclass(frozen=True)
class Tried:
    """A trial that an engine was given, and what is expected of it under the engine's ``rules``.

    ``finest`` are the parameters of the last rung, ``command`` is what runs one by hand.
    """

    trial: Trial
    references: Mapping[str, Reference]
    rules: Rules
    finest: Any
    command: str


@dataclass(frozen=True)
class Failed(Tried):
    """A trial without limits, of which ``command`` runs the rung that failed, and ``why`` it did.

    ``why`` goes on from the name of the engine.
    """

    why: str


@dataclass(frozen=True)
class Climbed(Tried):
    """What a trial left: limits of its quantities, and its finest motion, which ``command`` runs.

    ``plain`` is what is expected under the default rules. A force ``jumps`` within a step.
    ``levels`` are the parameters of the runs that the limits are of, and ``extrapolate`` makes
    limits of what such runs leave.
    """

    limits: Mapping[str, Limit]
    plain: Mapping[str, Reference]
    motion: Motion
    kinked: bool
    jumps: bool
    levels: tuple[Any, ...]
    extrapolate: Callable[[Sequence[Mapping[str, float]]], dict[str, Limit]]


@dataclass(frozen=True)
class Evidence:
    """The trials of a case in an engine, by its title, and its part of the figure of all codes.

    ``drawn``: with figures of all submodels, and on the page of each the curve that the law asks
    for: these take longer than the runs of level quick.
    """

    who: str
    climbed: tuple[Climbed, ...]
    scans: tuple[Scanned, ...] = ()
    drawn: bool = True
    failed: tuple[Failed, ...] = ()

    @property
    def tried(self) -> tuple[Tried, ...]:
        """Return all trials that ran, those that failed last."""
        return (*self.climbed, *self.failed)
