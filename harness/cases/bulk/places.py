"""Beds whose places come from a file: read, checked, written as LAMMPS and LIGGGHTS read them.

A row is radius, x, y, z [m], as in the public drivers of MercuryDPM. Lines at the top that are not
four numbers are a head. The published beds of Dosta and others (2024) lie in this folder: from
MercuryDPM's drivers ``Drivers/Papers/OSBenchmark``, that of the penetration without its last line,
the steel sphere (BSD-3-Clause, MercuryDPM developers team).
"""

from __future__ import annotations

import hashlib
import lzma
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from io import StringIO
from pathlib import Path
from typing import ClassVar

import numpy as np

from harness.cases.bulk.beds import PUBLISHED, Sphere
from harness.cases.bulk.mixing import Floats, find_contacts
from harness.errors import RequestError
from harness.files import cache_place, make_private

LARGEST_OVERLAP = 0.1  # [radii] of two grains, or of a grain and a wall, at the start
Radii = tuple[tuple[str, float], ...]  # allowed radii [m] by the names of their parameters
Ends = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Box:
    """A floor between four walls: ``length`` along x, ``width`` along y [m].

    ``middle`` (x, y) and ``floor`` z [m] are its place in a file.
    """

    length: float
    width: float
    middle: tuple[float, float]
    floor: float

    published: ClassVar[str] = "penetration-25k.txt.xz"

    @property
    def corner(self) -> tuple[float, float, float]:
        """Return the place of the origin of the case in a file [m]."""
        return self.middle[0] - self.length / 2, self.middle[1] - self.width / 2, self.floor

    def gap(self, places: Floats) -> Floats:
        """Return the distance of places (N, 3) from the nearest wall [m], (N,)."""
        x, y, z = places.T
        return np.asarray(np.min([x, self.length - x, y, self.width - y, z], axis=0))

    def __str__(self) -> str:
        """Return its name and size."""
        return f"the box, {self.length:g} by {self.width:g} m"


@dataclass(frozen=True)
class Cylinder:
    """A drum about the y axis, closed at both ends, its middle the origin of a file [m]."""

    radius: float
    length: float

    published: ClassVar[str] = "drum-38k.txt.xz"
    corner: ClassVar[tuple[float, float, float]] = (0.0, 0.0, 0.0)

    def gap(self, places: Floats) -> Floats:
        """Return the distance of places (N, 3) from the nearest wall [m], (N,)."""
        x, y, z = places.T
        return np.asarray(np.minimum(self.radius - np.hypot(x, z), self.length / 2 - np.abs(y)))

    def __str__(self) -> str:
        """Return its name and size."""
        return f"the drum, {self.radius:g} m in radius and {self.length:g} m long"


PUBLISHED_BOX = Box(0.098, 0.06, (0.0, 0.0), -0.0902431)  # by the triangles of its walls


@lru_cache(maxsize=4)
def read_grains(source: str, radii: Radii, walls: Box | Cylinder) -> Floats:
    """Return radius, x, y, z [m] of each grain, (N, 4), from the origin of the case.

    ``source`` is "published" or the path of a text file, perhaps packed as ``.xz``; ``radii`` [m]
    are allowed, by the names of their parameters. Raise RequestError, naming file and row, for a
    file that cannot be read, a row that is cut short, another radius, a grain beyond a wall, and
    overlaps of more than a tenth of a radius.
    """
    try:
        rows = _rows(_text(source, walls.published))
    except (OSError, ValueError, lzma.LZMAError) as error:
        raise RequestError(f"places {source}: cannot be read: {error}") from None
    _check_radii(source, rows, dict(radii))
    rows[:, 1:] -= np.array(walls.corner)
    _check_gaps(source, rows, walls)
    rows.flags.writeable = False
    return rows


def _text(source: str, published: str) -> str:
    path = Path(source).expanduser()
    if source == PUBLISHED:
        path = Path(__file__).with_name(published)
    packed = path.read_bytes()
    return (lzma.decompress(packed) if path.suffix == ".xz" else packed).decode("utf-8")


