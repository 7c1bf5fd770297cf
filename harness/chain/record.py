"""Record of a run: one row of numbers for each sample, and whole profiles if asked."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.chain.arrays import Chain, Floats
from harness.chain.compiled import compiled
from harness.errors import RequestError
from harness.observables.tower import COLUMNS, Profiles, TowerRun
from harness.parameters.tower import Tower

Counts = NDArray[np.int64]
"""What a run counts as it goes."""

_WIDTH = len(COLUMNS)
_SAMPLES_PER_CONTACT = 1000


class Record(NamedTuple):
    """Samples of a run; the three profiles have no rows unless asked for."""

    rows: Floats  # (M, columns) in the order of harness.observables.tower.COLUMNS
    displacements: Floats  # (M or 0, N) [m]
    velocities: Floats  # (M or 0, N) [m/s]
    forces: Floats  # (M or 0, n) [N]


def wanted_samples(samples: int | None, contacts: float) -> int:
    """Return ``samples``, or 1000 for each of so many contact times t0.

    Raise RequestError for fewer than 1.
    """
    if samples is None:
        return max(1, math.ceil(_SAMPLES_PER_CONTACT * contacts))
    if samples < 1:
        raise RequestError(f"samples = {samples}: must be at least 1")
    return samples


def blank_record(samples: int, particles: int, profiles: bool) -> Record:
    """Return a record for ``samples`` rows."""
    kept = samples if profiles else 0
    return Record(
        np.empty((samples, _WIDTH)),
        np.empty((kept, particles)),
        np.empty((kept, particles)),
        np.empty((kept, particles - 1)),
    )


@compiled
def with_room(record: Record, rows: int) -> Record:
    """Return ``record`` with room for one more sample after ``rows``."""
    if rows < record.rows.shape[0]:
        return record
    return Record(
        np.concatenate((record.rows, np.empty_like(record.rows))),
        np.concatenate((record.displacements, np.empty_like(record.displacements))),
        np.concatenate((record.velocities, np.empty_like(record.velocities))),
        np.concatenate((record.forces, np.empty_like(record.forces))),
    )


@compiled
def chain_of_grain(force: Floats) -> int:
    """Return how many contacts from the grain on carry a force (n,) [N]."""
    contacts = 0
    while contacts < force.size and force[contacts] > 0:
        contacts += 1
    return contacts


@compiled
def write_sample(
    record: Record, row: int, time: float, chain: Chain,
    u: Floats, v: Floats, overlap: Floats, force: Floats,
) -> None:  # fmt: skip
    """Write the state of ``chain`` with its forces (n,) [N] to ``row``."""
    n, mass, gravity = force.size, chain.mass, chain.gravity
    kinetic = elastic = weight = momentum = 0.0
    for i in range(n):
        elastic += 0.5 * force[i] * overlap[i]
    for i in range(n + 1):
        kinetic += 0.5 * mass[i] * v[i] * v[i]
        weight -= mass[i] * gravity[i] * u[i]
        momentum += mass[i] * v[i]
    values = record.rows[row]
    values[0], values[1], values[2], values[3] = time, u[0], v[0], force[0]
    values[4], values[5], values[6] = chain_of_grain(force), u[0] - u[n], v[0] - v[n]
    values[7], values[8], values[9], values[10] = kinetic, elastic, weight, momentum
    values[11] = force[n - 1]
    if record.forces.shape[0]:
        record.displacements[row] = u
        record.velocities[row] = v
        record.forces[row] = force


def as_run(
    tower: Tower, solver: str, step: float | None, record: Record, rows: int, end: Chain
) -> TowerRun:
    """Return the first ``rows`` samples as a result; ``end`` holds the last state.

    Raise RequestError if that is not finite.
    """
    if not (np.isfinite(end.displacement).all() and np.isfinite(end.velocity).all()):
        raise RequestError(f"duration = {record.rows[rows - 1, 0]} s: the values overflow by then")
    columns: dict[str, Any] = {name: record.rows[:rows, j].copy() for j, name in enumerate(COLUMNS)}
    profiles = None
    if record.forces.shape[0]:
        profiles = Profiles(
            record.displacements[:rows], record.velocities[:rows], record.forces[:rows]
        )
    return TowerRun(
        tower=tower,
        solver=solver,
        step=step,
        **columns,
        final_displacement=end.displacement,
        final_velocity=end.velocity,
        profiles=profiles,
    )
