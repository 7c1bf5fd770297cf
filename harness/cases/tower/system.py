"""A tower that a grain hits: parameters, whole numbers of steps and samples, values, scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import Field

from harness.engines.contract import Job, Template, Value
from harness.errors import RequestError
from harness.observables.tower import SEARCH
from harness.parameters.allowed import COUNT, Allowed, allowed_in
from harness.parameters.law import Contact, contact_allowed
from harness.parameters.scene import ContactScene, in_plane, spheres
from harness.parameters.tower import Height, Law, Property, Tower


class TowerRunParameters(Tower):
    """A tower, how long it runs and with which step.

    The defaults are those of the scripts: three particles under the overlap law, which every code
    has.
    """

    height: Height = 2
    law: Law = Field(default="overlap", description="[-] contact law")
    duration: float = Field(
        default=SEARCH,
        ge=SEARCH,
        description="[t0] from the start to the final velocity, in contact times of grain and one "
        "fixed particle",
    )
    steps_per_contact: float | None = Field(
        default=None,
        gt=0,
        description="[-] steps in pi sqrt(m/k); 1000 in engines and 4000 in RK4 if not given",
    )

    @property
    def tower(self) -> Tower:
        """Return the tower alone."""
        return Tower(**{name: getattr(self, name) for name in Tower.model_fields})


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


PROPERTIES: tuple[Property, ...] = ("stiffness", "mass", "diameter")
"""Of each particle."""


def values_of(case: Tower, timing: Timing) -> dict[str, Value]:
    """Return a script's values for a tower of equal particles.

    Raise RequestError for unequal particles, which scripts do not have.
    """
    if any(len(set(case.each(name))) > 1 for name in PROPERTIES):
        raise RequestError("mass, stiffness and diameter must be one number each in an engine")
    return {
        **{name: case.each(name)[0] for name in PROPERTIES},
        "height": case.height,
        "speed": case.speed,
        "gravity": case.gravity,
        "base": case.base,
        "start": case.start,
        "gap": case.gap,
        "duration": timing.duration,
        "steps_per_contact": timing.steps_per_contact,
        "series_every": timing.every,
        "law": case.law,
    }


def case_of(values: Mapping[str, Any]) -> Tower:
    """Return the parameters that values state, the inverse of :func:`values_of`."""
    return Tower(**{name: values[name] for name in Tower.model_fields if name in values})


def scene_of(values: Mapping[str, Any]) -> ContactScene:
    """Return the tower as arrays, along x, the grain first; gravity along x."""
    case = case_of(values)
    count, d = case.particles, case.each("diameter")[0]
    # step and gaps are as the LAMMPS script has them, to the last digit
    omega = math.sqrt(case.each("stiffness")[0] / case.each("mass")[0])
    step = math.pi / omega / values["steps_per_contact"]
    apart = np.arange(count) * case.gap
    place = np.arange(count) * (d + case.gap) + (np.array(start_displacements(case)) - apart)
    bodies = spheres(
        np.column_stack([place, np.zeros(count)]),
        [[case.speed, 0.0], *[[0.0, 0.0]] * (count - 1)],
        case.each("mass"),
        case.each("diameter"),
        np.arange(count) == (count - 1 if case.base == "fixed" else -1),
    )
    return in_plane(
        bodies,
        Contact(restitution=1.0, effective_mass="half"),
        case.each("stiffness")[0],
        gravity=(case.gravity, 0.0),
        step=step,
        steps=round(values["duration"] * case.contact_time / step),
        every=values["series_every"],
        forces=True,
    )


def start_displacements(case: Tower) -> list[float]:
    """Return where the particles start [m], along the motion from where all just touch.

    Contact i of a preloaded tower carries the i - 1 particles between it and the grain,
    pressed in by their weight over k.
    """
    pressed = 0.0
    if case.start == "preloaded":
        pressed = case.each("mass")[0] * case.gravity / case.each("stiffness")[0]
    return [i * case.gap - 0.5 * i * (i - 1) * pressed for i in range(case.particles)]


def _defaults() -> dict[str, Value]:
    case = Tower(height=2, law="overlap")
    timing = timing_of(case, 3.0, None, None)
    return {**values_of(case, timing), "steps_per_contact": 1000.0, "series_every": 4}


TEMPLATE = Template(
    name="tower",
    variants={"": _defaults()},
    scene=scene_of,
    allowed={
        **contact_allowed(),
        **allowed_in(TowerRunParameters),
        "steps_per_contact": Allowed(bounds={"exclusiveMinimum": FEWEST_STEPS}),
        "duration": Allowed(bounds={"exclusiveMinimum": 0}, unit="t0"),
        "series_every": COUNT,
    },
)


def job_of(case: Tower, timing: Timing) -> Job:
    """Return the job of a tower, which writes the motion of all particles."""
    return Job(TEMPLATE, values_of(case, timing), sampled=True)
