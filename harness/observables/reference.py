"""Points that users bring, and whether the samples of a run agree with one another."""

from __future__ import annotations

import csv
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.observables.row import Row

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Trajectory:
    """The grain's path: time [s], position [m] and velocity [m/s], each of shape (rows,).

    x runs along the row (unwrapped over the periodic boundary) from the centre
    of a fixed sphere, y normal to it from the line of centres.
    """

    time_s: NDArray[np.float64]
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    vx_m_per_s: NDArray[np.float64]
    vy_m_per_s: NDArray[np.float64]

    @property
    def speed_m_per_s(self) -> NDArray[np.float64]:
        """Return the speed [m/s], shape (rows,)."""
        return np.hypot(self.vx_m_per_s, self.vy_m_per_s)

    def to_frame(self) -> pd.DataFrame:
        """Return the path as a table, one row per sample."""
        import pandas as pd

        return pd.DataFrame({**vars(self), "speed_m_per_s": self.speed_m_per_s})


HEIGHT, ANGLE = "h_over_d", "theta_deg"


BELOW_ZERO = math.nextafter(0.0, -1.0)
"""Limit of numbers that may be 0: they lie above it."""

ANYWHERE = (-math.inf, math.inf)

PEYNEAU_ROUX = Row(
    "quasi-static angle of frictionless spheres",
    5.76,
    0.22,
    "deg",
    who="Peyneau and Roux, Phys. Rev. E 78, 011307 (2008)",
)


@dataclass(frozen=True)
class ReferencePoints:
    """Measured critical angles against height, as many of each."""

    name: str
    heights: tuple[float, ...]  # [diameters]
    angles_deg: tuple[float, ...]


@dataclass(frozen=True)
class Points:
    """Measured points of a user's table, as many ``x`` as ``y``, and their errors if any."""

    name: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    errors: tuple[float, ...] | None = None


def parse_reference(text: str, name: str) -> ReferencePoints:
    """Return the points of a CSV text with the columns ``h_over_d`` and ``theta_deg``.

    Both must be greater than 0, an angle at most 90. Raise RequestError as :func:`parse_points`.
    """
    heights, angles = _columns(text, name, {HEIGHT: (0.0, math.inf), ANGLE: (0.0, 90.0)})
    return ReferencePoints(name, heights, angles)


def parse_points(text: str, name: str, across: str, up: str, error: str = "") -> Points:
    """Return the points of a CSV text with the columns ``across`` and ``up``, two names.

    ``error`` is a third that a table may have: errors of ``up``, 0 or greater. Other columns are
    left alone, empty rows skipped; rows count from 1, the header among them. Raise RequestError
    in one line: ``name``, row and what is wrong.
    """
    wanted = {across: ANYWHERE, up: ANYWHERE}
    header = next((line for line in text.splitlines() if line.strip(", ")), "")
    if error and error in [cell.strip().strip('"') for cell in header.split(",")]:
        wanted[error] = (BELOW_ZERO, math.inf)
    return Points(name, *_columns(text, name, wanted))


def _columns(
    text: str, name: str, limits: Mapping[str, tuple[float, float]]
) -> Iterator[tuple[float, ...]]:
    rows = [
        [_number(cells[c], c, limits[c], where) for c in limits]
        for where, cells in _rows(text, name, limits)
    ]
    if not rows:
        raise RequestError(f"{name}: holds a header, but no points")
    return zip(*rows, strict=True)


