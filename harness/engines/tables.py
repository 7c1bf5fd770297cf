"""Read the tables that scripts write: CSV with a header, dumps with a block a sample."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING

from harness.engines.output import Table
from harness.errors import EngineNaNError, EngineOutputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_PARTICLE = re.compile(r"(\w+)\[(\d+)\]")
_HEADER = 9
"""Lines above the particles of a frame of a dump."""

_UNITS = {
    "x": "x_m",
    "xu": "x_m",
    "yu": "y_m",
    "zu": "z_m",
    "y": "y_m",
    "z": "z_m",
    "vx": "vx_m_per_s",
    "vy": "vy_m_per_s",
    "vz": "vz_m_per_s",
    "fx": "fx_N",
    "fy": "fy_N",
    "fz": "fz_N",
    "radius": "radius_m",
    "omegax": "wx_rad_per_s",
    "omegay": "wy_rad_per_s",
    "omegaz": "wz_rad_per_s",
    "tqx": "tx_N_m",
    "tqy": "ty_N_m",
    "tqz": "tz_N_m",
}
"""Columns of a dump in SI units, by their names there."""


_KEPT = ("xu", "yu", "zu", "vx", "vy", "vz", "omegax", "omegay", "omegaz", "radius")
"""Columns of a dump that are the same to the last digit where a run is taken up."""


def read_csv(text: str, who: str, *, rising: bool = False) -> Table:
    """Return the columns of a CSV by its header, each (M,).

    Columns ``x_m[1]``, ``x_m[2]``, ... of N particles are one, ``x_m`` (M, N). With ``rising`` a
    row that is the same as the one before is left out: some codes print a row twice where two
    stretches of a run meet. Raise EngineOutputError for a text without rows, cut within its last
    row, or that cannot be read; with ``rising``, also for rows of one time that differ or a time
    that falls, and EngineNaNError for values that are not finite.
    """
    import numpy as np

    header, _, body = text.partition("\n")
    if not body.strip() or not text.endswith("\n"):
        raise EngineOutputError(f"{who} left a series without rows, or cut in its last row")
    names = [name.strip().strip('"') for name in header.lstrip("# ").split(",")]
    try:
        rows = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2)
        if rows.shape[1] != len(names):
            raise ValueError(f"{rows.shape[1]} columns under {len(names)} names")
    except ValueError as error:
        raise EngineOutputError(f"{who} left an incomplete series ({error})") from None
    if rising:
        if not np.isfinite(rows).all():
            raise EngineNaNError(f"{who} wrote a series with values that are not numbers")
        rows = rows[_once(rows, names[0], who)]
    return _columns(names, rows, who)


def _once(rows: NDArray[np.float64], clock: str, who: str) -> NDArray[np.bool_]:
    """Return which rows (M, ...) are not those before them again; the first column is the clock.

    Raise EngineOutputError for another row of the same time, or of an earlier one.
    """
    import numpy as np

    later = np.diff(rows[:, 0], prepend=-np.inf) > 0.0
    same = np.concatenate([[False], (rows[1:] == rows[:-1]).all(axis=1)])
    wrong = np.flatnonzero(~later & ~same)
    if wrong.size:
        row = int(wrong[0])
        raise EngineOutputError(
            f"{who} wrote a series out of order: row {row + 1} is of {clock} = {rows[row, 0]:.9g}, "
            f"the row before of {rows[row - 1, 0]:.9g}, and differs"
        )
    return later


def _columns(names: list[str], rows: NDArray[np.float64], who: str) -> Table:
    """Return columns by name, those of particles side by side in the order of their numbers."""
    table: dict[str, NDArray[np.float64]] = {}
    particles: dict[str, dict[int, int]] = {}
    for index, name in enumerate(names):
        of_particle = _PARTICLE.fullmatch(name)
        if of_particle is None:
            table[name] = rows[:, index]
        else:
            particles.setdefault(of_particle[1], {})[int(of_particle[2])] = index
    for name, places in particles.items():
        if sorted(places) != list(range(1, len(places) + 1)):
            raise EngineOutputError(f"{who} left a series that lacks columns of {name}")
        # particles of a row side by side in memory: sums over them then round alike
        table[name] = rows[:, [places[number] for number in sorted(places)]].copy()
    return table


def read_dump(text: str, who: str) -> Table:
    """Return the columns of a dump, ``step`` (M,) and the rest (M, N), sorted by id.

    ``x``, ``vx``, ``fx`` and so on are named with their SI units. A frame that comes again where a
    run was taken up is left out. Raise EngineOutputError for a dump that is cut, whose frames hold
    different particles, or are of one step with other velocities.
    """
    import numpy as np

    lines = text.splitlines()
    try:
        if not text.endswith("\n") or len(lines) < _HEADER:
            raise ValueError("it is cut")
        count = int(lines[3])
        names = lines[_HEADER - 1].split()[2:]
        block = _HEADER + count
        if len(lines) % block:
            raise ValueError(f"{len(lines)} lines, not blocks of {block}")
        starts = range(_HEADER, len(lines), block)
        if any(int(lines[start - _HEADER + 3]) != count for start in starts):
            raise ValueError("the number of particles changes")
        steps = np.array([float(line) for line in lines[1::block]])
        rows = "\n".join(line for i in starts for line in lines[i : i + count])
        frames = np.loadtxt(io.StringIO(rows), ndmin=2).reshape(len(steps), count, len(names))
        ids = frames[:, :, names.index("id")]
        order = np.argsort(ids, axis=1)
        if np.any(np.sort(ids, axis=1) != np.sort(ids[0])):
            raise ValueError("particles come or go")
    except ValueError as error:
        raise EngineOutputError(f"{who} wrote a dump that cannot be read ({error})") from None
    frames = np.take_along_axis(frames, order[:, :, None], axis=1)
    # forces are computed anew where a run is taken up, and places wrapped
    state = frames[:, :, [i for i, name in enumerate(names) if name in _KEPT]]
    first = _once(np.column_stack([steps, state.reshape(len(steps), -1)]), "step", who)
    frames = frames[first]
    table = {_UNITS.get(n, n): frames[:, :, i] for i, n in enumerate(names) if n != "id"}
    return {"step": steps[first], **table}