def _rows(text: str) -> Floats:
    """Return the numbers below a head of words and a count; raise ValueError, naming the row."""
    lines = text.splitlines()
    while lines and (len(lines[0].split()) < 2 or re.search("[a-df-z]", lines[0].lower())):
        lines = lines[1:]
    if not lines:
        raise ValueError("no row of four numbers, radius x y z")
    rows = np.loadtxt(StringIO("\n".join(lines)), ndmin=2)
    if rows.shape[1] != 4 or not np.isfinite(rows).all():
        raise ValueError(f"a row of {rows.shape[1]} numbers: must be four finite ones")
    return rows


def _check_radii(source: str, rows: Floats, radii: Mapping[str, float]) -> None:
    """Set radii that are allowed but for rounding; raise RequestError for another one."""
    allowed = np.array([*radii.values()])
    same = np.isclose(rows[:, :1], allowed, rtol=1e-9, atol=0.0)
    wrong = np.flatnonzero(~same.any(axis=1))
    if len(wrong):
        must = " or ".join(f"{name} = {radius:g} m" for name, radius in radii.items())
        raise RequestError(
            f"places {source}: grain {wrong[0] + 1} has the radius {rows[wrong[0], 0]:g} m: must "
            f"be {must}"
        )
    rows[:, 0] = allowed[same.argmax(axis=1)]


def _check_gaps(source: str, rows: Floats, walls: Box | Cylinder) -> None:
    """Raise RequestError for a grain too near to a wall, and for the two that overlap most."""
    radius, least = rows[:, 0], (1.0 - LARGEST_OVERLAP) * rows[:, 0]
    beyond = np.flatnonzero(walls.gap(rows[:, 1:]) < least)
    if len(beyond):
        place = ", ".join(f"{x:g}" for x in rows[beyond[0], 1:])
        raise RequestError(
            f"places {source}: grain {beyond[0] + 1} at ({place}) m: must be "
            f"{least[beyond[0]]:g} m from the walls of {walls}"
        )
    i, j, overlap = find_contacts(rows[:, 1:], radius)
    excess = overlap - LARGEST_OVERLAP * np.minimum(radius[i], radius[j])
    if excess.max(initial=0.0) > 0.0:
        worst = int(excess.argmax())
        distance = radius[i[worst]] + radius[j[worst]] - overlap[worst]
        raise RequestError(
            f"places {source}: grains {i[worst] + 1} and {j[worst] + 1} are {distance:g} m apart: "
            f"must be {distance + excess[worst]:g} m, an overlap of {LARGEST_OVERLAP:g} radius"
        )


def write_bed(
    source: str, radii: Radii, walls: Box | Cylinder, kinds: tuple[Sphere, ...], ends: Ends
) -> Path:
    """Write the grains of a file as a data file of ``atom_style sphere``; return its path.

    The first of ``kinds``, known by their radius, is type 1, the second 2; there are three types.
    ``ends`` of the box along x, y, z [m]. The file lies in the cache, named after its content, so
    that a job that names it states it.
    """
    text = _bed_text(source, radii, walls, kinds, ends)
    folder = cache_place().path / "beds"
    if len(str(folder).split()) > 1:  # a script's words end at spaces
        folder = Path(tempfile.gettempdir())
    path = folder / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.data"
    if not path.exists():
        make_private(folder)
        with tempfile.NamedTemporaryFile("w", dir=folder, delete=False, encoding="utf-8") as part:
            part.write(text)
        Path(part.name).replace(path)
    return path.absolute()


@lru_cache(maxsize=4)  # a setup asks for it with each run
def _bed_text(
    source: str, radii: Radii, walls: Box | Cylinder, kinds: tuple[Sphere, ...], ends: Ends
) -> str:
    rows = read_grains(source, radii, walls)
    head = [f"{len(rows)} grains", "", f"{len(rows)} atoms", "3 atom types", ""]
    head += [f"{a:.17g} {b:.17g} {n}lo {n}hi" for n, (a, b) in zip("xyz", ends, strict=True)]
    # without the comment "# sphere": LIGGGHTS takes it for a part of the section's name
    grains = [
        f"{kind} {2.0 * grain.radius:.17g} {grain.density:.17g} {x:.17g} {y:.17g} {z:.17g}"
        for kind, grain in enumerate(kinds, 1)
        for radius, x, y, z in rows.tolist()
        if radius == grain.radius
    ]
    lines = [f"{number} {grain}" for number, grain in enumerate(grains, 1)]
    return "\n".join([*head, "", "Atoms", "", *lines, ""])
