"""The deformable law as an external force on LAMMPS's own particles.

LAMMPS integrates, this gives the forces: what then differs from RK4 under the
same law is the integration. The compressions c of the contacts solve

    w = T c - delta >= 0,   c >= 0,   c . w = 0,   T = tridiag(1/2, 1, 1/2).

This shares no code with the chain solvers: dense algebra, and Murty's least
index method (Math. Programming 7, 1974), which ends for a positive definite T
whatever set of contacts it starts from. (SciPy's NNLS, tried first, returns
wrong forces where an overlap is exactly zero, as in a row that falls freely.)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np
from numpy.typing import NDArray

SLACK = 1e-13
"""Forces and gaps this far below zero, over the largest overlap, are rounding."""

MOST_PIVOTS = 100
"""Exchanges for each contact before giving up; from the last step's set it takes none or one."""


class DeformableLaw:
    """Contact forces from positions, in the form that LAMMPS's ``fix external`` calls.

    ``height`` contacts between particles of stiffness ``stiffness`` [N/m] that
    just touch at distances of ``diameter`` [m].
    """

    def __init__(self, height: int, stiffness: float, diameter: float) -> None:
        self._stiffness = stiffness
        self._touching = diameter * np.arange(height + 1)
        self._matrix = np.eye(height) + 0.5 * np.eye(height, k=1) + 0.5 * np.eye(height, k=-1)
        self._closed = np.zeros(height, dtype=bool)
        self.failure = ""

    @classmethod
    def of(cls, values: Mapping[str, str], _lammps: object) -> Self:
        """Return the law of a job, from the values of its script."""
        return cls(int(values["height"]), float(values["stiffness"]), float(values["diameter"]))

    def forces(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the contact forces [N], shape (height,), at positions x [m], grain first.

        Raise ArithmeticError when the contacts cannot be found.
        """
        displacement = x - self._touching
        return self.forces_at(displacement[:-1] - displacement[1:])

    def forces_at(self, overlap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the contact forces [N], shape (height,), at overlaps [m]; errors likewise."""
        if not np.isfinite(overlap).all():
            raise ArithmeticError(f"deformable law: overlaps are not numbers: {overlap.tolist()}")
        slack = SLACK * float(np.abs(overlap).max())
        for _ in range(MOST_PIVOTS * overlap.size):
            closed = self._closed
            compression = np.zeros_like(overlap)
            if closed.any():
                inside = self._matrix[np.ix_(closed, closed)]
                compression[closed] = np.linalg.solve(inside, overlap[closed])
            gap = self._matrix @ compression - overlap
            wrong = np.flatnonzero(np.where(closed, compression, gap) < -slack)
            if wrong.size == 0:
                return np.asarray(self._stiffness * compression)
            closed[wrong[0]] = not closed[wrong[0]]
        raise ArithmeticError(
            f"deformable law: no contact set found at overlaps {overlap.tolist()}"
        )

    def __call__(
        self,
        _caller: object,
        _step: int,
        count: int,
        tags: NDArray[np.int32],
        x: NDArray[np.float64],
        f: NDArray[np.float64],
    ) -> None:
        """Set the forces on the particles that LAMMPS hands over, by their ids from 1.

        An exception would be lost on its way through LAMMPS: it is kept in
        ``failure``, and forces that are not numbers end the run.
        """
        place = np.asarray(tags[:count]) - 1
        ordered = np.empty(count)
        ordered[place] = x[:count, 0]
        try:
            contact = self.forces(ordered)
        except ArithmeticError as error:
            self.failure = str(error)
            contact = np.full(count - 1, np.nan)
        total = np.zeros(count)
        total[:-1] -= contact
        total[1:] += contact
        f[:count] = 0.0
        f[:count, 0] = total[place]
