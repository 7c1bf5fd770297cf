"""Random chains and rows with a fixed seed, made forwards: from compressions to centres."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

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


@dataclass(frozen=True)
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
