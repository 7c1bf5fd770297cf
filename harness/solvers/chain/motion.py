"""The sampled motion of a chain: all particles and contacts, energies, momentum."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from harness.errors import RequestError
from harness.solvers.chain.setup import Chain, Floats


@dataclass(frozen=True, kw_only=True, repr=False)
class ChainMotion:
    """M samples of a chain of N particles and n contacts, which need not be equally far apart.

    Displacements count from where all particles just touch. Raise RequestError where the last
    state is not finite.
    """

    chain: Chain
    time: Floats  # (M,) [s]
    displacements: Floats  # (M, N) [m]
    velocities: Floats  # (M, N) [m/s]
    forces: Floats  # (M, n) [N] of the contacts alone
    step: float | None = None  # [s] None for a solver without one

    def __post_init__(self) -> None:
        if not np.isfinite([self.final_displacement, self.final_velocity]).all():
            raise RequestError(f"duration = {self.time[-1]} s: the values overflow by then")

    @property
    def grain_displacement(self) -> Floats:
        """Return the displacement of the grain (M,) [m]."""
        return self.displacements[:, 0]

    @property
    def grain_velocity(self) -> Floats:
        """Return the velocity of the grain (M,) [m/s]."""
        return self.velocities[:, 0]

    @property
    def grain_force(self) -> Floats:
        """Return the force of the first contact (M,) [N]."""
        return self.forces[:, 0]

    @property
    def base_force(self) -> Floats:
        """Return the force of the last contact (M,) [N]."""
        return self.forces[:, -1]

    @cached_property
    def contacts(self) -> Floats:
        """Return how many contacts from the grain on are closed (M,) [1]."""
        return self.contacts_above(0.0)

    def contacts_above(self, least: float) -> Floats:
        """Return how many contacts from the grain on press with more than ``least`` [N] (M,).

        In a touching row under the overlap law all contacts close at once, the far ones with
        forces at the mercy of rounding: a threshold makes codes comparable.
        """
        pressing = np.cumprod(self.forces > least, axis=1).sum(axis=1)
        return np.asarray(pressing, dtype=np.float64)

    @property
    def compression(self) -> Floats:
        """Return the approach of the centres of the grain and the last particle (M,) [m]."""
        return self.displacements[:, 0] - self.displacements[:, -1]

    @property
    def compression_rate(self) -> Floats:
        """Return the rate of that approach (M,) [m/s]."""
        return self.velocities[:, 0] - self.velocities[:, -1]

    @property
    def kinetic_energy(self) -> Floats:
        """Return the kinetic energy (M,) [J]."""
        return np.asarray((0.5 * self.chain.mass * self.velocities**2).sum(axis=1))

    @property
    def elastic_energy(self) -> Floats:
        """Return the energy of the springs (M,) [J], f A f / 2 under either law."""
        return np.asarray((-0.5 * self.forces * np.diff(self.displacements)).sum(axis=1))

    @property
    def gravitational_energy(self) -> Floats:
        """Return the energy of the weight (M,) [J], 0 where all particles just touch."""
        return -self.displacements @ (self.chain.mass * self.chain.gravity)

    @property
    def energy(self) -> Floats:
        """Return the total energy (M,) [J]."""
        return self.kinetic_energy + self.elastic_energy + self.gravitational_energy

    @property
    def momentum(self) -> Floats:
        """Return the momentum of all particles (M,) [kg m/s]."""
        return self.velocities @ self.chain.mass

    @property
    def final_displacement(self) -> Floats:
        """Return the last displacements (N,) [m]."""
        return np.asarray(self.displacements[-1])

    @property
    def final_velocity(self) -> Floats:
        """Return the last velocities (N,) [m/s]."""
        return np.asarray(self.velocities[-1])
