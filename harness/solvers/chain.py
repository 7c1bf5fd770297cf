"""Rows of elastic particles: their contact law, which of them touch, and their sampled motion.

With the overlaps given, the forces f of the contacts solve a linear complementarity problem,

    w = A f - overlap >= 0,   f >= 0,   f w = 0

with the symmetric positive definite, tridiagonal A of :class:`Chain`: there is one solution for all
positions (Cottle, Pang and Stone 1992, theorem 3.1.6). The set of the step before is corrected by
block principal pivoting (Judice and Pires 1994): all contacts of the wrong sign are exchanged at
once, and the last one alone where that cycles, which ends for every such A (Murty 1974). A pass is
O(n), and a set without a wrong sign needs none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.compiled import compiled
from harness.errors import RequestError
from harness.model.scene import Floats

Flags = NDArray[np.bool_]
Scheme = Literal["rk4", "velocity_verlet"]
Progress = Callable[[int, int], None]  # what is done, of how much
STABILITY: dict[Scheme, float] = {"rk4": 2.0 * math.sqrt(2.0), "velocity_verlet": 2.0}  # h omega
PATIENCE = 10  # passes without fewer wrong contacts before they are exchanged one by one
MOST_PASSES = 1000  # one by one, for each contact
MOST_SWEEPS = 100_000


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
    stiffness: Floats  # (N,) [N/m]
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
    overlap: Floats,
) -> Chain:
    """Return a chain at its start.

    ``mass`` [kg] and ``stiffness`` [N/m] are those of particles (N,); the grain has a ``speed``
    [m/s] and the others are at rest, with ``overlap`` (n,) [m].
    """
    mobility, weight, velocity = 1.0 / mass, np.full(mass.size, gravity), np.zeros(mass.size)
    velocity[0] = speed
    if fixed_base:
        mobility[-1] = weight[-1] = 0.0
    period = float(np.sqrt(mass.max() / stiffness.min()))
    length = max(abs(speed) * period, gravity * period**2, float(np.abs(overlap).max()))
    place = np.concatenate(([0.0], -np.cumsum(overlap)))
    law = compliance(stiffness, deformable)
    return Chain(mass, stiffness, mobility, *law, weight, place, velocity, length, deformable)


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
    softest = 2.0 * math.sin(math.pi / (2 * chain.mass.size)) ** 2
    return math.sqrt(4.0 * float(chain.stiffness.max()) / (float(chain.mass.min()) * softest))


@dataclass(frozen=True, kw_only=True, repr=False)
class ChainMotion:
    """M samples of a chain of N particles and n contacts, at any distances in time.

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
        if not np.isfinite([self.displacements[-1], self.velocities[-1]]).all():
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
    def final_velocity(self) -> Floats:
        """Return the last velocities (N,) [m/s]."""
        return np.asarray(self.velocities[-1])


# ---- the contact set, by pivoting


def contact_forces(positions: ArrayLike, diameter: ArrayLike, stiffness: ArrayLike) -> Floats:
    """Return the force of every contact (N - 1,) [N] under the deformable law, from the centres.

    ``positions`` (N,) [m] ascend; ``diameter`` [m] and ``stiffness`` [N/m] are one value or one
    for each particle. Raise RequestError for neighbours closer than half their touching distance.
    """
    x = np.asarray(positions, dtype=float)
    d, k = (np.broadcast_to(np.asarray(part, float), x.shape) for part in (diameter, stiffness))
    reach = 0.5 * (d[:-1] + d[1:])
    return forces_of_overlaps(_overlaps(x, reach), *compliance(k, True))


def _overlaps(x: Floats, reach: Floats | float) -> Floats:
    if not (np.diff(x) >= 0.5 * np.asarray(reach)).all():
        raise RequestError(
            f"positions = {x.tolist()} m: must ascend, neighbours at least half the distance "
            "from each other at which they touch"
        )
    return reach - np.diff(x)


