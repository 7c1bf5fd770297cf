"""Samples that statements are tried at: random chains and rows, one damped contact, tower runs.

Random numbers have a fixed seed. Towers are the source's (1 kg, 1 m, 9.81 m/s2), run by the exact
propagator, which has no step: a row judges the model, not an integrator.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from harness.cases.tower.impulse import grain_alone, impulse_angles
from harness.cases.tower.parameters import Law, Tower
from harness.cases.tower.runs import TowerRun, solve
from harness.solvers.chain import compressions_by_sweeps, contact_forces
from harness.theory.chain import compliance

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]

RADIUS = 0.5  # [m] of all particles here
SEED = 2409_13633
SAMPLES = 2000  # of a run; changes of contact are exact
MEDIAN = (1e6, 2.0)  # [N/m], [m/s] of the runs that the source describes most


def generator() -> np.random.Generator:
    """Return a generator that gives the same numbers in every run."""
    return np.random.default_rng(SEED)


# ---- particles of diameter 1 m


@dataclass(frozen=True, eq=False)
class Particles:
    """N particles in a row, with the partial compressions of their contacts.

    ``boundaries`` (N+1,) [m] are those that a touching chain was laid out from; a row has none.
    """

    centres: Floats  # (N,) [m]
    compressions: Floats  # (N-1,) [m] 0 where open
    boundaries: Floats

    @property
    def deformations(self) -> Floats:
        """Return how much each diameter is shortened (N,) [m], by the boundaries of a chain."""
        if self.boundaries.size:
            return np.asarray(2 * RADIUS - np.diff(self.boundaries))
        return np.convolve(self.compressions, [1, 1])

    @property
    def distances(self) -> Floats:
        """Return the distances of neighbouring centres (N-1,) [m]."""
        return np.diff(self.centres)


@cache
def touching_chains(count: int = 200, particles: tuple[int, ...] = ()) -> tuple[Particles, ...]:
    """Return touching chains of 2 to 9 particles, or of one of the given numbers.

    They are laid out from a random first boundary: each particle is as wide as its two partial
    compressions leave it, and its centre is its middle.
    """
    random, chains = generator(), []
    for _ in range(count):
        n = int(random.choice(particles or range(2, 10)))
        compressions = random.uniform(0.001, 0.1, n - 1)
        widths = 1.0 - np.convolve(compressions, [1, 1])
        edges = random.uniform(-1, 1) + np.concatenate(([0.0], np.cumsum(widths)))
        chains.append(Particles(0.5 * (edges[1:] + edges[:-1]), compressions, edges))
    return tuple(chains)


@cache
def rows(count: int = 500, closest: tuple[float, float] = (0.9, 1.1)) -> tuple[Particles, ...]:
    """Return rows of 3 to 9 particles by their one solution; ``closest`` spans distances [m]."""
    random, sampled = generator(), []
    for _ in range(count):
        distances = random.uniform(*closest, int(random.integers(2, 9)))
        centres = np.concatenate(([0.0], np.cumsum(distances)))
        sampled.append(Particles(centres, contact_forces(centres, 1.0, 1.0), np.empty(0)))
    return tuple(sampled)


def sweep_difference() -> float:
    """Return the largest difference between sweeps and complementarity over all rows [m]."""
    return max(
        float(np.abs(compressions_by_sweeps(row.centres, 2 * RADIUS) - row.compressions).max())
        for row in rows()
    )


class OpenPairs(NamedTuple):
    """Neighbours that do not touch: distances, deformations, distances to the other neighbours."""

    distance: Floats  # (P,) [m]
    deformations: Floats  # (P, 2) [m]
    beyond: Floats  # (P, 2) [m] infinite at an end


@cache
def open_pairs() -> OpenPairs:
    """Return the pairs of neighbours of the rows that are not in contact."""
    pairs = []
    for row in rows():
        distances = np.concatenate(([np.inf], row.distances, [np.inf]))
        for i in np.flatnonzero(row.compressions == 0):
            pairs.append(
                [distances[i + 1], *row.deformations[i : i + 2], *distances[i : i + 3 : 2]]
            )
    table = np.array(pairs)
    return OpenPairs(table[:, 0], table[:, 1:3], table[:, 3:])


# ---- springs and contacts


def springs_in_series(springs: int) -> float:
    """Return the end-to-end stiffness [k] of equal springs in series, from their equilibrium."""
    balance = 2 * np.eye(springs) - np.eye(springs, k=1) - np.eye(springs, k=-1)
    balance[-1, -1] = 1.0
    force = np.zeros(springs)
    force[-1] = 1.0
    return float(1 / np.linalg.solve(balance, force)[-1])


def row_energy(contacts: int) -> float:
    """Return the energy of a row of the source's particles [J] at 1 N/m under 1 N.

    It is half the force times the overlaps of the deformable law.
    """
    forces = np.ones(contacts)
    return float(0.5 * forces @ compliance(contacts, deformable=True) @ forces)


def damped_contact(
    stiffness: float, mass: float, damping: float, *, clipped: bool = False
) -> tuple[float, float]:
    """Return duration [s] and restitution of m x'' + gamma x' + k x = 0, which touches at 1 m/s.

    It is integrated until the overlap is gone, a ``clipped`` contact until its force is. Errors
    are below 1e-10 of both numbers.
    """

    def end(_: float, state: Any) -> float:
        return float(stiffness * state[0] + damping * state[1] if clipped else state[0])

    end.terminal, end.direction = True, -1  # type: ignore[attr-defined]
    period = (mass / stiffness) ** 0.5
    solution = solve_ivp(
        lambda _, s: [s[1], -(stiffness * s[0] + damping * s[1]) / mass],
        (0.0, 100 * period), [1e-13 * period, 1.0],
        events=end, rtol=1e-11, atol=1e-14 * period,
    )  # fmt: skip
    return float(solution.t[-1]), -float(solution.y[1, -1])


# ---- towers


@cache
def run(case: Tower, duration: float = 3.0) -> TowerRun:
    """Return a tower run for ``duration`` [t0]."""
    return solve(case, "exact", duration=duration, samples=SAMPLES)


@cache
def free_collision(particles: int) -> TowerRun:
    """Return a grain that runs into free particles, no gravity, until all have parted."""
    return run(Tower(height=particles - 1, base="free", gravity=0.0), 1.0 + 0.5 * particles)


@cache
def impulses(law: Law = "deformable") -> pd.DataFrame:
    """Return the source's six runs over all heights, turnaround window."""
    return impulse_angles(laws=(law,), solver="exact")


