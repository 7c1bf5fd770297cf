"""Run towers in an engine, and read what comes back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harness.cases.runs import run_jobs
from harness.cases.tower.motion import forces_of_contacts, tower_run
from harness.cases.tower.template import job_of
from harness.cases.tower.timing import Plan, plan
from harness.engines.contract import Engine, Output
from harness.engines.output import SERIES
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

FORCES = (CONTACT_FORCE, TOTAL_FORCE, CONTACTS_ON_PARTICLE)

LATE = 0.75
"""Sampling intervals that a sample may be off its time: some codes are half a step early."""


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

    def timing(case: Tower) -> Plan:
        return plan(case, duration, steps_per_contact, samples)

    return run_jobs(
        engine,
        cases,
        lambda case: job_of(case, timing(case)),
        lambda case, output: read(case, timing(case), output, engine.traits, profiles),
    )


def read(
    case: Tower, timing: Plan, output: Output, traits: Traits, profiles: bool = False
) -> TowerRun:
    """Return the run that a table of positions, velocities and forces tells of.

    Raise EngineOutputError for what is missing or cut, for samples at other times than were asked
    for, and for a tower in which nothing ever touches; EngineNaNError for values that are not
    finite.
    """
    rows, count = timing.steps // timing.every + 1, case.particles
    written = output.tables.get(SERIES, {})
    clock = "step" if "step" in written else "time_s"
    forces = next((name for name in FORCES if name in written), TOTAL_FORCE)
    table = output.table((clock, *MOTION, forces), rows)
    x, v, f = (np.asarray(table[name]) for name in (*MOTION, forces))
    for name, values, width in zip(
        (*MOTION, forces), (x, v, f), (count, count, count - (forces == CONTACT_FORCE)), strict=True
    ):
        if values.shape != (rows, width):
            raise EngineOutputError(f"{output.who} left {name} of {values.shape[-1]}, not {width}")
    time = np.asarray(table[clock] * timing.step if clock == "step" else table[clock])
    interval = timing.step * timing.every
    if np.abs(time - interval * np.arange(rows)).max() > LATE * interval:
        raise EngineOutputError(f"{output.who} wrote samples at other times than were asked for")
    _same_motion(x, v, np.diff(time), traits.digits, output.who)
    smallest = _rounding(case, timing.step, traits, x, v)
    if forces == CONTACT_FORCE:
        force = np.where(f > smallest, f, 0.0)
    else:
        weight = case.each("mass")[0] * case.gravity if forces == TOTAL_FORCE else 0.0
        force = forces_of_contacts(f, weight, smallest)
    if not (force > 0.0).any():
        raise EngineOutputError(f"{output.who}: no contact of the tower ever presses")
    displacement = x - case.each("diameter")[0] * np.arange(count)
    return tower_run(
        case, timing.step, time, displacement, v, force, output.provenance, profiles=profiles
    )


def _same_motion(
    x: NDArray[np.float64],
    v: NDArray[np.float64],
    interval: NDArray[np.float64],
    digits: int,
    who: str,
) -> None:
    """Raise EngineOutputError for positions that do not move with the velocities.

    From sample to sample a particle goes by the mean of its velocities, to within what they
    change in an interval and the digits of the positions.
    """
    moved = np.abs(np.diff(x, axis=0) - 0.5 * interval[:, None] * (v[1:] + v[:-1]))
    room = interval.max() * np.abs(np.diff(v, axis=0)).max(initial=0.0)
    if moved.max(initial=0.0) > room + 10.0 ** (1 - digits) * np.abs(x).max():
        raise EngineOutputError(f"{who} wrote positions and velocities that contradict each other")


def _rounding(
    case: Tower, step: float, traits: Traits, x: NDArray[np.float64], v: NDArray[np.float64]
) -> float:
    """Return the least force [N] that can be told from rounding."""
    mass, stiffness = case.each("mass")[0], case.each("stiffness")[0]
    rounding = ROUNDINGS * float(np.finfo(float).eps)
    pressed = stiffness * float(np.abs(x).max())
    if traits.force_from_velocity:
        moved = mass / step * float(np.abs(v).max())
        return rounding * case.particles * (moved + pressed)
    return rounding * pressed