def forces_of_overlaps(overlap: Floats, diagonal: Floats, coupling: Floats) -> Floats:
    """Return the force of every contact (n,) [N] from the overlaps (n,) [m], which are finite.

    ``diagonal`` and ``coupling`` (n,) [m/N] are those of :class:`Chain`.
    """
    closed, force, factor = overlap > 0.0, np.empty_like(overlap), np.empty((3, overlap.size))
    factorise(closed, diagonal, coupling, factor)
    tolerance = 1e-15 * float(np.abs(overlap).max())
    if not solve(overlap, diagonal, coupling, closed, factor, force, tolerance):
        raise RequestError(f"overlaps = {overlap.tolist()} m: no contact set fits them")
    return np.maximum(force, 0.0)


@compiled
def solve(
    overlap: Floats, diagonal: Floats, coupling: Floats,
    closed: Flags, factor: Floats, force: Floats, tolerance: float,
) -> bool:  # fmt: skip
    """Find ``closed`` and ``force`` (n,) [N], from the set and its factors on entry.

    Return False where rounding leaves no set with gaps above -``tolerance`` [m], times n.
    """
    n = overlap.size
    fewest, patience = n + 1, PATIENCE
    for _ in range(MOST_PASSES + MOST_PASSES * n):
        substitute(overlap, factor, force)
        alone = patience < 0
        allowed = tolerance * n if alone else tolerance
        wrong = _exchange_wrong(overlap, diagonal, coupling, force, closed, allowed, alone)
        if wrong == 0:
            return True
        patience = PATIENCE if wrong < fewest else patience - 1
        fewest = min(fewest, wrong)
        factorise(closed, diagonal, coupling, factor)
    return False


@compiled
def _exchange_wrong(
    overlap: Floats, diagonal: Floats, coupling: Floats,
    force: Floats, closed: Flags, tolerance: float, last_only: bool,
) -> int:  # fmt: skip
    """Exchange the contacts that pull, or are open and overlap; return how many are wrong."""
    n, wrong, last = overlap.size, 0, -1
    for i in range(n):
        if closed[i]:
            slack = diagonal[i] * force[i]
        else:
            slack = -overlap[i]
            if i > 0:
                slack += coupling[i - 1] * force[i - 1]
            if i < n - 1:
                slack += coupling[i] * force[i + 1]
        if slack < -tolerance:
            last, wrong = i, wrong + 1
            if not last_only:
                closed[i] = not closed[i]
    if last_only and wrong:
        closed[last] = not closed[last]
    return wrong


@compiled
def factorise(closed: Flags, diagonal: Floats, coupling: Floats, factor: Floats) -> None:
    """Factorise A on the closed contacts (Thomas).

    ``factor`` (3, n) takes the inverse pivots, and the multipliers of the forward and the backward
    substitution; all are 0 where open.
    """
    before = pivot = 0.0
    for i in range(closed.size):
        carried = before * pivot
        pivot = 1.0 / (diagonal[i] - before * carried) if closed[i] else 0.0
        factor[0, i] = pivot
        factor[1, i] = carried if closed[i] else 0.0
        before = coupling[i]
        factor[2, i] = before * pivot


@compiled
def substitute(overlap: Floats, factor: Floats, force: Floats) -> None:
    """Set ``force`` (n,) [N] of the closed contacts, 0 elsewhere, from ``overlap`` (n,) [m]."""
    n = overlap.size
    carried = 0.0
    for i in range(n):
        carried = overlap[i] - factor[1, i] * carried
        force[i] = carried
    carried = 0.0
    for i in range(n - 1, -1, -1):
        carried = factor[0, i] * force[i] - factor[2, i] * carried
        force[i] = carried


