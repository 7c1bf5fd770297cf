"""Samples of a chain: the motion of the grain, energies and momentum of all, ends of the chain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from harness.errors import RequestError
from harness.solvers.chain.setup import Chain, Floats, compiled

COLUMNS = (
    "time",
    "grain_displacement",
    "grain_velocity",
    "grain_force",
    "contacts",
    "compression",
    "compression_rate",
    "kinetic_energy",
    "elastic_energy",
    "gravitational_energy",
    "momentum",
    "base_force",
)


class Profiles(NamedTuple):
    """Every particle and contact at every sample."""

    displacements: Floats  # (M, N) [m]
    velocities: Floats  # (M, N) [m/s]
    forces: Floats  # (M, n) [N]


@dataclass(frozen=True, kw_only=True, repr=False)
class ChainSamples:
    """M samples of a chain, and its last state.

    Displacements count from where all particles just touch. ``contacts`` are the closed ones from
    the grain on, ``compression`` is the approach of the centres of the grain and the last particle,
    ``base_force`` that of the last contact. Gravitational energy is 0 where all just touch. Samples
    need not be equally far apart.
    """

    time: Floats  # (M,) [s]
    grain_displacement: Floats  # (M,) [m]
    grain_velocity: Floats  # (M,) [m/s]
    grain_force: Floats  # (M,) [N] of the contact alone
    contacts: Floats  # (M,) [1]
    compression: Floats  # (M,) [m]
    compression_rate: Floats  # (M,) [m/s]
    kinetic_energy: Floats  # (M,) [J]
    elastic_energy: Floats  # (M,) [J]
    gravitational_energy: Floats  # (M,) [J]
    momentum: Floats  # (M,) [kg m/s]
    base_force: Floats  # (M,) [N]
    final_displacement: Floats  # (N,) [m]
    final_velocity: Floats  # (N,) [m/s]
    step: float | None = None  # [s] None for a solver without one
    profiles: Profiles | None = None

    @property
    def energy(self) -> Floats:
        """Return the total energy (M,) [J]."""
        return self.kinetic_energy + self.elastic_energy + self.gravitational_energy


def samples_of_rows(
    rows: Floats,
    end: tuple[Floats, Floats],
    *,
    step: float | None = None,
    profiles: Profiles | None = None,
) -> ChainSamples:
    """Return samples of rows (M, columns) and the last displacements and velocities (N,).

    Raise RequestError where these are not finite.
    """
    if not all(np.isfinite(part).all() for part in end):
        raise RequestError(f"duration = {rows[-1, 0]} s: the values overflow by then")
    columns: dict[str, Any] = dict(zip(COLUMNS, rows.T.copy(), strict=True))
    return ChainSamples(
        **columns, final_displacement=end[0], final_velocity=end[1], step=step, profiles=profiles
    )


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
