"""Motions as LAMMPS text dumps, the format that OVITO and LAMMPS's read_dump open.

One snapshot a frame; the timestep counts frames, ``ITEM: TIME`` has the time [s].
OVITO takes ``radius``, ``shapex shapey shapez`` (diameters, it draws ellipsoids),
velocities and forces for what they are; columns with ``v_`` come in by their name.
"""

from __future__ import annotations

import gzip
import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
    tower, n = motion.run.tower, motion.run.tower.particles
    down = tower.gravity > 0
    sign, axis = (-1.0, "z") if down else (1.0, "x")
    diameter = np.array(tower.each("diameter"))
    centres, widths = motion.drawn_centres, motion.drawn_widths
    force = np.pad(motion.force, ((0, 0), (1, 1)))
    columns: dict[str, ArrayLike] = dict.fromkeys(ROW_COLUMNS, 0.0)
    columns |= dict.fromkeys(("shapex", "shapey", "shapez"), diameter)
    columns |= {
        "id": np.arange(1, n + 1),
        "type": [1.0] + [2.0] * (n - 2) + [3.0 if tower.base == "fixed" else 2.0],
        "radius": diameter / 2,
        f"shape{axis}": widths,
        axis: sign * centres,
        f"v{axis}": sign * motion.velocity,
        f"f{axis}": sign * (force[:, :-1] - force[:, 1:]),
        "v_displacement": motion.displacement,
        "v_deformation": motion.deformation,
        "v_contact_force": force[:, 1:],
    }
    low, high = float((centres - widths).min()), float((centres + widths).max())
    along, across = ((-high, -low) if down else (low, high)), (-1.0, 1.0)
    bounds = (across, across, along) if down else (along, across, across)
    return _zipped(motion.time, n, columns, bounds)


def incline_dump(motion: InclineMotion) -> bytes:
    """Return both inclines as one dump, true to the runs, rows along x and normal to y.

    Molecule 1 is the row below the critical angle, 2 the one above it, 3 diameters
    aside; type 1 are fixed spheres, 2 is the grain. Gravity is tilted.
    """
    d = motion.below.case.diameter
    paths = [motion.path(run) for run in motion.runs]
    spheres = int(max(float(path.x_m.max()) for path in paths) / d) + 2
    lane = np.repeat([0, 1], spheres + 1)  # the grain is the last of each
    grains = [spheres, 2 * spheres + 1]
    columns = {name: np.zeros((motion.time.size, lane.size)) for name in INCLINE_COLUMNS}
    columns["id"][:] = np.arange(1, lane.size + 1)
    columns["type"][:] = np.isin(np.arange(lane.size), grains) + 1
    columns["mol"][:] = lane + 1
    columns["x"][:] = d * (np.arange(lane.size) % (spheres + 1))
    columns["y"][:] = _LANE * d * (1 - lane)
    columns["radius"][:] = d / 2
    for grain, path in zip(grains, paths, strict=True):
        columns["x"][:, grain] = path.x_m
        columns["y"][:, grain] += path.y_m
        columns["vx"][:, grain] = path.vx_m_per_s
        columns["vy"][:, grain] = path.vy_m_per_s
    bounds = ((-d, spheres * d), (-d, (_LANE + 2) * d), (-d, d))
    return _zipped(motion.time, lane.size, columns, bounds)


def _zipped(
    times: Floats,
    atoms: int,
    columns: Mapping[str, ArrayLike],
    bounds: Sequence[tuple[float, float]],
) -> bytes:
    """Return snapshots of ``columns``, each (frames, atoms), as a gzipped text dump.

    The same bytes each time, on every machine.
    """
    shape = (times.size, atoms)
    frames = np.stack(
        [_without_round_off(np.broadcast_to(values, shape)) for values in columns.values()], axis=-1
    )
    # units once, at the top: OVITO takes a second one for the end of the file
    parts = ["ITEM: UNITS\nsi\n"]
    box = "\n".join(f"{low:.9g} {high:.9g}" for low, high in bounds)
    form = " ".join("%d" if name in _WHOLE else "%.7g" for name in columns)
    for step, (time, table) in enumerate(zip(times, frames, strict=True)):
        rows = "\n".join(form % tuple(row) for row in table)
        parts.append(
            f"ITEM: TIME\n{time:.9g}\nITEM: TIMESTEP\n{step}\n"
            f"ITEM: NUMBER OF ATOMS\n{atoms}\nITEM: BOX BOUNDS ff ff ff\n{box}\n"
            f"ITEM: ATOMS {' '.join(columns)}\n{rows}\n"
        )
    return gzip.compress("".join(parts).encode("ascii"), 9, mtime=0)


def _without_round_off(values: Floats) -> Floats:
    """Return numbers to ten digits of the largest.

    What is left of a difference of larger numbers would be another on another machine.
    """
    largest = float(np.abs(values).max())
    digits = 10 - math.floor(math.log10(largest)) if largest else 0
    return np.round(values, digits) + 0.0  # no minus before a zero
