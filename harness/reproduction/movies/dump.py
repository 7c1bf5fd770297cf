"""Motions as LAMMPS text dumps, the format that OVITO and LAMMPS's read_dump open.

One snapshot a frame; the timestep counts frames, ``ITEM: TIME`` has the time [s].
OVITO takes ``radius``, ``shapex shapey shapez`` (diameters, it draws ellipsoids),
velocities and forces for what they are; columns with ``v_`` come in by their name.
"""

from __future__ import annotations

import gzip
import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.result import InclineRun
from harness.reproduction.movies.frames import InclineMotion, RowMotion

Floats = NDArray[np.float64]

ROW_COLUMNS = (
    "id", "type", "x", "y", "z", "radius", "shapex", "shapey", "shapez",
    "vx", "vy", "vz", "fx", "fy", "fz", "v_displacement", "v_deformation", "v_contact_force",
)  # fmt: skip
INCLINE_COLUMNS = ("id", "type", "mol", "x", "y", "z", "radius", "vx", "vy", "vz")
_LANE = 3.0  # diameters between the two rows of the incline
_WHOLE = {"id", "type", "mol"}


def row_dump(motion: RowMotion) -> bytes:
    """Return a row as a dump, along x, or down -z where gravity acts.

    Type 1 is the grain, 2 the others, 3 a fixed base. Positions and shapes are
    exaggerated as in the movie, or nothing would be seen to move. All else is true to
    the run: velocities, net contact forces, ``v_displacement`` and
    ``v_deformation`` [m], and ``v_contact_force`` [N] with the next particle.
    """
    down = motion.run.tower.gravity > 0
    frames = range(motion.time.size)
    centres, widths = motion.drawn_centres, motion.drawn_widths
    low, high = float((centres - widths).min()), float((centres + widths).max())
    along, across = ((-high, -low) if down else (low, high)), (-1.0, 1.0)
    bounds = (across, across, along) if down else (along, across, across)
    tables = (_row_table(motion, frame, down) for frame in frames)
    return _zipped(ROW_COLUMNS, motion.time, tables, bounds)


def incline_dump(motion: InclineMotion) -> bytes:
    """Return both inclines as one dump, true to the runs, rows along x and normal to y.

    Molecule 1 is the row below the critical angle, 2 the one above it, 3 diameters
    aside; type 1 are fixed spheres, 2 is the grain. Gravity is tilted.
    """
    frames = range(motion.time.size)
    d = motion.below.case.diameter
    ends = [motion.path(run) for run in motion.runs]
    spheres = int(max(float(path.x_m.max()) for path in ends) / d) + 2
    bounds = ((-d, spheres * d), (-d, (_LANE + 2) * d), (-d, d))
    lanes = [_lane_tables(motion, run, lane, spheres) for lane, run in enumerate(motion.runs)]
    tables = (np.vstack([lane[frame] for lane in lanes]) for frame in frames)
    return _zipped(INCLINE_COLUMNS, motion.time, tables, bounds)


def _row_table(motion: RowMotion, frame: int, down: bool) -> Floats:
    """Return the atoms of one frame (N, columns)."""
    tower, n = motion.run.tower, motion.run.tower.particles
    sign, axis = (-1.0, "z") if down else (1.0, "x")
    diameter = np.array(tower.each("diameter"))
    force = np.pad(motion.force[frame], 1)
    columns = dict.fromkeys(ROW_COLUMNS, np.zeros(n))
    columns["id"] = np.arange(1.0, n + 1)
    columns["type"] = np.array([1.0] + [2.0] * (n - 2) + [3.0 if tower.base == "fixed" else 2.0])
    columns["radius"] = diameter / 2
    columns |= dict.fromkeys(("shapex", "shapey", "shapez"), diameter)
    columns[f"shape{axis}"] = motion.drawn_widths[frame]
    columns[axis] = sign * motion.drawn_centres[frame]
    columns[f"v{axis}"] = sign * motion.velocity[frame]
    columns[f"f{axis}"] = sign * (force[:-1] - force[1:])
    columns["v_displacement"] = motion.displacement[frame]
    columns["v_deformation"] = motion.deformation[frame]
    columns["v_contact_force"] = force[1:]
    return np.column_stack([columns[name] for name in ROW_COLUMNS])


def _lane_tables(motion: InclineMotion, run: InclineRun, lane: int, spheres: int) -> list[Floats]:
    """Return the atoms of one row, frame by frame (spheres + 1, columns)."""
    path, d = motion.path(run), run.case.diameter
    row = np.zeros((spheres + 1, len(INCLINE_COLUMNS)))
    row[:, 0] = lane * (spheres + 1) + np.arange(1, spheres + 2)
    row[:, 1] = [1] * spheres + [2]
    row[:, 2] = lane + 1
    row[:-1, 3] = d * np.arange(spheres)
    row[:, 4] = _LANE * d * (1 - lane)
    row[:, 6] = d / 2
    tables = []
    for x, y, vx, vy in zip(path.x_m, path.y_m, path.vx_m_per_s, path.vy_m_per_s, strict=True):
        table = row.copy()
        table[-1, 3] = x
        table[-1, 4] += y
        table[-1, 7:9] = vx, vy
        tables.append(table)
    return tables


def _zipped(
    columns: Sequence[str],
    times: Floats,
    tables: Iterable[Floats],
    bounds: Sequence[tuple[float, float]],
) -> bytes:
    """Return snapshots as a gzipped text dump, the same bytes each time."""
    # units once, at the top: OVITO takes a second one for the end of the file
    parts = ["ITEM: UNITS\nsi\n"]
    box = "\n".join(f"{low:.9g} {high:.9g}" for low, high in bounds)
    form = " ".join("%d" if name in _WHOLE else "%.7g" for name in columns)
    for step, (time, table) in enumerate(zip(times, _without_round_off(tables), strict=True)):
        rows = "\n".join(form % tuple(row) for row in table)
        parts.append(
            f"ITEM: TIME\n{time:.9g}\nITEM: TIMESTEP\n{step}\n"
            f"ITEM: NUMBER OF ATOMS\n{len(table)}\nITEM: BOX BOUNDS ff ff ff\n{box}\n"
            f"ITEM: ATOMS {' '.join(columns)}\n{rows}\n"
        )
    return gzip.compress("".join(parts).encode("ascii"), 9, mtime=0)


def _without_round_off(tables: Iterable[Floats]) -> Floats:
    """Return tables (F, N, columns) to ten digits of each column's largest number.

    What is left of a difference of larger numbers would be another on another machine.
    """
    frames = np.array(list(tables))
    for column in np.moveaxis(frames, -1, 0):
        largest = float(np.abs(column).max())
        if largest:
            np.round(column, 10 - math.floor(math.log10(largest)), out=column)
    return frames + 0.0  # no minus before a zero
