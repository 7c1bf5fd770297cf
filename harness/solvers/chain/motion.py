"""A row of particles as arrays, at its start, its largest stable step, and its sampled motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Scheme = Literal["rk4", "velocity_verlet"]
Progress = Callable[[int, int], None]  # what is done, of how much
STABILITY: dict[Scheme, float] = {"rk4": 2.0 * math.sqrt(2.0), "velocity_verlet": 2.0}  # h omega


class Chain(NamedTuple):
    """N particles in a row, n = N - 1 contacts, grain first.

    Displacements count from where all particles just touch: overlaps are ``displacement[i] -
    displacement[i+1]``, and lose no digits however long or stiff the chain is. At closed contacts

        diagonal[i] f[i] + coupling[i-1] f[i-1] + coupling[i] f[i+1] = overlap[i]

    under both laws. A particle of stiffness k that is pressed by f on one side and h on the other
    is shortened by (f + h) / k, half of it on each side. Hence ``diagonal = (1/k[i] + 1/k[i+1])/2``
    and ``coupling = 1 / (2 k[i+1])`` for the deformable law (Harper, Dufek and Breard 2024); the
    overlap law has ``coupling = 0``.
    """

    mass: Floats  # (N,) [kg]
    mobility: Floats  # (N,) [1/kg] 1/mass, 0 for a fixed particle
    diagonal: Floats  # (n,) [m/N]
    coupling: Floats  # (n,) [m/N] of contact i with contact i+1; the last is 0
    gravity: Floats  # (N,) [m/s2] along the chain, 0 for a fixed particle
    displacement: Floats  # (N,) [m]
    velocity: Floats  # (N,) [m/s]
    length: float  # [m] scale of displacements within a contact
    deformable: bool


def make_chain(
    mass: Floats,
    stiffness: Floats,
    *,
    deformable: bool,
    gravity: float = 0.0,
    fixed_base: bool = True,
    speed: float = 0.0,
    overlap: Floats | None = None,
) -> Chain:
    """Return a chain at its start.

    ``mass`` [kg] and ``stiffness`` [N/m] are those of particles (N,); the grain has a ``speed``
    [m/s] and the others are at rest, with ``overlap`` (n,) [m], 0 unless given.
    """
    mobility, weight = 1.0 / mass, np.full(mass.size, gravity)
    if fixed_base:
        mobility[-1] = weight[-1] = 0.0
    start = np.zeros(mass.size - 1) if overlap is None else overlap
    velocity = np.zeros(mass.size)
    velocity[0] = speed
    period = float(np.sqrt(mass.max() / stiffness.min()))
    length = max(abs(speed) * period, gravity * period**2, float(np.abs(start).max()))
    place = np.concatenate(([0.0], -np.cumsum(start)))
    law = compliance(stiffness, deformable)
    return Chain(mass, mobility, *law, weight, place, velocity, length, deformable)


def compliance(stiffness: Floats, deformable: bool) -> tuple[Floats, Floats]:
    """Return ``diagonal`` and ``coupling`` (n,) [m/N] from the stiffness (N,) [N/m]."""
    diagonal = 0.5 / stiffness[:-1] + 0.5 / stiffness[1:]
    coupling = np.zeros_like(diagonal)
    if deformable:
        coupling[:-1] = 0.5 / stiffness[1:-1]
    return diagonal, coupling


def overlaps_of_forces(force: Floats, diagonal: Floats, coupling: Floats) -> Floats:
    """Return the overlaps (n,) [m] at which all contacts touch and carry ``force`` (n,) [N]."""
    overlap = diagonal * force
    overlap[:-1] += coupling[:-1] * force[1:]
    overlap[1:] += coupling[:-1] * force[:-1]
    return np.asarray(overlap)


def highest_frequency(chain: Chain) -> float:
    """Return an upper bound of the angular frequencies of any contact set [rad/s].

    Overlap law, from the row sums of M^-1 K: ``2 omega`` for equal particles. Deformable law:
    ``K = D A^-1 D^T`` with ``A >= T / max k``, whose lowest eigenvalue for n touching contacts is
    ``2 sin^2(pi / (2 (n + 1)))``; so ``sqrt(2) omega / sin(pi / (2 (n + 1)))``, which grows with n.
    """
    if not chain.deformable:
        contact = np.concatenate(([0.0], 1.0 / chain.diagonal, [0.0]))
        return float(np.sqrt(np.max(2.0 * (contact[:-1] + contact[1:]) / chain.mass)))
    softest = 2.0 * math.sin(math.pi / (2 * (chain.diagonal.size + 1))) ** 2
    return math.sqrt(4.0 * _largest_stiffness(chain) / (float(chain.mass.min()) * softest))


def _largest_stiffness(chain: Chain) -> float:
    """Return the largest stiffness of a particle: 2 diagonal[i] = 1/k[i] + 1/k[i+1]."""
    inner = 2.0 * chain.coupling[:-1]
    if inner.size == 0:
        return float(1.0 / chain.diagonal[0])
    ends = 2.0 * chain.diagonal[0] - inner[0], 2.0 * chain.diagonal[-1] - inner[-1]
    return float(1.0 / min(*ends, *inner))


# ---- the motion


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
