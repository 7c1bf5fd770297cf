"""Run towers in an engine, and read what comes back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from harness.cases.tower.motion import forces_of_contacts, tower_run
from harness.cases.tower.template import job_of
from harness.cases.tower.timing import Plan, plan
from harness.engines.contract import Engine, Output
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineOutputError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

ROUNDINGS = 4
"""A contact pressed in by fewer roundings of a position cannot be told from an open one."""

MOTION = ("x_m", "vx_m_per_s")
TOTAL_FORCE, CONTACTS_ON_PARTICLE, CONTACT_FORCE = "fx_N", "contacts_fx_N", "contact_force_N"
"""The force columns of which a table has one: on each particle with its weight, on each particle
by its contacts alone, of each contact."""


def run_towers(
    engine: Engine,
    cases: Sequence[Tower],
    duration: float,
    *,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
) -> list[TowerRun | EngineError]:
    """Run towers for ``duration`` [t0] and return their results in order.

    Steps count in pi sqrt(m/k), samples default to about 1000 per t0.
    Raise RequestError for a case that the engine cannot state.
    """
    plans = [plan(case, duration, steps_per_contact, samples) for case in cases]
    jobs = [job_of(case, timing) for case, timing in zip(cases, plans, strict=True)]
    results: list[TowerRun | EngineError] = []
    for case, timing, output in zip(cases, plans, engine.run(jobs), strict=True):
        try:
            if isinstance(output, EngineError):
                raise output
            results.append(read(case, timing, output, engine.traits, profiles))
        except EngineError as error:
            if isinstance(output, Output):
                error.log = output.log
            results.append(error)
    return results


def read(
    case: Tower, timing: Plan, output: Output, traits: Traits, profiles: bool = False
) -> TowerRun:
    """Return the run that a table of positions, velocities and forces tells of.

    Raise EngineOutputError for what is missing or cut, and for a tower in which nothing ever
    touches; EngineNaNError for values that are not finite.
    """
    rows, count = timing.steps // timing.every + 1, case.particles
    clock = "step" if "step" in output.tables.get("series", {}) else "time_s"
    table = output.table((clock, *MOTION), rows)
    x, v = (np.asarray(table[name]) for name in MOTION)
    if x.shape != (rows, count) or v.shape != (rows, count):
        raise EngineOutputError(f"{output.who} left {x.shape[-1]} particles of {count}")
    time = table[clock] * timing.step if clock == "step" else table[clock]
    displacement = x - case.each("diameter")[0] * np.arange(count)
    force = _contact_forces(case, timing, output, traits, x, v)
    if not (force > 0.0).any():
        raise EngineOutputError(f"{output.who}: no contact of the tower ever presses")
    return tower_run(
        case, timing.step, time, displacement, v, force, output.provenance, profiles=profiles
    )


def _contact_forces(
    case: Tower,
    timing: Plan,
    output: Output,
    traits: Traits,
    x: np.ndarray,
    v: np.ndarray,
) -> np.ndarray:
    """Return the force [N] of each contact (M, n), 0 below what rounding leaves."""
    mass, stiffness = case.each("mass")[0], case.each("stiffness")[0]
    smallest = ROUNDINGS * np.finfo(float).eps * float(np.abs(x).max()) * stiffness
    if traits.force_from_velocity:
        moved = mass / timing.step * float(np.abs(v).max())
        smallest = ROUNDINGS * case.particles * np.finfo(float).eps * moved
        smallest += (
            ROUNDINGS * case.particles * np.finfo(float).eps * stiffness * float(np.abs(x).max())
        )
    table = output.tables["series"]
    clock = "step" if "step" in table else "time_s"
    if CONTACT_FORCE in table:
        force = np.array(output.table((clock, CONTACT_FORCE))[CONTACT_FORCE])
        force[force <= smallest] = 0.0
        return force
    weight, name = mass * case.gravity, TOTAL_FORCE
    if TOTAL_FORCE not in table:
        weight, name = 0.0, CONTACTS_ON_PARTICLE
    return forces_of_contacts(np.asarray(output.table((clock, name))[name]), weight, smallest)
