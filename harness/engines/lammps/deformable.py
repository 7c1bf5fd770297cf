"""The deformable law as an external force on LAMMPS's own particles, in a row or along columns.

LAMMPS integrates, this gives the forces: what then differs from RK4 under the same law is the
integration. The compressions c of the contacts solve

    w = T c - delta >= 0,   c >= 0,   c . w = 0,   T = tridiag(1/2, 1, 1/2).

This shares no code with the chain solvers: dense algebra, and Murty's least index method (Math.
Programming 7, 1974), which ends for a positive definite T whatever set of contacts it starts from.
(SciPy's NNLS, tried first, returns wrong forces where an overlap is exactly zero, as in a row that
falls freely.)

Along columns the compressions are those of each column, at whose end is a grain that overlaps it:
the grain ends every chain, so that its two contacts in a well know nothing of each other. Dashpots
act on the closed contacts, as LAMMPS's own pair style has them; like it they see the velocities of
the half step. This shares no code with the reference DEM.

The script has ``fix deformable all external pf/callback 1 1``; the law is set up at the line that
begins with :data:`MOTION`, after the particles are there.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
MOTION = re.compile(r"^# ---- motion.*$", re.MULTILINE)
SLACK = 1e-13  # forces and gaps this far below zero, over the largest overlap, are rounding
MOST_PIVOTS = 100  # exchanges for each contact; from the last step's set it takes none or one


def run_deformable(lammps: Any, script: Path, values: Mapping[str, str]) -> None:
    """Run a script under the deformable law, along columns where it has ``n`` particles in each.

    As two files in its folder: jumps find their labels within a file only. Raise RuntimeError for
    an error of the force.
    """
    parts = MOTION.split(script.read_text(encoding="utf-8"))
    if len(parts) != 2:
        raise RuntimeError("ERROR: the script has no one line '# ---- motion' for its force")
    setting, motion = (script.with_suffix(f".{name}") for name in ("setting", "motion"))
    setting.write_text(parts[0], encoding="utf-8")
    motion.write_text(parts[1], encoding="utf-8")
    lammps.file(str(setting))
    stiffness, diameter = float(values["stiffness"]), float(values["diameter"])
    law: ExternalForce
    if "n" in values:
        first, inner = (float(lammps.extract_variable(name)) for name in ("eta", "eta_in"))
        count, height, clipped = int(values["spheres"]), int(values["n"]), values["tail"]
        damping = first, inner
        law = DeformableColumns(count, height, stiffness, diameter, damping, clipped == "clipped")
    else:
        law = DeformableLaw(int(values["height"]), stiffness, diameter)
    lammps.set_fix_external_callback("deformable", law, lammps)
    try:
        lammps.file(str(motion))
    finally:
        if law.failure:
            raise RuntimeError(f"ERROR: {law.failure}")


class ExternalForce:
    """Contact forces in the form that LAMMPS's ``fix external`` calls.

    An exception would be lost on its way through LAMMPS: it is kept in ``failure``, and forces that
    are not numbers end the run.
    """

    failure = ""

    def total(self, x: Floats, v: Floats) -> Floats:
        """Return the forces [N] of particles in the order of their ids, at x [m] and v [m/s].

        All have the shape (N, 2). Raise ArithmeticError when the contacts cannot be found.
        """
        raise NotImplementedError

    def __call__(
        self, lammps: Any, _step: int, count: int, tags: NDArray[np.int32], x: Floats, f: Floats
    ) -> None:
        """Set the forces on the particles that LAMMPS hands over, by their ids from 1."""
        place = np.asarray(tags[:count]) - 1
        velocity = np.asarray(lammps.numpy.extract_atom("v"))[:count]
        ordered = np.empty((2, count, 2))
        ordered[:, place] = x[:count, :2], velocity[:, :2]
        try:
            force = self.total(*ordered)
        except ArithmeticError as error:
            self.failure = str(error)
            force = np.full((count, 2), np.nan)
        f[:count] = 0.0
        f[:count, :2] = force[place]


class DeformableLaw(ExternalForce):
    """Contact forces along a chain of ``height`` contacts, grain first.

    Its particles have the stiffness ``stiffness`` [N/m], and just touch at distances of
    ``diameter`` [m].
    """

    def __init__(self, height: int, stiffness: float, diameter: float) -> None:
        self._stiffness = stiffness
        self._touching = diameter * np.arange(height + 1)
        self._matrix = np.eye(height) + 0.5 * np.eye(height, k=1) + 0.5 * np.eye(height, k=-1)
        self._closed = np.zeros(height, dtype=bool)

    def forces(self, x: Floats) -> Floats:
        """Return the contact forces [N], shape (height,), at positions x [m], grain first.

        Raise ArithmeticError when the contacts cannot be found.
        """
        displacement = x - self._touching
        return self.forces_at(displacement[:-1] - displacement[1:])

    def forces_at(self, overlap: Floats) -> Floats:
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

    def total(self, x: Floats, v: Floats) -> Floats:  # noqa: ARG002
        """Return the forces on a chain along x, grain first."""
        contact = self.forces(x[:, 0])
        total = np.zeros_like(x)
        total[:-1, 0] -= contact
        total[1:, 0] += contact
        return total


class DeformableColumns(ExternalForce):
    """Contact forces on a grain and ``count`` columns of ``height`` particles, a diameter distant.

    ``damping`` are the coefficients [kg/s] of the grain's dashpots, and of those within columns.
    """

    def __init__(
        self, count: int, height: int, stiffness: float, diameter: float,
        damping: tuple[float, float], clipped: bool,
    ) -> None:  # fmt: skip
        self._laws = [DeformableLaw(height, stiffness, diameter) for _ in range(count)]
        self._shape, self._d, self._clipped = (count, height), diameter, clipped
        self._damping = np.array([damping[0], *[damping[1]] * (height - 1)])

    def total(self, x: Floats, v: Floats) -> Floats:
        """Return the forces on columns, one after the other from the top, then the grain."""
        count, height = self._shape
        y, u = x[:-1, 1].reshape(self._shape), v[:-1, 1].reshape(self._shape)
        axes, period = self._d * np.arange(count), self._d * count
        offset = np.column_stack([x[-1, 0] - axes, x[-1, 1] - y[:, 0]])
        offset[:, 0] -= period * np.round(offset[:, 0] / period)
        distance = np.hypot(*offset.T)
        normal = offset / distance[:, None]
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