# ---- the contact set as the source finds it, which shares no code with the pivoting
#
# Equal spheres, from their centres alone (Harper, Dufek and Breard, arXiv:2409.13633, Appendix A).
# A particle keeps its centre in the middle of its deformed boundaries, so that these follow from
# the first by b[i] = 2 x[i] - b[i-1]. The alternating sum of the deformations vanishes (Newton's
# third law), which gives the first.
#
# The source closes a contact once it is *guaranteed*: closed even if the unknown contacts beyond
# press as hard as they can, by c <= d - (x[i+1] - x[i]) (corrected). To merge neighbouring chains
# because their boundaries overlap at the moment is not enough: overlaps of 0.9, 0.6 and 1 would
# first join contacts 3 and 2 and then 1, though 1 and 3 push 2 open. So every contact has both
# bounds here, and the sweeps close in on the one solution from both sides.


def compressions_by_sweeps(positions: ArrayLike, diameter: float) -> Floats:
    """Return the partial compression of every contact (N - 1,) [m], 0 where open.

    ``positions`` are the centres (N,) [m], ascending. Raise RequestError for neighbours closer than
    half a diameter.
    """
    x = np.asarray(positions, dtype=float)
    overlap, result = _overlaps(x, diameter), np.zeros(x.size - 1)
    rounding = 4 * np.finfo(float).eps * max(diameter, abs(x[0]), abs(x[-1]))
    closed = _closed_contacts(overlap, rounding)
    edges = np.flatnonzero(np.diff([False, *closed, False]))
    for first, last in edges.reshape(-1, 2):
        result[first:last] = partial_compressions(x[first : last + 1], diameter / 2)
    return result


def _closed_contacts(overlap: Floats, rounding: float) -> Flags:
    """Return which contacts are closed, by bounds on c = max(overlap - half its neighbours, 0)."""
    low, high = np.zeros_like(overlap), np.maximum(overlap, 0.0)
    halves = np.array([0.5, 0.0, 0.5])
    for _ in range(MOST_SWEEPS):
        low = np.maximum(overlap - np.convolve(high, halves)[1:-1], 0.0)
        high = np.maximum(overlap - np.convolve(low, halves)[1:-1], 0.0)
        if ((low > 0.0) | (high <= rounding)).all():
            return high > rounding
    raise RequestError(f"overlaps = {overlap.tolist()} m: undecided after {MOST_SWEEPS} sweeps")


def partial_compressions(positions: Floats, radius: float) -> Floats:
    """Return the n - 1 partial compressions c of a chain [m]; a contact carries k c.

    A particle's deformation is the sum of those on its two sides, and the first has one side only.
    Negative values mean that these particles do not all touch.
    """
    deformation = 2 * (radius - (positions - boundaries(positions, radius)[:-1]))
    result = np.empty(positions.size - 1)
    carried = 0.0
    for i in range(result.size):
        carried = deformation[i] - carried
        result[i] = carried
    return result


def boundaries(positions: Floats, radius: float) -> Floats:
    """Return all n + 1 boundaries of a chain of n particles at ``positions`` (n,) [m]."""
    result = np.empty(positions.size + 1)
    result[0] = first_boundary(positions, radius)
    for i, centre in enumerate(positions):
        result[i + 1] = centre + (centre - result[i])
    return result


def first_boundary(positions: Floats, radius: float) -> float:
    """Return the outer boundary of the first particle of a chain [m].

    ``b_0 = (1/n) (((-1)^n - 1)/2 r0 + sum_i (-1)^(i+1) (2(n-i)+1) x_i)`` with n particles at
    ``positions`` (n,) [m]. The source prints ``(-1)^n r0``, which contradicts its own example of
    four particles.
    """
    n = positions.size
    i = np.arange(1, n + 1)
    weights = (-1.0) ** (i + 1) * (2 * (n - i) + 1)
    # the weights sum to n: counted from the first centre, long rows lose no digits
    offset = float(weights @ (positions - positions[0])) - (radius if n % 2 else 0.0)
    return float(positions[0]) + offset / n
