"""Points of others for comparison: a user's table, and a published critical angle."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from harness.errors import RequestError

HEIGHT, ANGLE = "h_over_d", "theta_deg"


@dataclass(frozen=True)
class PublishedAngle:
    """An angle [deg] with its uncertainty, and who found it."""

    value_deg: float
    uncertainty_deg: float
    what: str
    citation: str


PEYNEAU_ROUX = PublishedAngle(
    5.76,
    0.22,
    "quasi-static angle of frictionless spheres",
    "Peyneau and Roux, Phys. Rev. E 78, 011307 (2008)",
)


@dataclass(frozen=True)
class ReferencePoints:
    """Measured critical angles against height, as many of each."""

    name: str
    heights: tuple[float, ...]  # [diameters]
    angles_deg: tuple[float, ...]


@dataclass(frozen=True)
class Points:
    """Measured points of a user's table, as many ``x`` as ``y``."""

    name: str
    x: tuple[float, ...]
    y: tuple[float, ...]


def parse_reference(text: str, name: str) -> ReferencePoints:
    """Return the points of a CSV text with the columns ``h_over_d`` and ``theta_deg``.

    Both must be greater than 0, an angle at most 90. Raise RequestError as :func:`parse_points`.
    """
    heights, angles = _columns(text, name, {HEIGHT: (0.0, math.inf), ANGLE: (0.0, 90.0)})
    return ReferencePoints(name, heights, angles)


def parse_points(text: str, name: str, across: str, up: str) -> Points:
    """Return the points of a CSV text with the columns ``across`` and ``up``, two names.

    Other columns are left alone, empty rows skipped; rows count from 1, the
    header among them. Raise RequestError in one line: ``name``, row and what is wrong.
    """
    anywhere = (-math.inf, math.inf)
    return Points(name, *_columns(text, name, {across: anywhere, up: anywhere}))


def _columns(
    text: str, name: str, limits: Mapping[str, tuple[float, float]]
) -> Iterator[tuple[float, ...]]:
    """Return the numbers of columns, each above its first limit and up to its second."""
    reader = csv.reader(text.splitlines(), strict=True)
    rows: list[list[float]] = []
    header: list[str] = []
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if not any(cells):
                continue
            if not header:
                header = _header(cells, limits, f"{name}, row {reader.line_num}")
                continue
            where = f"{name}, row {reader.line_num}"
            if len(cells) != len(header):
                raise RequestError(f"{where}: {len(cells)} values, the header has {len(header)}")
            rows.append([_number(cells[header.index(c)], c, limits[c], where) for c in limits])
    except csv.Error as error:
        raise RequestError(f"{name}, row {reader.line_num}: {error}") from None
    if not header:
        raise RequestError(f"{name}: is empty; a header {','.join(limits)} is expected")
    if not rows:
        raise RequestError(f"{name}: holds a header, but no points")
    return zip(*rows, strict=True)


def _header(cells: Sequence[str], wanted: Iterable[str], where: str) -> list[str]:
    """Return the names of the columns, those that are wanted once each."""
    missing = [column for column in wanted if column not in cells]
    if missing:
        found = ", ".join(cells)
        for separator, spelled in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
            if separator in found:
                raise RequestError(
                    f"{where}: columns are separated by {spelled}, commas are expected"
                )
        raise RequestError(f"{where}: no column {' and '.join(missing)}; found {_short(found)}")
    for column in wanted:
        if cells.count(column) > 1:
            raise RequestError(f"{where}: {cells.count(column)} columns {column}, must be one")
    return list(cells)


def _number(text: str, column: str, limits: tuple[float, float], where: str) -> float:
    """Return a finite number above the first limit and up to the second."""
    above, most = limits
    try:
        value = float(text)
    except ValueError:
        raise RequestError(f"{where}: {column} = {_short(text)!r} is not a number") from None
    if not (math.isfinite(value) and above < value <= most):
        bounds = ["finite" if math.isinf(most) else f"at most {most:g}"]
        bounds += [] if math.isinf(above) else [f"greater than {above:g}"]
        raise RequestError(f"{where}: {column} = {text} must be {' and '.join(bounds)}")
    return value


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
