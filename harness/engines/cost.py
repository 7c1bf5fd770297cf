"""What runs cost: estimated before they begin, and refused where they would hardly end.

An estimate is steps times particles times what a step costs: of an engine
:attr:`harness.engines.traits.Traits.microseconds_per_step`, of the solvers of towers
:mod:`harness.chain.slices`. It is good to a factor of a few; the limit is for runs that are
thousands of times longer than was thought.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from harness.engines.traits import Traits
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.engines.contract import Job

MOST_SECONDS = 600.0
"""The default verification takes one minute, the longest two: ten is none of this package's."""

OWN_SECONDS = 120.0
"""Of solvers of this package: what it shows takes them seconds."""

STATED_SECONDS = 10.0
"""What is expected to take longer is said beforehand."""

PARTICLES = 10
"""Of the system that the costs were measured on: one grain and nine fixed spheres."""

_UNITS = (("years", 31_557_600.0), ("days", 86_400.0), ("hours", 3600.0), ("minutes", 60.0))


def engine_seconds(steps: float, particles: int, rules: Traits) -> float:
    """Return what so many steps are expected to take an engine of these rules [s]."""
    return steps * max(1.0, particles / PARTICLES) * rules.microseconds_per_step * 1e-6


def job_seconds(job: Job, rules: Traits) -> float:
    """Return what a job's scene is expected to take [s]; 0 where there is none to tell from."""
    if job.template.scene is None:
        return 0.0
    scene = job.template.scene(job.values, rules.spring)
    return engine_seconds(scene.steps, len(scene.mass), rules)


SMALLER = "a coarser step, a softer contact or a smaller system"


def refuse_endless(
    seconds: float, what: str, most: float | None = None, instead: str = SMALLER
) -> None:
    """Raise RequestError for what is expected to take more than ``most`` seconds; ``what`` runs.

    That is :data:`MOST_SECONDS` unless given; ``instead`` is what could be asked for.
    """
    most = MOST_SECONDS if most is None else most
    if not seconds <= most:
        raise RequestError(
            f"{what} would take an estimated {in_words(seconds)} on one core, "
            f"{in_words(most)} are the limit: {instead}, or --force"
        )


def in_words(seconds: float) -> str:
    """Return a time in the largest unit of which it is one or more."""
    if not seconds < 1000 * _UNITS[0][1]:
        return "more than 1000 years"
    unit, size = next(((unit, size) for unit, size in _UNITS if seconds >= size), ("s", 1.0))
    return f"{seconds / size:.3g} {unit}"
