"""What the rows of the ledger share: random chains, one damped contact, tower runs.

Chains and rows have a fixed seed, and are made forwards: from compressions to centres. Towers run
by the exact propagator, which has no step: a row judges the model, not an integrator. They are the
source's (1 kg, 1 m, 9.81 m/s2) unless a row says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from harness.cases.tower.impulse import SPEEDS, STIFFNESSES, impulse_table
from harness.cases.tower.run import tower
from harness.observables.tower import ImpulseRow, TowerRun, grain_alone
from harness.parameters.tower import Law, Tower
from harness.solvers.chain import forces
from harness.solvers.chain.forces import contact_forces

Floats = NDArray[np.float64]

RADIUS = 0.5
_SEED = 2409_13633


def generator() -> np.random.Generator:
    """Return a generator that gives the same numbers in every run."""
    return np.random.default_rng(_SEED)


@dataclass(frozen=True)
class TouchingChain:
    """n particles of diameter 1 m, all touching, with the boundaries they were built from."""

    compressions: Floats  # (n-1,) [m] partial, all positive
    centres: Floats  # (n,) [m]
    boundaries: Floats  # (n+1,) [m]

    @property
    def deformations(self) -> Floats:
        """Return how much each diameter is shortened (n,) [m]."""
        return np.asarray(1.0 - np.diff(self.boundaries))

    @property
    def symbols(self) -> dict[str, Any]:
        """Return the numbers of the source's formulas of chains, by their names there."""
        n = self.centres.size
        first = float(self.boundaries[0])
        return {"x": self.centres, "n": n, "i": np.arange(1, n + 1), "b_0": first, "r_0": RADIUS}


@cache
def touching_chains(count: int = 200, particles: tuple[int, ...] = ()) -> tuple[TouchingChain, ...]:
    """Return ``count`` chains of 2 to 9 particles, or of one of the given numbers.

    Laid side by side from a random first boundary: each particle is as wide as its
    two partial compressions leave it, and its centre is its middle.
    """
    random = generator()
    chains = []
    for _ in range(count):
        n = int(random.choice(particles or range(2, 10)))
        compressions = random.uniform(0.001, 0.1, n - 1)
        widths = 1.0 - np.convolve(compressions, [1, 1])
        edges = random.uniform(-1, 1) + np.concatenate(([0.0], np.cumsum(widths)))
        chains.append(TouchingChain(compressions, 0.5 * (edges[1:] + edges[:-1]), edges))
    return tuple(chains)


@dataclass(frozen=True, eq=False)
class ParticleRow:
    """Particles of diameter 1 m anywhere in a row, with the compressions of the one solution."""

    centres: Floats  # (N,) [m]
    compressions: Floats  # (N-1,) [m] 0 where open

    @property
    def deformations(self) -> Floats:
        """Return how much each diameter is shortened (N,) [m]."""
        return np.convolve(self.compressions, [1, 1])

    @property
    def distances(self) -> Floats:
        """Return the distances of neighbouring centres (N-1,) [m]."""
        return np.diff(self.centres)


@cache
def rows(count: int = 500, closest: tuple[float, float] = (0.9, 1.1)) -> tuple[ParticleRow, ...]:
    """Return ``count`` rows of 3 to 9 particles, neighbours between ``closest`` [m] apart."""
    random = generator()
    result = []
    for _ in range(count):
        apart = random.uniform(*closest, int(random.integers(2, 9)))
        centres = np.concatenate(([0.0], np.cumsum(apart)))
        result.append(ParticleRow(centres, contact_forces(centres, 1.0, 1.0)))
    return tuple(result)


def off_from_sweeps(some: Sequence[ParticleRow]) -> float:
    """Return how far the compressions by sweeps lie off those of ``some`` rows at most [m]."""
    return max(
        float(np.abs(forces.compressions(row.centres, 2 * RADIUS) - row.compressions).max())
        for row in some
    )


@dataclass(frozen=True)
class OpenPair:
    """Two neighbours that do not touch: their distance, and each with what presses it [m]."""

    distance: float
    deformations: tuple[float, float]
    beyond: tuple[float, float]  # distance of each to its other neighbour, infinite at an end


