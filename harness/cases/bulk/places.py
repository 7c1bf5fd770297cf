"""Beds whose places come from a file: read, checked, written as LAMMPS and LIGGGHTS read them.

A row is radius, x, y, z [m], as in the public drivers of MercuryDPM. Lines at the top that are not
numbers are a head, and so is a number of grains alone.
"""

from __future__ import annotations

import hashlib
import lzma
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from harness.cases.bulk.mixing import touching
from harness.errors import RequestError
from harness.files import cache_place, make_private

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

PUBLISHED = "published"
"""Stands for a bed of Dosta and others (2024), which lies beside this module.

From MercuryDPM's drivers ``Drivers/Papers/OSBenchmark``, the penetration's without the last line,
which is the steel sphere: BSD-3-Clause, MercuryDPM developers team.
"""

LARGEST_OVERLAP = 0.1
"""[radii] of two grains, or of a grain and a wall, at the start."""


@dataclass(frozen=True)
class Box:
    """A floor between four walls: ``length`` along x, ``width`` along y [m].

    ``middle`` (x, y) and ``floor`` z [m] are where it lies in a file.
    """

    length: float
    width: float
    middle: tuple[float, float]
    floor: float

    published: ClassVar[str] = "penetration-25k.txt.xz"

    @property
    def corner(self) -> tuple[float, float, float]:
        """Return where the origin of the case lies in a file [m]."""
        return (self.middle[0] - self.length / 2, self.middle[1] - self.width / 2, self.floor)

    def gap(self, places: Floats) -> Floats:
        """Return how far places (N, 3) are from the nearest wall [m], (N,)."""
        x, y, z = places.T
        return np.asarray(np.min([x, self.length - x, y, self.width - y, z], axis=0))

    def __str__(self) -> str:
        """Return what it is."""
        return f"the box, {self.length:g} by {self.width:g} m"


@dataclass(frozen=True)
class Cylinder:
    """A drum about the y axis, closed at both ends, its middle the origin of a file [m]."""

    radius: float
    length: float

    published: ClassVar[str] = "drum-38k.txt.xz"
    corner: ClassVar[tuple[float, float, float]] = (0.0, 0.0, 0.0)

    def gap(self, places: Floats) -> Floats:
        """Return how far places (N, 3) are from the nearest wall [m], (N,)."""
        x, y, z = places.T
        return np.asarray(np.minimum(self.radius - np.hypot(x, z), self.length / 2 - np.abs(y)))

    def __str__(self) -> str:
        """Return what it is."""
        return f"the drum, {self.radius:g} m in radius and {self.length:g} m long"


PUBLISHED_BOX = Box(0.098, 0.06, (0.0, 0.0), -0.0902431)
"""By the triangles of its walls."""


def read_places(source: str, radius: float, box: Box) -> Floats:
    """Return places (N, 3) [m] in a box whose corner is the origin: of grains of one radius."""
    return read_grains(source, (("radius", radius),), box)[:, 1:]


@lru_cache(maxsize=4)
def read_grains(source: str, radii: tuple[tuple[str, float], ...], walls: Box | Cylinder) -> Floats:
    """Return radius, x, y, z [m] of each grain, (N, 4).

    ``source`` is :data:`PUBLISHED` or the path of a text file, perhaps packed as ``.xz``; ``radii``
    [m] are allowed, by the names of their parameters. Raise RequestError, naming file and row, for
    a file that cannot be read, a row that is cut short, another radius, a grain beyond a wall, and
    overlaps of more than :data:`LARGEST_OVERLAP`.
    """
    rows = _rows(source, walls.published)
    allowed = np.array([radius for _, radius in radii])
    same = np.isclose(rows[:, :1], allowed, rtol=1e-9, atol=0.0)
    wrong = np.flatnonzero(~same.any(axis=1))
    if len(wrong):
        must = " or ".join(f"{name} = {radius:g} m" for name, radius in radii)
        raise RequestError(
            f"places {source}: grain {wrong[0] + 1} has the radius {rows[wrong[0], 0]:g} m: must "
            f"be {must}"
        )
    rows[:, 0] = allowed[same.argmax(axis=1)]
    rows[:, 1:] -= np.array(walls.corner)
    _check_walls(source, rows, walls)
    _check_overlaps(source, rows)
    rows.flags.writeable = False
    return rows


