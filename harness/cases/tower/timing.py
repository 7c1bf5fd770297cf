"""Steps and samples of a tower run: whole numbers of each, ending with the duration."""

from __future__ import annotations

import math
from dataclasses import dataclass

from harness.errors import RequestError
from harness.parameters.tower import Tower

STEPS_PER_CONTACT = 1000.0
SAMPLES_PER_T0 = 1000
MOST_ROWS = 1_000_000
"""Particles times samples that a run writes at most, unless samples are asked for."""

FEWEST_STEPS = math.pi
"""Bound for the alternating mode of the overlap chain, omega_max = 2 omega: h < 2 / omega_max."""


@dataclass(frozen=True)
class Timing:
    """A run of ``steps`` steps of ``step`` [s] for ``duration`` [t0], written every so many."""

    duration: float
    step: float
    steps: int
    every: int
    steps_per_contact: float


def check_duration(duration: float) -> None:
    """Raise RequestError for a duration [t0] that cannot be."""
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} t0: must be finite and greater than 0")


def timing_of(
    case: Tower, duration: float, steps_per_contact: float | None, samples: int | None
) -> Timing:
    """Return the timing of a run, with the step made to divide the duration and the samples.

    Raise RequestError for a step that velocity Verlet cannot take. Under the
    deformable law the highest frequency grows with the chain,
    omega_max <= sqrt(2) omega / sin(pi / (2 (n + 1))).
    """
    wanted = STEPS_PER_CONTACT if steps_per_contact is None else steps_per_contact
    fewest = FEWEST_STEPS
    if case.law == "deformable":
        fewest = math.pi / math.sqrt(2.0) / math.sin(math.pi / (2 * (case.height + 1)))
    if not (math.isfinite(wanted) and wanted > fewest):
        raise RequestError(
            f"steps_per_contact = {wanted!r}: must be finite and greater than {fewest:.4g}, "
            f"below which velocity Verlet is unstable"
        )
    if samples is None:
        samples = math.ceil(SAMPLES_PER_T0 * duration)
        samples = max(100, min(samples, MOST_ROWS // case.particles))
    seconds = duration * case.contact_time
    least = seconds / case.contact_period * wanted
    every = max(1, math.floor(least / samples))
    steps = every * math.ceil(least / every * (1 - 1e-12))
    if steps > 2_000_000_000:
        raise RequestError(f"duration = {duration:g} t0: more than 2e9 steps, LAMMPS's bound")
    step = seconds / steps
    return Timing(duration, step, steps, every, case.contact_period / step)