def openings(some: Sequence[ParticleRow]) -> list[OpenPair]:
    """Return every pair of neighbours of ``some`` rows that are not in contact."""
    pairs = []
    for row in some:
        apart = np.concatenate(([np.inf], row.distances, [np.inf]))
        for i in np.flatnonzero(row.compressions == 0):
            deformations = float(row.deformations[i]), float(row.deformations[i + 1])
            beyond = float(apart[i]), float(apart[i + 2])
            pairs.append(OpenPair(float(row.distances[i]), deformations, beyond))
    return pairs


class ContactEnd(NamedTuple):
    """The end of a contact that began at speed 1."""

    time: float
    restitution: float


def integrate(
    stiffness: float, mass: float, damping: float, end: Literal["parted", "released"] = "parted"
) -> ContactEnd:
    """Integrate m x'' + gamma x' + k x = 0 from touching at speed 1 m/s until the contact ends.

    It ends when the overlap is gone (``parted``, the attractive tail kept) or when
    the force is (``released``, the tail clipped).
    """

    def at_end(_: float, state: Any) -> float:
        held = state[0] if end == "parted" else stiffness * state[0] + damping * state[1]
        return float(held)

    at_end.terminal, at_end.direction = True, -1  # type: ignore[attr-defined]
    period = (mass / stiffness) ** 0.5
    solution = solve_ivp(
        lambda _, s: [s[1], -(stiffness * s[0] + damping * s[1]) / mass],
        (0.0, 100 * period),
        [1e-13 * period, 1.0],
        events=at_end,
        rtol=1e-11,
        atol=1e-14 * period,
    )
    return ContactEnd(float(solution.t[-1]), -float(solution.y[1, -1]))


SAMPLES = 2000
"""For each run: enough to name a time to a thousandth of t0; changes of contact are exact."""

MEDIAN = (1e6, 2.0)
"""[N/m], [m/s] of the runs that the source describes most."""

Ratios = dict[tuple[float, float], dict[int, float]]


@cache
def run(case: Tower, duration: float = 3.0) -> TowerRun:
    """Return ``case`` run for ``duration`` [t0], with profiles."""
    return tower(case, solver="exact", duration=duration, samples=SAMPLES, profiles=True)


@cache
def free_collision(particles: int, law: Law = "deformable") -> TowerRun:
    """Return a grain that runs into free particles, no gravity, until all have parted."""
    case = Tower(height=particles - 1, base="free", gravity=0.0, law=law)
    return run(case, 1.0 + 0.5 * particles)


@cache
def impulses(law: Law = "deformable") -> tuple[ImpulseRow, ...]:
    """Return the source's six runs over all heights, turnaround window."""
    return tuple(impulse_table(laws=(law,), solver="exact"))


def ratios(law: Law = "deformable") -> Ratios:
    """Return alpha by (stiffness, speed) and height."""
    by_run: Ratios = {(k, v): {} for k in STIFFNESSES for v in SPEEDS}
    for row in impulses(law):
        by_run[row.stiffness, row.speed][row.height] = row.ratio
    return by_run


@cache
def heights_with_structure_window(law: Law) -> tuple[int, ...]:
    """Return the heights from 1 to 8 that have a structure window, median run."""
    rows = impulse_table(
        laws=(law,),
        windows=("structure",),
        heights=range(1, 9),
        stiffnesses=MEDIAN[:1],
        speeds=MEDIAN[1:],
    )
    return tuple(row.height for row in rows if math.isfinite(row.window_s))


def contact_intervals(tower_run: TowerRun) -> list[tuple[float, float]]:
    """Return when the grain touches anything [t0], from and to; cut off by the end of the run."""
    first, *_, last = (float(time) for time in tower_run.time_over_t0)
    alone = [*grain_alone(tower_run), (last, last)]
    begins = [first, *(end for _, end in alone)]
    ends = [begin for begin, _ in alone]
    return [pair for pair in zip(begins, ends, strict=False) if pair[0] < pair[1]]
