"""What engines are asked to simulate: the values of a drop, its script, its scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.cases.drop.parameters import Drop
from harness.engines.contract import Job, Template, Value
from harness.engines.scene import Scene
from harness.parameters.contact import Contact, Spring, contact_of, contact_values

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None)
"""The contact of the scripts as they stand."""


def values_of(case: Drop) -> dict[str, Value]:
    """Return what a script is told of a drop."""
    return {
        "stiffness": case.stiffness,
        "steps_per_contact": case.steps_per_contact,
        "gravity": case.gravity,
        "diameter": case.diameter,
        "density": case.density,
        "gap": case.gap,
        "speed": case.speed,
        "sideways": case.sideways,
        "steps": case.steps,
        "series_every": case.every,
        **contact_values(case.contact),
    }


def case_of(values: Mapping[str, Any]) -> Drop:
    """Return the parameters that values state, the inverse of :func:`values_of`."""
    same = set(Drop.model_fields) - {"contact", "duration", "every"}
    return Drop(
        contact=contact_of(values),
        every=values["series_every"],
        duration=values["steps"] / values["steps_per_contact"],
        **{name: values[name] for name in same},
    )


def scene_of(values: Mapping[str, Any], spring: Spring) -> Scene:
    """Return the grain, particle 1, and the fixed sphere as arrays."""
    case = case_of(values)
    d = case.diameter
    return Scene(
        position=np.array([[0.0, d + case.gap], [0.0, 0.0]]),
        velocity=np.array([[case.sideways, -case.speed], [0.0, 0.0]]),
        mass=np.full(2, case.mass),
        diameter=np.full(2, d),
        fixed=np.array([False, True]),
        gravity=(0.0, -case.gravity),
        stiffness=case.stiffness,
        damping_ratio=case.contact.zeta,
        restitution=case.contact.stated_restitution,
        tail=case.contact.tail,
        effective_mass=case.contact.effective_mass,
        step=case.step,
        steps=values["steps"],
        every=values["series_every"],
        spring=spring,
        hertz_speed=case.hertz_speed,
    )


TEMPLATE = Template(
    name="drop",
    variants={"": values_of(Drop(contact=HEAD_ON, gap=1e-3, speed=1.0))},
    scene=scene_of,
)


def job_of(case: Drop) -> Job:
    """Return the job of a drop, which writes the path."""
    return Job(TEMPLATE, values_of(case), sampled=True)
