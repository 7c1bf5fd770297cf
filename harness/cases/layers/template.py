"""What engines are asked to simulate: the values of a descent."""

from __future__ import annotations

import math

from harness.cases.layers.parameters import Layers
from harness.engines.contract import Job, Template, Value
from harness.parameters.allowed import allowed_in
from harness.parameters.contact import contact_allowed, contact_values

NAME = "layers"
"""Name of the case, and of its template."""

DISSIPATION = ("damping", "restitution", "damping_ratio")
"""Values of a contact that scripts are told: the others are fixed here."""


RESTART_WORK = 10**10
"""[particles x steps] between two restart files: half an hour of a core. The longest run of the
committed study took 7e9: none of them is cut in two by it."""


def restart_steps(case: Layers) -> int:
    """Return the steps between two restart files. Part of the run: it begins anew at each one."""
    return math.ceil(RESTART_WORK / (case.grains + case.base_spheres))


def values_of(case: Layers) -> dict[str, Value]:
    """Return what a script is told of a descent."""
    told = contact_values(case.contact)
    own = {name: getattr(case, name) for name in Layers.model_fields if name != "contact"}
    return {**own, **{name: told[name] for name in DISSIPATION}}


_CONTACT = {name: one for name, one in contact_allowed().items() if name in DISSIPATION}

TEMPLATE = Template(
    name=NAME,
    variants={"": {**values_of(Layers()), "restart_every": 0}},
    allowed={**allowed_in(Layers), **_CONTACT},
)


def job_of(case: Layers, every: int | None = None) -> Job:
    """Return the job of a descent; with ``every``, all particles are kept each so many steps."""
    values = values_of(case)
    if every is None:
        return Job(TEMPLATE, {**values, "restart_every": restart_steps(case)})
    return Job(TEMPLATE, {**values, "series_every": every}, sampled=True)
