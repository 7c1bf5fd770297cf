"""What engines are asked to simulate: the values of a tower, its script, its scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.cases.tower.parameters import TowerRunParameters
from harness.cases.tower.timing import FEWEST_STEPS, Timing, timing_of
from harness.engines.contract import Job, Template, Value
from harness.engines.scene import Scene
from harness.errors import RequestError
from harness.parameters.allowed import COUNT, Allowed, allowed_in
from harness.parameters.contact import Spring, contact_allowed
from harness.parameters.tower import Property, Tower

PROPERTIES: tuple[Property, ...] = ("stiffness", "mass", "diameter")
"""Of each particle."""


def values_of(case: Tower, timing: Timing) -> dict[str, Value]:
    """Return what a script is told of a tower of equal particles.

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


def scene_of(values: Mapping[str, Any], spring: Spring) -> Scene:
    """Return the tower as arrays, along x, the grain first; gravity along x."""
    case = case_of(values)
    count, d = case.particles, case.each("diameter")[0]
    step = case.contact_period / values["steps_per_contact"]
    place = d * np.arange(count) + np.array(start_displacements(case))
    return Scene(
        position=np.column_stack([place, np.zeros(count)]),
        velocity=np.array([[case.speed, 0.0], *[[0.0, 0.0]] * (count - 1)]),
        mass=np.array(case.each("mass")),
        diameter=np.array(case.each("diameter")),
        fixed=np.arange(count) == (count - 1 if case.base == "fixed" else -1),
        gravity=(case.gravity, 0.0),
        stiffness=case.each("stiffness")[0],
        damping_ratio=0.0,
        restitution=1.0,
        tail="attractive",
        effective_mass="half",
        step=step,
        steps=round(values["duration"] * case.contact_time / step),
        every=values["series_every"],
        spring=spring,
        hertz_speed=case.speed,
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
