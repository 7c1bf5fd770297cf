"""Random chains and rows with a fixed seed, made forwards: from compressions to centres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.chain import sweeps
from harness.chain.complementarity import contact_forces

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
        pressed = random.uniform(0.001, 0.1, n - 1)
        widths = 1.0 - np.convolve(pressed, [1, 1])
        edges = random.uniform(-1, 1) + np.concatenate(([0.0], np.cumsum(widths)))
        chains.append(TouchingChain(pressed, 0.5 * (edges[1:] + edges[:-1]), edges))
    return tuple(chains)


@dataclass(frozen=True, eq=False)
class Row:
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
def rows(count: int = 500, closest: tuple[float, float] = (0.9, 1.1)) -> tuple[Row, ...]:
    """Return ``count`` rows of 3 to 9 particles, neighbours between ``closest`` [m] apart."""
    random = generator()
    result = []
    for _ in range(count):
        apart = random.uniform(*closest, int(random.integers(2, 9)))
        centres = np.concatenate(([0.0], np.cumsum(apart)))
        result.append(Row(centres, contact_forces(centres, 1.0, 1.0)))
    return tuple(result)


def off_from_sweeps(some: Sequence[Row]) -> float:
    """Return how far the compressions by sweeps lie off those of ``some`` rows at most [m]."""
    return max(
        float(np.abs(sweeps.compressions(row.centres, 2 * RADIUS) - row.compressions).max())
        for row in some
    )


@dataclass(frozen=True)
class Opening:
    """Two neighbours that do not touch: their distance, and each with what presses it [m]."""

    distance: float
    deformations: tuple[float, float]
    beyond: tuple[float, float]  # distance of each to its other neighbour, infinite at an end


def openings(some: Sequence[Row]) -> list[Opening]:
    """Return every pair of neighbours of ``some`` rows that are not in contact."""
    found = []
    for row in some:
        apart = np.concatenate(([np.inf], row.distances, [np.inf]))
        for i in np.flatnonzero(row.compressions == 0):
            pressed = float(row.deformations[i]), float(row.deformations[i + 1])
            beyond = float(apart[i]), float(apart[i + 2])
            found.append(Opening(float(row.distances[i]), pressed, beyond))
    return found
