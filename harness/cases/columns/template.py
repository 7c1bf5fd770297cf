"""What engines are asked to simulate: the values of a grain over columns, its script, its scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from harness.cases.columns.parameters import Columns
from harness.cases.columns.rest import allowed, crest_energy, sinking, start_load, start_of
from harness.cases.columns.routes import crest_place, judge
from harness.cases.grain import path_in
from harness.cases.incline.result import Motion
from harness.cases.incline.routes import margin_offset
from harness.cases.incline.template import TEMPLATE as INCLINE
from harness.cases.incline.template import Route
from harness.cases.incline.template import values_of as values_of_incline
from harness.engines.contract import Job, Template, Value
from harness.engines.output import Table
from harness.engines.scene import Columns as Held
from harness.engines.scene import Scene, Stage
from harness.errors import RequestError
from harness.parameters.allowed import allowed_in
from harness.parameters.contact import PLASTIC, Spring, contact_of

NAME = "columns"
"""Name of the case, and of its template."""

OWN = ("n", "law", "inside")
TOUCHING = "touching"
"""Column of an engine's table: 1 where the first particle is in contact."""


def values_of(case: Columns, route: Route, every: int | None = None) -> dict[str, Value]:
    """Return what a script is told of a run; with ``every``, samples every so many steps."""
    return {**values_of_incline(case, route, every), **case.values(*OWN)}


def case_of(values: Mapping[str, Any]) -> Columns:
    """Return the parameters that values state, the inverse of :func:`values_of`."""
    same = set(Columns.model_fields) - {"contact"}
    return Columns(
        contact=contact_of(values), **{name: values[name] for name in same if name in values}
    )


def scene_of(values: Mapping[str, Any], spring: Spring) -> Scene:
    """Return the grain, particle 1, and the columns as arrays, with a stage for each well.

    Raise RequestError for another spring than the linear one.
    """
    if spring != "linear":
        raise RequestError(f"spring = {spring!r}: columns at rest are those of the linear one")
    case, route = case_of(values), values["route"]
    d, tilt, n = case.diameter, math.radians(case.angle), case.n
    wells = 1 if route == "passage" else case.wells
    depth = np.tile(d * np.arange(n) + sinking(case), (case.spheres, 1))
    if route == "passage":
        depth[0] = d * np.arange(n) + sinking(case, *start_load(case))
    floor = crest_energy(case) + allowed(case)
    along = np.repeat(d * np.arange(case.spheres), n)
    scene = case.scene(
        start_of(case, route).state(),
        np.column_stack([along, -depth.ravel()]),
        gravity=(case.gravity * math.sin(tilt), -case.gravity * math.cos(tilt)),
        steps=math.ceil(case.time_limit * math.sqrt(d / case.gravity) / case.step),
        every=values.get("series_every"),
        period=case.spheres * d,
        stages=tuple(
            Stage(crest_place(case, well), floor - margin_offset(case, well))
            for well in range(1, wells + 1)
        ),
        decided=_decided(case, route),
        columns=Held(n, case.law, case.inside == "damped"),
    )
    number = np.arange(len(along) + 1)
    return replace(scene, fixed=(number > 0) & (number % n == 0))


TEMPLATE = Template(
    name=NAME,
    variants={"": values_of(Columns(contact=PLASTIC, steps_per_contact=100.0), "passage")},
    scene=scene_of,
    allowed={**INCLINE.allowed, **allowed_in(Columns)},
)


def job_of(case: Columns, route: Route, every: int | None = None) -> Job:
    """Return the job of a run."""
    return Job(TEMPLATE, values_of(case, route, every), sampled=every is not None)


def _decided(case: Columns, route: str) -> Callable[[Table], bool]:
    """Return what tells from a path so far whether the outcome is decided."""

    def decided(table: Table) -> bool:
        found = judge(case, route, path_in(table), table[TOUCHING])
        return found.motion is not Motion.UNDECIDED

    return decided
