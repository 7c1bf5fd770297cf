"""Samples of a chain: the motion of the grain, energies and momentum of all, ends of the chain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from harness.errors import RequestError
from harness.solvers.chain.setup import Floats

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
