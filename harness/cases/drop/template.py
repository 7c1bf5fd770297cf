"""What engines are asked to simulate: the values of a drop, its script, its scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from harness.cases.drop.parameters import Drop
from harness.engines.contract import Job, Template, Value
from harness.engines.scene import Scene
from harness.parameters.allowed import COUNT, allowed_in
from harness.parameters.contact import (
    Contact,
    Spring,
    contact_allowed,
    contact_of,
    contact_values,
)

NAME = "drop"
"""Name of the case, and of its template."""

HEAD_ON = Contact(name="head-on", restitution=0.5, damping_ratio=None)
"""The contact of the scripts as they stand."""

SAME = (
    *("stiffness", "steps_per_contact", "gravity", "diameter", "density"),
    *("gap", "speed", "sideways"),
)
"""Parameters that scripts are told under their own names."""


def values_of(case: Drop) -> dict[str, Value]:
    """Return what a script is told of a drop."""
    told = {**case.values(*SAME, "steps"), "series_every": case.every}
    return {**told, **contact_values(case.contact)}


def case_of(values: Mapping[str, Any]) -> Drop:
    """Return the parameters that values state, the inverse of :func:`values_of`."""
    return Drop(
        contact=contact_of(values),
        every=values["series_every"],
        duration=values["steps"] / values["steps_per_contact"],
        **{name: values[name] for name in SAME},
    )


def scene_of(values: Mapping[str, Any], spring: Spring) -> Scene:
    """Return the grain, particle 1, and the fixed sphere as arrays."""
    case = case_of(values)
    return case.scene(
        (0.0, case.diameter + case.gap, case.sideways, -case.speed),
        [(0.0, 0.0)],
        gravity=(0.0, -case.gravity),
        steps=values["steps"],
        every=values["series_every"],
        spring=spring,
    )


TEMPLATE = Template(
    name=NAME,
    variants={"": values_of(Drop(contact=HEAD_ON, gap=1e-3, speed=1.0))},
    scene=scene_of,
    allowed={**allowed_in(Drop), **contact_allowed(), "steps": COUNT, "series_every": COUNT},
)


def job_of(case: Drop) -> Job:
    """Return the job of a drop, which writes the path."""
    return Job(TEMPLATE, values_of(case), sampled=True)
