"""A tower as the arrays that the kernels work on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.chain.compiled import compiled
from harness.parameters.tower import Tower

Floats = NDArray[np.float64]


class Chain(NamedTuple):
    """N particles in a row, n = N - 1 contacts, grain first.

    Displacements count from the places at which all particles just touch, so
    that overlaps are ``displacement[i] - displacement[i+1]`` and lose no digits
    however long or stiff the chain is.

    Both laws are ``diagonal[i] f[i] + beside[i-1] f[i-1] + beside[i] f[i+1] =
    overlap[i]`` at the closed contacts. A particle that is pressed by f on one
    side and h on the other is shortened by (f + h)/k, half of it on each side;
    this gives ``diagonal = (1/k[i] + 1/k[i+1])/2`` and ``beside = 1/(2 k[i+1])``.
    The overlap law has ``beside = 0``.
    """

    mass: Floats  # (N,) [kg]
    mobility: Floats  # (N,) [1/kg] 1/mass, 0 for a fixed particle
    stiffness: Floats  # (N,) [N/m]
    diagonal: Floats  # (n,) [m/N]
    beside: Floats  # (n,) [m/N] coupling of contact i with contact i+1; the last is 0
    gravity: Floats  # (N,) [m/s2] 0 for a fixed particle
    displacement: Floats  # (N,) [m] at the start
    velocity: Floats  # (N,) [m/s] at the start
    length: float  # [m] the scale of displacements within a contact
    deformable: bool


def assemble(tower: Tower) -> Chain:
    """Return the arrays of ``tower`` at its start."""
    mass, stiffness = np.array(tower.each("mass")), np.array(tower.each("stiffness"))
    mobility, gravity = 1 / mass, np.full(tower.particles, tower.gravity)
    if tower.base == "fixed":
        mobility[-1] = gravity[-1] = 0.0
    deformable = tower.law == "deformable"
    diagonal, beside = compliance(stiffness, deformable)
    overlap = _overlap_at_start(tower, mass, diagonal, beside)
    velocity = np.zeros(tower.particles)
    velocity[0] = tower.speed
    period = float(np.sqrt(mass.max() / stiffness.min()))
    length = max(tower.speed * period, tower.gravity * period**2, float(np.abs(overlap).max()))
    displacement = np.concatenate(([0.0], -np.cumsum(overlap)))
    return Chain(
        mass, mobility, stiffness, diagonal, beside, gravity, displacement, velocity, length,
        deformable,
    )  # fmt: skip


def compliance(stiffness: Floats, deformable: bool) -> tuple[Floats, Floats]:
    """Return ``diagonal`` and ``beside`` (n,) [m/N] from the stiffness of the particles (N,)."""
    diagonal = 0.5 / stiffness[:-1] + 0.5 / stiffness[1:]
    beside = np.zeros_like(diagonal)
    if deformable:
        beside[:-1] = 0.5 / stiffness[1:-1]
    return diagonal, beside


def _overlap_at_start(tower: Tower, mass: Floats, diagonal: Floats, beside: Floats) -> Floats:
    """Return the overlaps (n,) [m]: none, those of the weight, or the gaps."""
    if tower.start == "gapped":
        return np.full(tower.height, -tower.gap)
    if tower.start == "preloaded":
        weight = tower.gravity * (np.cumsum(mass[:-1]) - mass[0])
        return overlap_of_forces(weight, diagonal, beside)
    return np.zeros(tower.height)


def overlap_of_forces(force: Floats, diagonal: Floats, beside: Floats) -> Floats:
    """Return the overlaps (n,) [m] at which all contacts touch and carry ``force`` (n,) [N]."""
    overlap = diagonal * force
    overlap[:-1] += beside[:-1] * force[1:]
    overlap[1:] += beside[:-1] * force[:-1]
    return overlap


@compiled
def equal_run(chain: Chain) -> tuple[int, int]:
    """Return the first particle of the longest run of equal particles, and one more than its last.

    Blocks within it can read the properties of its first particles in place of their
    own: these stay in the cache, and less passes through memory.
    """
    best, end, first = 0, 0, 0
    for i in range(chain.mobility.size):
        if i > 0 and not _alike(chain, i):
            first = i
        if i + 1 - first > end - best:
            best, end = first, i + 1
    return best, end


@compiled
def _alike(chain: Chain, i: int) -> bool:
    """Return whether particle ``i`` and its contacts equal those of the particle before."""
    same = chain.mobility[i] == chain.mobility[i - 1] and chain.gravity[i] == chain.gravity[i - 1]
    if i < chain.diagonal.size:
        same = same and chain.diagonal[i] == chain.diagonal[i - 1]
        same = same and chain.beside[i] == chain.beside[i - 1]
    return bool(same)
