"""The deformable law as an external force on LAMMPS's own particles.

LAMMPS integrates, this gives the forces: what then differs from RK4 under the
same law is the integration. The compressions c of the contacts solve

    w = T c - delta >= 0,   c >= 0,   c . w = 0,   T = tridiag(1/2, 1, 1/2),

which is the least-squares problem min |L^T c - L^-1 delta|, c >= 0, with
T = L L^T. It is left to SciPy's NNLS, so that this shares no force code with
the chain solvers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls


class DeformableLaw:
    """Contact forces from positions, in the form that LAMMPS's ``fix external`` calls.

    ``height`` contacts between particles of stiffness ``stiffness`` [N/m] that
    just touch at distances of ``diameter`` [m].
    """

    def __init__(self, height: int, stiffness: float, diameter: float) -> None:
        self._stiffness = stiffness
        self._touching = diameter * np.arange(height + 1)
        matrix = np.eye(height) + 0.5 * np.eye(height, k=1) + 0.5 * np.eye(height, k=-1)
        lower = np.linalg.cholesky(matrix)
        self._upper = np.ascontiguousarray(lower.T)
        self._inverse = np.linalg.inv(lower)

    def forces(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the contact forces [N], shape (height,), at positions x [m], grain first."""
        displacement = x - self._touching
        overlap = displacement[:-1] - displacement[1:]
        if not (overlap > 0.0).any():
            return np.zeros_like(overlap)
        compression, _ = nnls(self._upper, self._inverse @ overlap)
        return np.asarray(self._stiffness * compression)

    def __call__(
        self,
        _caller: object,
        _step: int,
        count: int,
        tags: NDArray[np.int32],
        x: NDArray[np.float64],
        f: NDArray[np.float64],
    ) -> None:
        """Set the forces on the particles that LAMMPS hands over, by their ids from 1."""
        place = np.asarray(tags[:count]) - 1
        ordered = np.empty(count)
        ordered[place] = x[:count, 0]
        contact = self.forces(ordered)
        total = np.zeros(count)
        total[:-1] -= contact
        total[1:] += contact
        f[:count] = 0.0
        f[:count, 0] = total[place]
