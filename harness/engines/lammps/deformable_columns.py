"""The deformable law along columns, with a grain at the end of each that it overlaps.

The compressions are those of :class:`harness.engines.lammps.deformable.DeformableLaw`, column by
column: the grain ends every chain, so that its two contacts in a well know nothing of each other.
Dashpots act on the closed contacts, as LAMMPS's own pair style has them; like it they see the
velocities of the half step. This shares no code with the reference DEM.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from harness.engines.lammps.deformable import DeformableLaw

Floats = NDArray[np.float64]


class DeformableColumns:
    """Contact forces on a grain and ``count`` columns of ``height`` particles, a diameter apart.

    In ``of``, dashpots have the coefficients of the script's variables ``eta`` and ``eta_in``.
    """

    def __init__(
        self, count: int, height: int, stiffness: float, diameter: float,
        damping: tuple[float, float], clipped: bool,
    ) -> None:  # fmt: skip
        self._laws = [DeformableLaw(height, stiffness, diameter) for _ in range(count)]
        self._shape, self._d, self._clipped = (count, height), diameter, clipped
        self._damping = np.array([damping[0], *[damping[1]] * (height - 1)])
        self.failure = ""

    @classmethod
    def of(cls, values: Mapping[str, str], lammps: Any) -> Self:
        """Return the law of a job, from the values of its script."""
        eta = (float(lammps.extract_variable(name)) for name in ("eta", "eta_in"))
        return cls(
            int(values["spheres"]), int(values["n"]), float(values["stiffness"]),
            float(values["diameter"]), (next(eta), next(eta)), values["tail"] == "clipped",
        )  # fmt: skip

    def forces(self, x: Floats, v: Floats) -> Floats:
        """Return the forces [N] on columns, then the grain, at x [m] and v [m/s], all (N, 2).

        Raise ArithmeticError when the contacts cannot be found.
        """
        count, height = self._shape
        y, u = x[:-1, 1].reshape(self._shape), v[:-1, 1].reshape(self._shape)
        axes, period = self._d * np.arange(count), self._d * count
        apart = np.column_stack([x[-1, 0] - axes, x[-1, 1] - y[:, 0]])
        apart[:, 0] -= period * np.round(apart[:, 0] / period)
        distance = np.hypot(*apart.T)
        normal = apart / distance[:, None]
        parting = np.empty(self._shape)
        parting[:, 0] = v[-1, 0] * normal[:, 0] + (v[-1, 1] - u[:, 0]) * normal[:, 1]
        parting[:, 1:] = u[:, :-1] - u[:, 1:]
        overlap = np.empty(self._shape)
        # a gap to the grain is as good as touching: its contact stays open
        overlap[:, 0] = np.maximum(self._d - distance, 0.0)
        overlap[:, 1:] = self._d - (y[:, :-1] - y[:, 1:])
        spring = np.array([law.forces_at(o) for law, o in zip(self._laws, overlap, strict=True)])
        force = np.where(spring > 0.0, spring - self._damping * parting, 0.0)
        if self._clipped:
            force = np.maximum(force, 0.0)
        on_columns = np.zeros((count, height, 2))
        on_columns[:, 0] -= force[:, :1] * normal
        on_columns[:, :-1, 1] += force[:, 1:]
        on_columns[:, 1:, 1] -= force[:, 1:]
        return np.vstack([on_columns.reshape(-1, 2), force[:, 0] @ normal])

    def __call__(
        self, lammps: Any, _step: int, count: int, tags: NDArray[np.int32], x: Floats, f: Floats
    ) -> None:
        """Set the forces on the particles that LAMMPS hands over; failures as for one chain."""
        place = np.asarray(tags[:count]) - 1
        velocity = np.asarray(lammps.numpy.extract_atom("v"))[:count]
        ordered = np.empty((2, count, 2))
        ordered[:, place] = x[:count, :2], velocity[:, :2]
        try:
            force = self.forces(*ordered)
        except ArithmeticError as error:
            self.failure = str(error)
            force = np.full((count, 2), np.nan)
        f[:count] = 0.0
        f[:count, :2] = force[place]