@cache
def ratios(law: Law = "deformable") -> dict[tuple[float, float], dict[int, float]]:
    """Return alpha by (stiffness, speed) and height."""
    by_run: dict[tuple[float, float], dict[int, float]] = {}
    columns = ["stiffness_N_per_m", "speed_m_per_s", "height", "impulse_ratio"]
    for k, speed, height, ratio in impulses(law)[columns].itertuples(index=False):
        by_run.setdefault((k, speed), {})[height] = ratio
    return by_run


@cache
def structure_angles(law: Law, tallest: int) -> pd.DataFrame:
    """Return the table of the structure window over heights, 1e6 N/m and 2 m/s."""
    return impulse_angles(
        laws=(law,), windows=("structure",), heights=range(1, tallest + 1),
        stiffnesses=MEDIAN[:1], speeds=MEDIAN[1:], solver="exact",
    )  # fmt: skip


@cache
def contact_intervals(case: Tower, duration: float = 3.0) -> list[tuple[float, float]]:
    """Return from when to when the grain touches anything [t0], cut by the end of the run."""
    tower = run(case, duration)
    first, last = float(tower.time_over_t0[0]), float(tower.time_over_t0[-1])
    alone = [*grain_alone(tower), (last, last)]
    begins = [first, *(end for _, end in alone)]
    ends = [begin for begin, _ in alone]
    return [pair for pair in zip(begins, ends, strict=False) if pair[0] < pair[1]]
