"""Beds whose places come from a file: read, checked, written as LAMMPS and LIGGGHTS read them.

A row is radius, x, y, z [m], as in the public drivers of MercuryDPM; what is no row of four
numbers at the top is a head.
"""

from __future__ import annotations

import hashlib
import lzma
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from harness.errors import RequestError
from harness.files import cache_place, make_private

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

PUBLISHED = "published"
"""Stands for the bed of Dosta and others (2024), which lies beside this module.

From MercuryDPM's drivers ``Drivers/Papers/OSBenchmark``, without the last line, which is the steel
sphere: BSD-3-Clause, MercuryDPM developers team.
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


PUBLISHED_BOX = Box(0.098, 0.06, (0.0, 0.0), -0.0902431)
"""By the triangles of its walls."""


@lru_cache(maxsize=4)
def read_places(source: str, radius: float, box: Box) -> Floats:
    """Return places (N, 3) [m] in a box whose corner is the origin.

    ``source`` is :data:`PUBLISHED` or the path of a text file, perhaps packed as ``.xz``. Raise
    RequestError, naming file and row, for one that cannot be read, a row that is cut short, another
    radius, a grain beyond a wall, and overlaps of more than :data:`LARGEST_OVERLAP`.
    """
    rows = _rows(source)
    wrong = np.flatnonzero(~np.isclose(rows[:, 0], radius, rtol=1e-9, atol=0.0))
    if len(wrong):
        raise RequestError(
            f"places {source}: grain {wrong[0] + 1} has the radius {rows[wrong[0], 0]:g} m: must "
            f"be radius = {radius:g} m"
        )
    corner = (box.middle[0] - box.length / 2, box.middle[1] - box.width / 2, box.floor)
    places: Floats = rows[:, 1:] - np.array(corner)
    _check_walls(source, places, radius, box)
    _check_overlaps(source, places, radius)
    places.flags.writeable = False
    return places


def _rows(source: str) -> Floats:
    """Return radius, x, y, z of each grain, (N, 4)."""
    path = Path(source).expanduser()
    if source == PUBLISHED:
        path = Path(__file__).with_name("penetration-25k.txt.xz")
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
        elif line.strip() and rows:
            raise RequestError(
                f"places {source}, line {number}: {line.strip()[:40]!r}: must be four numbers, "
                "radius x y z"
            )
    if not rows:
        raise RequestError(f"places {source}: no line of four numbers, radius x y z")
    return np.array(rows)


def _check_walls(source: str, places: Floats, radius: float, box: Box) -> None:
    """Raise RequestError for a grain that overlaps a wall by more than is allowed."""
    most = (1.0 - LARGEST_OVERLAP) * radius
    reach = np.array([box.length, box.width, np.inf])
    beyond = np.flatnonzero(((places < most) | (places > reach - most)).any(axis=1))
    if len(beyond):
        x, y, z = places[beyond[0]]
        raise RequestError(
            f"places {source}: grain {beyond[0] + 1} at ({x:g}, {y:g}, {z:g}) m: must be "
            f"{most:g} m from the walls of the box, {box.length:g} by {box.width:g} m"
        )


def _check_overlaps(source: str, places: Floats, radius: float) -> None:
    """Raise RequestError for the two grains that overlap most, where that is too much."""
    from scipy.spatial import cKDTree

    near = (2.0 - LARGEST_OVERLAP) * radius
    pairs = cKDTree(places).query_pairs(near, output_type="ndarray")
    if len(pairs):
        apart = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
        worst = int(np.argmin(apart))
        first, second = pairs[worst] + 1
        raise RequestError(
            f"places {source}: grains {first} and {second} are {apart[worst]:g} m apart: must be "
            f"{near:g} m, an overlap of {LARGEST_OVERLAP:g} radius"
        )


def data_file(places: Floats, radius: float, density: float, box: Box, top: float) -> Path:
    """Write grains as a data file of ``atom_style sphere`` and return its path.

    The file lies in the cache, named after its content, so that a job that names it states it.
    Its box is ``box`` with a rim of four radii, up to ``top`` [m]; types of particles are three.
    """
    rim = 4.0 * radius
    ends = ((-rim, box.length + rim), (-rim, box.width + rim), (-rim, top))
    head = [f"{len(places)} grains", "", f"{len(places)} atoms", "3 atom types", ""]
    head += [f"{a:.17g} {b:.17g} {n}lo {n}hi" for n, (a, b) in zip("xyz", ends, strict=True)]
    # without the comment "# sphere": LIGGGHTS takes it for a part of the section's name
    rows = [
        f"{number} 1 {2.0 * radius:.17g} {density:.17g} {x:.17g} {y:.17g} {z:.17g}"
        for number, (x, y, z) in enumerate(places.tolist(), 1)
    ]
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
