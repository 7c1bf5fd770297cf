"""Critical angles of others for comparison: a user's table and a published value."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
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


def parse_reference(text: str, name: str) -> ReferencePoints:
    """Return the points of a CSV text with the columns ``h_over_d`` and ``theta_deg``.

    Other columns are left alone, empty rows skipped; rows count from 1, the
    header among them. Raise RequestError in one line: ``name``, row and what is wrong.
    """
    reader = csv.reader(text.splitlines(), strict=True)
    heights: list[float] = []
    angles: list[float] = []
    header: list[str] = []
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if not any(cells):
                continue
            if not header:
                header = _header(cells, f"{name}, row {reader.line_num}")
                continue
            where = f"{name}, row {reader.line_num}"
            if len(cells) != len(header):
                raise RequestError(f"{where}: {len(cells)} values, the header has {len(header)}")
            heights.append(_number(cells[header.index(HEIGHT)], HEIGHT, math.inf, where))
            angles.append(_number(cells[header.index(ANGLE)], ANGLE, 90.0, where))
    except csv.Error as error:
        raise RequestError(f"{name}, row {reader.line_num}: {error}") from None
    if not header:
        raise RequestError(f"{name}: is empty; a header {HEIGHT},{ANGLE} is expected")
    if not heights:
        raise RequestError(f"{name}: holds a header, but no points")
    return ReferencePoints(name, tuple(heights), tuple(angles))


def _header(cells: Sequence[str], where: str) -> list[str]:
    """Return the names of the columns, the two wanted once each."""
    missing = [column for column in (HEIGHT, ANGLE) if column not in cells]
    if missing:
        found = ", ".join(cells)
        for separator, spelled in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
            if separator in found:
                raise RequestError(
                    f"{where}: columns are separated by {spelled}, commas are expected"
                )
        raise RequestError(f"{where}: no column {' and '.join(missing)}; found {_short(found)}")
    for column in (HEIGHT, ANGLE):
        if cells.count(column) > 1:
            raise RequestError(f"{where}: {cells.count(column)} columns {column}, must be one")
    return list(cells)


def _number(text: str, column: str, most: float, where: str) -> float:
    """Return a height or an angle; it must be positive, and ``most`` at most."""
    try:
        value = float(text)
    except ValueError:
        raise RequestError(f"{where}: {column} = {_short(text)!r} is not a number") from None
    if not (math.isfinite(value) and 0 < value <= most):
        bound = "finite and" if math.isinf(most) else f"at most {most:g} and"
        raise RequestError(f"{where}: {column} = {text} must be {bound} greater than 0")
    return value


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."