def _rows(text: str, name: str, wanted: Collection[str]) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield where each row is, and its cells by their columns."""
    reader = csv.reader(text.splitlines(), strict=True)
    header: list[str] = []
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if not any(cells):
                continue
            if not header:
                header = _header(cells, wanted, f"{name}, row {reader.line_num}")
                continue
            where = f"{name}, row {reader.line_num}"
            if len(cells) != len(header):
                raise RequestError(f"{where}: {len(cells)} values, the header has {len(header)}")
            yield where, dict(zip(header, cells, strict=True))
    except csv.Error as error:
        raise RequestError(f"{name}, row {reader.line_num}: {error}") from None
    if not header:
        raise RequestError(f"{name}: is empty; a header {','.join(wanted)} is expected")


def _header(cells: Sequence[str], wanted: Iterable[str], where: str) -> list[str]:
    missing = [column for column in wanted if column not in cells]
    if missing:
        names = ", ".join(cells)
        for separator, spelled in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
            if separator in names:
                raise RequestError(
                    f"{where}: columns are separated by {spelled}, commas are expected"
                )
        raise RequestError(f"{where}: no column {' and '.join(missing)}; found {_short(names)}")
    for column in wanted:
        if cells.count(column) > 1:
            raise RequestError(f"{where}: {cells.count(column)} columns {column}, must be one")
    return list(cells)


def _number(text: str, column: str, limits: tuple[float, float], where: str) -> float:
    above, most = limits
    try:
        value = float(text)
    except ValueError:
        raise RequestError(f"{where}: {column} = {_short(text)!r} is not a number") from None
    if not (math.isfinite(value) and above < value <= most):
        bounds = ["finite" if math.isinf(most) else f"at most {most:g}"]
        low = "0 or greater" if above == BELOW_ZERO else f"greater than {above:g}"
        bounds += [] if math.isinf(above) else [low]
        raise RequestError(f"{where}: {column} = {text} must be {' and '.join(bounds)}")
    return value


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."


Floats: TypeAlias = NDArray[np.float64]

ROOM = 3.0
"""Times the bound: codes in velocity Verlet leave 0.25 to 0.3 of it, whatever the step."""

AROUND = 3
"""Intervals on either side whose differences count."""

FEWEST = 5
"""Samples that differences need."""


# ---- whether samples belong together: positions, velocities, accelerations
#
# Over an interval h a value y changes by h/2 (y'_1 + y'_2), to within h^3/12 y'''. What is left is
# held against second differences of the rate, h |D2 y'|, and against third differences of the
# value itself, |D3 y|, of the intervals around: each bounds it, also where a rate jumps (by J
# within the interval: at most h J/2 is left, the differences are h J, and h J/2 at least). A wrong
# sample opens its own bound and not the other's, so the smaller of the two is what a motion must
# keep.


def contradiction(
    values: Floats, rates: Floats, interval: float, rounding: float, late: float = 0.0
) -> tuple[int, int] | None:
    """Return row and column of the first sample where values do not move with their rates.

    ``values`` and ``rates`` are (M, N), M samples ``interval`` [s] apart; ``rounding`` is that of
    a value; ``late`` [s] is how far the rates may be from the time of the values. None where all
    belong together, or where there are too few to tell.
    """
    if len(values) < FEWEST:
        return None
    residual = np.abs(np.diff(values, axis=0) - 0.5 * interval * (rates[1:] + rates[:-1]))
    by_rates = interval * _around(np.diff(rates, 2, axis=0), len(residual))
    by_values = _around(np.diff(values, 3, axis=0), len(residual))
    if late > 0.0:
        by_rates += late * _around(np.diff(rates, axis=0), len(residual))
        by_values += late / interval * _around(np.diff(values, 2, axis=0), len(residual))
    allowed = ROOM * np.minimum(by_rates, by_values)
    allowed += rounding + interval * float(np.finfo(float).eps) * np.abs(rates).max(initial=0.0)
    wrong = np.argwhere(residual > allowed)
    return None if wrong.size == 0 else (int(wrong[0, 0]) + 1, int(wrong[0, 1]))


def _around(differences: Floats, intervals: int) -> Floats:
    """Return the largest size of differences around each interval, shape (intervals, N)."""
    sizes = np.abs(differences)
    most = np.zeros((intervals, *sizes.shape[1:]))
    for shift in range(-AROUND, AROUND):
        first, last = max(0, -shift), min(intervals, len(sizes) - shift)
        np.maximum(most[first:last], sizes[first + shift : last + shift], out=most[first:last])
    return most
