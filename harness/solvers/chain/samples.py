"""Samples of a chain: rows of the series from displacements, velocities and forces."""

from __future__ import annotations

import numpy as np

from harness.solvers.chain.kernels import compiled
from harness.solvers.chain.series import COLUMNS, ChainSamples, Profiles, samples_of_rows
from harness.solvers.chain.setup import Chain, Floats


def sampled_motion(
    chain: Chain, time: Floats, motion: Profiles, *, step: float | None = None, keep: bool = True
) -> ChainSamples:
    """Return the samples of a motion at times (M,) [s]; ``keep`` its profiles."""
    rows = np.empty((time.size, len(COLUMNS)))
    u, v, force = (np.ascontiguousarray(part) for part in motion)
    _write_rows(chain, time, u, v, force, rows)
    end = motion.displacements[-1].copy(), motion.velocities[-1].copy()
    return samples_of_rows(rows, end, step=step, profiles=motion if keep else None)


@compiled
def _write_rows(
    chain: Chain, time: Floats, u: Floats, v: Floats, force: Floats, rows: Floats
) -> None:
    for i in range(time.size):
        write_row(chain, time[i], u[i], v[i], force[i], rows[i])


@compiled
def write_row(chain: Chain, time: float, u: Floats, v: Floats, force: Floats, row: Floats) -> None:
    """Write the state of a chain with its forces (n,) [N] to a row (columns,)."""
    n = force.size
    kinetic = elastic = weight = momentum = 0.0
    for i in range(n):
        # f A f / 2 under either law
        elastic += 0.5 * force[i] * (u[i] - u[i + 1])
    for i in range(n + 1):
        kinetic += 0.5 * chain.mass[i] * v[i] * v[i]
        weight -= chain.mass[i] * chain.gravity[i] * u[i]
        momentum += chain.mass[i] * v[i]
    row[0], row[1], row[2], row[3] = time, u[0], v[0], force[0]
    row[4], row[5], row[6] = count_contacts(force), u[0] - u[n], v[0] - v[n]
    row[7], row[8], row[9], row[10] = kinetic, elastic, weight, momentum
    row[11] = force[n - 1]


@compiled
def count_contacts(force: Floats) -> int:
    """Return how many contacts from the grain on carry a force (n,) [N]."""
    contacts = 0
    while contacts < force.size and force[contacts] > 0:
        contacts += 1
    return contacts
