"""A row of particles as arrays, what limits a step, and the record of a run.

What the solvers of the chain share that is no force law of a contact: the tower as arrays
(:class:`Chain`), the boundaries of deformed particles, the largest stable step of RK4, samples, and
the loop that does a run in slices.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.compiled import Function, jit, shielded
from harness.errors import RequestError
from harness.observables.tower import COLUMNS, Profiles, TowerRun
from harness.parameters.tower import Law, Tower


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
        same = same and chain.coupling[i] == chain.coupling[i - 1]
    return bool(same)


# ---- boundaries of the deformed particles of one chain, from its centres alone
#
# Equal spheres, all of them touching their neighbours (Harper, Dufek and Breard, Appendix A). Each
# particle keeps its centre in the middle, so the boundaries follow from the first by b[i] = 2 x[i]
# - b[i-1]; Newton's third law makes the alternating sum of the deformations vanish, which gives
# the first.


def first_boundary(positions: Floats, radius: float) -> float:
    """Return the outer boundary of the first particle of a chain [m].

    ``b_0 = (1/n) (((-1)^n - 1)/2 r0 + sum_i (-1)^(i+1) (2(n-i)+1) x_i)`` with n
    particles at ``positions`` (n,) [m]. The source prints ``(-1)^n r0``, which
    contradicts its own example of four particles.
    """
    n = positions.size
    i = np.arange(1, n + 1)
    weights = (-1.0) ** (i + 1) * (2 * (n - i) + 1)
    # the weights sum to n: counted from the first centre, long rows lose no digits
    offset = float(weights @ (positions - positions[0])) - (radius if n % 2 else 0.0)
    return float(positions[0]) + offset / n


def boundaries(positions: Floats, radius: float) -> Floats:
    """Return all n + 1 boundaries of a chain of n particles at ``positions`` (n,) [m]."""
    result = np.empty(positions.size + 1)
    result[0] = first_boundary(positions, radius)
    for i, centre in enumerate(positions):
        result[i + 1] = centre + (centre - result[i])
    return result


def deformations(positions: Floats, radius: float) -> Floats:
    """Return how much the diameter of each particle of a chain is shortened (n,) [m]."""
    return 2 * (radius - (positions - boundaries(positions, radius)[:-1]))


def partial_compressions(positions: Floats, radius: float) -> Floats:
    """Return the n - 1 partial compressions c of a chain [m]; a contact carries k c.

    A particle's deformation is the sum of the partial compressions on its two
    sides, and the first particle has one side only. Negative values say that
    these particles do not all touch.
    """
    deformation = deformations(positions, radius)
    result = np.empty(positions.size - 1)
    carried = 0.0
    for i in range(result.size):
        carried = deformation[i] - carried
        result[i] = carried
    return result


# ---- input of users


def checked_positions(positions: ArrayLike, reach: Floats | float) -> Floats:
    """Return ``positions`` [m] as an array (N,).

    ``reach`` [m] is the centre distance at which neighbours just touch, one
    number or one for each contact. Raise RequestError, naming the first value
    at fault, unless there are two particles or more, all finite, ascending, and
    no two neighbours closer than half their reach.
    """
    x = np.asarray(positions, dtype=float)
    if x.ndim != 1 or x.size < 2:
        raise RequestError(f"positions: shape {x.shape}, must be a row of two particles or more")
    for i in np.flatnonzero(~np.isfinite(x)):
        raise RequestError(f"positions[{i}] = {x[i]} m: must be finite")
    distance = np.diff(x)
    for i in np.flatnonzero(distance <= 0):
        raise RequestError(
            f"positions[{i + 1}] = {x[i + 1]} m: must be greater than positions[{i}] = {x[i]} m"
        )
    least = np.broadcast_to(0.5 * np.asarray(reach), distance.shape)
    for i in np.flatnonzero(distance < least):
        raise RequestError(
            f"positions[{i + 1}] - positions[{i}] = {distance[i]} m: "
            f"must be at least {least[i]} m, half the distance at which they touch"
        )
    return x


def checked_positive(name: str, unit: str, value: ArrayLike, size: int) -> Floats:
    """Return ``value`` as an array (size,), or raise RequestError unless finite and above 0."""
    array = np.asarray(value, dtype=float)
    if array.ndim > 1 or (array.ndim == 1 and array.size != size):
        raise RequestError(f"{name}: shape {array.shape}, must be one value or {size} values")
    array = np.array(np.broadcast_to(array, (size,)))
    for i in np.flatnonzero(~(np.isfinite(array) & (array > 0))):
        raise RequestError(f"{name}[{i}] = {array[i]} {unit}: must be finite and greater than 0")
    return array


RK4_IMAGINARY_LIMIT = 2 * math.sqrt(2)
DEFAULT_STEPS_PER_CONTACT = 4000.0


# ---- the largest stable step of RK4, and the one that is taken


def highest_frequency(tower: Tower, longest_chain: int | None = None) -> float:
    """Return an upper bound of the angular frequencies of any contact set [rad/s].

    Overlap law, from the row sums of M^-1 K: ``2 omega`` for equal particles,
    whatever their number. Deformable law: ``K = D A^-1 D^T`` and
    ``A >= T / max k``, whose lowest eigenvalue in a chain of L touching contacts is
    ``2 sin^2(pi / (2(L+1)))``; so ``sqrt(2) omega / sin(pi / (2(L+1)))``, which
    grows with the length. ``longest_chain`` is L, all contacts if not given.
    """
    stiffness, mass = tower.each("stiffness"), tower.each("mass")
    if tower.law == "overlap":
        contact = [0.0, *(2 / (1 / a + 1 / b) for a, b in pairwise(stiffness)), 0.0]
        rows = zip(pairwise(contact), mass, strict=True)
        return math.sqrt(max(2 * (before + after) / m for (before, after), m in rows))
    length = tower.height if longest_chain is None else min(longest_chain, tower.height)
    softest = 2 * math.sin(math.pi / (2 * (length + 1))) ** 2
    return math.sqrt(4 * max(stiffness) / (min(mass) * softest))


def largest_step(tower: Tower, longest_chain: int | None = None) -> float:
    """Return the largest stable step of RK4 [s], ``2 sqrt(2) / highest frequency``."""
    return RK4_IMAGINARY_LIMIT / highest_frequency(tower, longest_chain)


def select_step(
    tower: Tower,
    step: float | None = None,
    steps_per_contact: float | None = None,
    longest_chain: int | None = None,
) -> float:
    """Return the step [s]: as given, or 4000 per contact time pi sqrt(m/k).

    The default is at most half the largest stable one. Raise
    RequestError, naming the bound, for a step that is not positive or not stable.
    """
    bound = largest_step(tower, longest_chain)
    if step is None and steps_per_contact is None:
        return min(tower.contact_period / DEFAULT_STEPS_PER_CONTACT, 0.5 * bound)
    if step is not None and steps_per_contact is not None:
        raise RequestError(
            f"step = {step} s and steps_per_contact = {steps_per_contact}: give one of them"
        )
    if steps_per_contact is not None:
        least = tower.contact_period / bound
        if not (math.isfinite(steps_per_contact) and steps_per_contact > least):
            raise RequestError(
                f"steps_per_contact = {steps_per_contact}: must be greater than {least:.6g}, "
                f"where RK4 becomes unstable ({tower.law} law, {_chain(tower, longest_chain)})"
            )
        return tower.contact_period / steps_per_contact
    if step is None or not (0 < step < bound):
        raise RequestError(
            f"step = {step} s: must be greater than 0 and less than {bound:.6g} s, "
            f"where RK4 becomes unstable ({tower.law} law, {_chain(tower, longest_chain)})"
        )
    return step


def _chain(tower: Tower, longest_chain: int | None) -> str:
    contacts = tower.height if longest_chain is None else min(longest_chain, tower.height)
    return f"{contacts} touching contact{'s' if contacts > 1 else ''}"


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


SLICE_SECONDS = 0.3

STEP_SECONDS: dict[Law, tuple[float, float]] = {
    "overlap": (5e-7, 1.2e-8),
    "deformable": (1.7e-6, 4.5e-8),
}
"""[s] of an RK4 step, and of each particle in it: towers of 2 to 1001 particles, on a core of
2.5 GHz that others used as well (an idle one is up to three times as fast)."""

SAMPLE_SECONDS = (2e-7, 2e-8)
"""[s] of a sample of the exact solver: of each particle, and of each pair of those in touch;
likewise."""

FRONT = 2 * math.pi
"""[particles per t0] A shock passes one in 1/omega, and t0 is at most 2 pi/omega."""


# ---- compiled loops in slices
#
# An interrupt is heard, and progress reported, between two slices. The state between them is that
# between two steps: a run in slices is the same to the last bit. How long a slice takes, and a
# run, follows from what a step costs.


class Plan(NamedTuple):
    """The steps of a run: their size [s], number, those between samples, the longest chain."""

    step: float
    steps: int
    every: int
    longest: int


Advance = Callable[[Record, int, int], tuple[Record, int]]
"""Does the steps from one to before another; returns the record and its rows, or a failure."""

Progress = Callable[[int, int], None]
"""Called with the steps done and the steps in all."""


def in_slices(
    advance: Advance, record: Record, plan: Plan, seconds: float, progress: Progress
) -> tuple[Record, int]:
    """Do all steps, each of about ``seconds``; return the record and its rows, or a failure."""
    in_slice, done, rows = max(1, int(SLICE_SECONDS / seconds)), 0, 0
    while done <= plan.steps and rows >= 0:
        last = min(done + in_slice, plan.steps + 1)
        record, rows = shielded(advance, record, done, last)
        done = last
        progress(min(done, plan.steps), plan.steps)
    return record, rows


def rk4_step_seconds(law: Law, particles: int) -> float:
    """Return the expected time of a step [s]."""
    once, each = STEP_SECONDS[law]
    return once + each * particles


def exact_seconds(particles: int, contact_times: float, samples: float) -> float:
    """Return the expected time of the exact solver [s], to an order of magnitude."""
    each, pair = SAMPLE_SECONDS
    touching = min(particles, FRONT * contact_times + 2.0)
    return samples * (each * particles + pair * touching**2)