def _rows(source: str, published: str) -> Floats:
    """Return radius, x, y, z of each grain, (N, 4)."""
    path = Path(source).expanduser()
    if source == PUBLISHED:
        path = Path(__file__).with_name(published)
    try:
        packed = path.read_bytes()
        text = (lzma.decompress(packed) if path.suffix == ".xz" else packed).decode("utf-8")
    except (OSError, lzma.LZMAError, UnicodeDecodeError) as error:
        raise RequestError(f"places {source}: cannot be read: {error}") from None
    rows: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            row = [float(word) for word in line.split()]
        except ValueError:
            row = []
        if len(row) == 4 and np.isfinite(row).all():
            rows.append(row)
        elif line.strip() and (rows or (row and not line.strip().isdecimal())):
            raise RequestError(
                f"places {source}, line {number}: {line.strip()[:40]!r}: must be four numbers, "
                "radius x y z"
            )
    if not rows:
        raise RequestError(f"places {source}: no line of four numbers, radius x y z")
    return np.array(rows)


def _check_walls(source: str, rows: Floats, walls: Box | Cylinder) -> None:
    """Raise RequestError for a grain that overlaps a wall by more than is allowed."""
    least = (1.0 - LARGEST_OVERLAP) * rows[:, 0]
    beyond = np.flatnonzero(walls.gap(rows[:, 1:]) < least)
    if len(beyond):
        first = beyond[0]
        x, y, z = rows[first, 1:]
        raise RequestError(
            f"places {source}: grain {first + 1} at ({x:g}, {y:g}, {z:g}) m: must be "
            f"{least[first]:g} m from the walls of {walls}"
        )


def _check_overlaps(source: str, rows: Floats) -> None:
    """Raise RequestError for the two grains that overlap most, where that is too much."""
    radius = rows[:, 0]
    i, j, overlap = touching(rows[:, 1:], radius)
    beyond = overlap - LARGEST_OVERLAP * np.minimum(radius[i], radius[j])
    if beyond.size and beyond.max() > 0.0:
        worst = int(beyond.argmax())
        first, second = i[worst], j[worst]
        apart = radius[first] + radius[second] - overlap[worst]
        raise RequestError(
            f"places {source}: grains {first + 1} and {second + 1} are {apart:g} m apart: must be "
            f"{apart + beyond[worst]:g} m, an overlap of {LARGEST_OVERLAP:g} radius"
        )


Ends = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
"""Where a box of a code begins and ends along x, y, z [m]."""


def data_file(places: Floats, radius: float, density: float, box: Box, top: float) -> Path:
    """Write grains of one kind as :func:`write_grains` does.

    In ``box`` with a rim of four radii, up to ``top`` [m].
    """
    rim = 4.0 * radius
    ends = ((-rim, box.length + rim), (-rim, box.width + rim), (-rim, top))
    return write_grains([(places, radius, density)], ends)


def write_grains(kinds: Sequence[tuple[Floats, float, float]], ends: Ends) -> Path:
    """Write grains as a data file of ``atom_style sphere`` and return its path.

    Each kind has places (N, 3) [m], a radius [m], a density [kg/m3], and a type: 1, 2. The file
    lies in the cache, named after its content, so that a job that names it states it. Types of
    particles are three.
    """
    count = sum(len(places) for places, _, _ in kinds)
    head = [f"{count} grains", "", f"{count} atoms", "3 atom types", ""]
    head += [f"{a:.17g} {b:.17g} {n}lo {n}hi" for n, (a, b) in zip("xyz", ends, strict=True)]
    # without the comment "# sphere": LIGGGHTS takes it for a part of the section's name
    grains = [
        f"{kind} {2.0 * radius:.17g} {density:.17g} {x:.17g} {y:.17g} {z:.17g}"
        for kind, (places, radius, density) in enumerate(kinds, 1)
        for x, y, z in places.tolist()
    ]
    rows = [f"{number} {grain}" for number, grain in enumerate(grains, 1)]
    text = "\n".join([*head, "", "Atoms", "", *rows, ""])
    name = f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.data"
    folder = cache_place().path / "beds"
    if len(str(folder).split()) > 1:  # a script's words end at spaces
        folder = Path(tempfile.gettempdir())
    path = folder / name
    if not path.exists():
        make_private(folder)
        with tempfile.NamedTemporaryFile("w", dir=folder, delete=False, encoding="utf-8") as part:
            part.write(text)
        Path(part.name).replace(path)
    return path.absolute()
