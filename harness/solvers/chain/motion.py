"""A row of particles as arrays, and the record of a run.

What the solvers of the chain share that is no force law of a contact: the tower as arrays
(:class:`Chain`), and samples.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.compiled import Function, jit
from harness.errors import RequestError
from harness.observables.tower import COLUMNS, Profiles, TowerRun
from harness.parameters.tower import Tower


def compiled(function: Function) -> Function:
    """Compile ``function`` to machine code at its first call, keeping its Python type.

    IEEE arithmetic, but for the fusing of a product and a sum. Nothing is
    reordered: equal particles in equal states must stay equal to the last bit. Python's lock is
    let go: an interrupt is heard while a kernel runs.
    """
    return jit(function, error_model="numpy", fastmath={"contract"}, nogil=True)


Floats = NDArray[np.float64]


class Chain(NamedTuple):
    """N particles in a row, n = N - 1 contacts, grain first.

    Displacements count from the places at which all particles just touch, so
    that overlaps are ``displacement[i] - displacement[i+1]`` and lose no digits
    however long or stiff the chain is.

    Both laws are ``diagonal[i] f[i] + coupling[i-1] f[i-1] + coupling[i] f[i+1] =
    overlap[i]`` at the closed contacts. A particle that is pressed by f on one
    side and h on the other is shortened by (f + h)/k, half of it on each side;
    this gives ``diagonal = (1/k[i] + 1/k[i+1])/2`` and ``coupling = 1/(2 k[i+1])``.
    The overlap law has ``coupling = 0``.
    """

    mass: Floats  # (N,) [kg]
    mobility: Floats  # (N,) [1/kg] 1/mass, 0 for a fixed particle
    stiffness: Floats  # (N,) [N/m]
    diagonal: Floats  # (n,) [m/N]
    coupling: Floats  # (n,) [m/N] coupling of contact i with contact i+1; the last is 0
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
    diagonal, coupling = compliance(stiffness, deformable)
    overlap = _overlap_at_start(tower, mass, diagonal, coupling)
    velocity = np.zeros(tower.particles)
    velocity[0] = tower.speed
    period = float(np.sqrt(mass.max() / stiffness.min()))
    length = max(tower.speed * period, tower.gravity * period**2, float(np.abs(overlap).max()))
    displacement = np.concatenate(([0.0], -np.cumsum(overlap)))
    return Chain(
        mass, mobility, stiffness, diagonal, coupling, gravity, displacement, velocity, length,
        deformable,
    )  # fmt: skip


def compliance(stiffness: Floats, deformable: bool) -> tuple[Floats, Floats]:
    """Return ``diagonal`` and ``coupling`` (n,) [m/N] from the stiffness of the particles (N,)."""
    diagonal = 0.5 / stiffness[:-1] + 0.5 / stiffness[1:]
    coupling = np.zeros_like(diagonal)
    if deformable:
        coupling[:-1] = 0.5 / stiffness[1:-1]
    return diagonal, coupling


def _overlap_at_start(tower: Tower, mass: Floats, diagonal: Floats, coupling: Floats) -> Floats:
    """Return the overlaps (n,) [m]: none, those of the weight, or the gaps."""
    if tower.start == "gapped":
        return np.full(tower.height, -tower.gap)
    if tower.start == "preloaded":
        weight = tower.gravity * (np.cumsum(mass[:-1]) - mass[0])
        return overlap_of_forces(weight, diagonal, coupling)
    return np.zeros(tower.height)


def overlap_of_forces(force: Floats, diagonal: Floats, coupling: Floats) -> Floats:
    """Return the overlaps (n,) [m] at which all contacts touch and carry ``force`` (n,) [N]."""
    overlap = diagonal * force
    overlap[:-1] += coupling[:-1] * force[1:]
    overlap[1:] += coupling[:-1] * force[:-1]
    return overlap


Counts = NDArray[np.int64]
"""Counters of a run."""

_WIDTH = len(COLUMNS)
_SAMPLES_PER_CONTACT = 1000


# ---- the record of a run: a row of numbers for each sample, and profiles on request


class Record(NamedTuple):
    """Samples of a run; the three profiles have no rows unless requested."""

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


Progress = Callable[[int, int], None]
"""Called with the steps done and the steps in all."""
