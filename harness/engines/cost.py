"""The expected time of runs: steps times particles times the cost of a step.

The cost is :attr:`harness.engines.base.Traits.microseconds_per_step`. The product is good to a
factor of a few; the limit is for runs that take thousands of times longer than was thought.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.engines.base import Job, Traits

MOST_SECONDS = 600.0  # longer runs are refused without --force
STATED_SECONDS = 60.0  # the expected time of longer runs is printed before they begin
SLOWEST_STEP = 10.0  # [us] of a code that takes scripts with many particles
PARTICLES = 10  # of the system on which the costs were measured
SMALLER = "a coarser step, a softer contact or a smaller system"
_UNITS = (("years", 31_557_600.0), ("days", 86_400.0), ("hours", 3600.0), ("minutes", 60.0))


def job_seconds(job: Job, traits: Traits) -> float:
    """Return the expected time of a job [s]; 0 for a script without one.

    The time of a job is that of the slowest code, for which ``SLOWEST_STEP`` is the cost of a step.
    """
    if job.seconds:
        return job.seconds * min(1.0, traits.microseconds_per_step / SLOWEST_STEP)
    if job.scene is None:
        return 0.0
    size = max(1.0, len(job.scene.bodies) / PARTICLES)
    return (job.steps or job.scene.steps) * size * traits.microseconds_per_step * 1e-6


def check_duration(seconds: float, work: str, instead: str = "") -> None:
    """Raise RequestError for work that is expected to take more than :data:`MOST_SECONDS`.

    ``instead`` is what to request in its place.
    """
    if not seconds <= MOST_SECONDS:
        raise RequestError(
            f"{work} would take an estimated {in_words(seconds)} on one core, "
            f"{in_words(MOST_SECONDS)} are the limit: {instead or SMALLER}, or --force"
        )


def in_words(seconds: float) -> str:
    """Return a time in the largest unit of which it is one or more."""
    if not seconds < 1000 * _UNITS[0][1]:
        return "more than 1000 years"
    unit, size = next(((unit, size) for unit, size in _UNITS if seconds >= size), ("s", 1.0))
    return f"{seconds / size:.3g} {unit}"
