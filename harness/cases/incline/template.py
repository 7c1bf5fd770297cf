"""What engines are asked to simulate: the values of an incline, its scripts, its scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Literal, get_args

import numpy as np

from harness.cases.grain import path_in
from harness.cases.incline.judge import judge
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Motion
from harness.cases.incline.routes import crest_energy, end_of, margin_offset, start_of
from harness.engines.contract import Job, Template, Value
from harness.engines.output import Table
from harness.engines.scene import Scene, Stage
from harness.parameters.allowed import COUNT, Allowed, allowed_in
from harness.parameters.contact import (
    CLIPPED,
    PLASTIC,
    SOURCE,
    Spring,
    contact_allowed,
    contact_of,
    contact_values,
)

Route = Literal["passage", "steady"]

NAME = "incline"
"""Name of the case, and of its template."""

NOTES = {
    "plastic": "overdamped and clipped: no tail, no rebound; the one to extrapolate.",
    "source": "e = 1e-20 with the attractive tail, as Harper, Dufek and Breard ran it.",
    "clipped": "critical damping, tail clipped; it rebounds with e = exp(-2) = 0.135.",
}


def values_of(case: Incline, route: Route, every: int | None = None) -> dict[str, Value]:
    """Return what a script is told of a run; with ``every``, samples every so many steps."""
    sampled: dict[str, Value] = {} if every is None else {"series_every": every}
    own = ("angle", "stiffness", "steps_per_contact", "gravity", "diameter", "density", "wells")
    return {
        "route": route,
        **case.values(*own, "time_limit"),
        **contact_values(case.contact),
        **case.values("spheres", "phase"),
        **sampled,
    }


def case_of(values: Mapping[str, Any]) -> Incline:
    """Return the parameters that values state, the inverse of :func:`values_of`."""
    same = set(Incline.model_fields) - {"contact"}
    return Incline(
        contact=contact_of(values), **{name: values[name] for name in same if name in values}
    )


def scene_of(values: Mapping[str, Any], spring: Spring) -> Scene:
    """Return the grain, particle 1, and the row as arrays, with a stage for each well."""
    case, route = case_of(values), values["route"]
    d, tilt = case.diameter, math.radians(case.angle)
    wells = 1 if route == "passage" else case.wells
    return case.scene(
        start_of(case, route, spring).state(),
        np.column_stack([np.arange(case.spheres) * d, np.zeros(case.spheres)]),
        gravity=(case.gravity * math.sin(tilt), -case.gravity * math.cos(tilt)),
        steps=math.ceil(case.time_limit * math.sqrt(d / case.gravity) / case.step),
        every=values.get("series_every"),
        period=case.spheres * d,
        spring=spring,
        stages=tuple(
            Stage(
                end_of(case, route, well, spring),
                crest_energy(case, spring) - margin_offset(case, well),
            )
            for well in range(1, wells + 1)
        ),
        decided=_decided(case, route, spring),
    )


_RANGES = allowed_in(Incline)

TEMPLATE = Template(
    name=NAME,
    variants={
        contact.name: values_of(Incline(contact=contact, steps_per_contact=steps), "steady")
        for contact, steps in ((PLASTIC, 100.0), (SOURCE, 50.0), (CLIPPED, 50.0))
    },
    notes=NOTES,
    scene=scene_of,
    allowed={
        "angle": _RANGES["angle"],  # what is changed the most is checked first
        **_RANGES,
        **contact_allowed(),
        "route": Allowed(words=get_args(Route)),
        # at 10 sqrt(g d) the softest contact is pressed in by a diameter, v sqrt(m / k)
        "speed": Allowed(bounds={"exclusiveMinimum": 0, "maximum": 10}, unit="sqrt(g d)"),
        "start": Allowed(bounds={"exclusiveMinimum": 0, "maximum": 30}, unit="deg"),
        "series_every": COUNT,
    },
)


def job_of(case: Incline, route: Route, every: int | None = None) -> Job:
    """Return the job of a run: in the script of its contact, a custom one in the main script."""
    known = case.contact.name in TEMPLATE.variants
    variant = case.contact.name if known else TEMPLATE.main
    return Job(TEMPLATE, values_of(case, route, every), variant, sampled=every is not None)


def _decided(case: Incline, route: Route, spring: Spring) -> Callable[[Table], bool]:
    """Return what tells from a path so far whether the outcome is decided."""
    return lambda table: judge(case, route, path_in(table), spring).motion is not Motion.UNDECIDED
