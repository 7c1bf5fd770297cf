"""Run compiled loops a slice at a time: an interrupt is heard, and progress told, in between.

The state between two slices is that between two steps: a run in slices is the same to the last
bit. How long a slice takes, and a run, follows from what a step costs.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from harness.chain.record import Record
from harness.compiled import shielded
from harness.parameters.tower import Law

SLICE_SECONDS = 0.3

STEP_SECONDS: dict[Law, tuple[float, float]] = {
    "overlap": (5e-7, 1.2e-8),
    "deformable": (1.7e-6, 4.5e-8),
}
"""[s] of an RK4 step, and of each particle in it: towers of 2 to 1001 particles, on a core of
2.5 GHz that others used as well (an idle one is up to three times as fast)."""

SAMPLE_SECONDS = (2e-7, 2e-8)
"""[s] of a sample of the exact solver: of each particle, and of each pair of those in touch;
likewise."""

FRONT = 2 * math.pi
"""[particles per t0] A shock passes one in 1/omega, and t0 is at most 2 pi/omega."""


class Plan(NamedTuple):
    """The steps of a run: their size [s], number, those between samples, the longest chain."""

    step: float
    steps: int
    every: int
    longest: int


Advance = Callable[[Record, int, int], tuple[Record, int]]
"""Does the steps from one to before another; returns the record and its rows, or a failure."""

Told = Callable[[int, int], None]
"""Called with the steps done and the steps in all."""


def in_slices(
    advance: Advance, record: Record, plan: Plan, seconds: float, told: Told
) -> tuple[Record, int]:
    """Do all steps, each of about ``seconds``; return the record and its rows, or a failure."""
    many, done, rows = max(1, int(SLICE_SECONDS / seconds)), 0, 0
    while done <= plan.steps and rows >= 0:
        last = min(done + many, plan.steps + 1)
        record, rows = shielded(advance, record, done, last)
        done = last
        told(min(done, plan.steps), plan.steps)
    return record, rows


def rk4_step_seconds(law: Law, particles: int) -> float:
    """Return what a step is expected to take [s]."""
    once, each = STEP_SECONDS[law]
    return once + each * particles


def exact_seconds(particles: int, contact_times: float, samples: float) -> float:
    """Return what the exact solver is expected to take [s], to an order of magnitude."""
    each, pair = SAMPLE_SECONDS
    touching = min(particles, FRONT * contact_times + 2.0)
    return samples * (each * particles + pair * touching**2)
