"""Movies of the motions: looping GIFs, and dumps for OVITO."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from harness.cases.incline.film import InclineMotion
    from harness.cases.tower.film import RowMotion
    from harness.report.film import Scene
    from harness.reproduction.movies.motions import Motions


@dataclass(frozen=True)
class Movie:
    """A movie with its title and caption.

    ``gif`` is the looping movie, ``still`` a PNG of its most telling frame;
    ``dump`` is a gzipped LAMMPS text dump, to be named ``<name>.dump.gz``.
    """

    name: str
    title: str
    caption: str
    gif: bytes
    still: bytes
    dump: bytes


def films(motions: Motions) -> list[Movie]:
    """Return a movie of each motion that there is."""
    from harness.cases.incline.film import InclineGrain
    from harness.cases.tower.film import TowerShock
    from harness.reproduction.movies.motions import incline_dump, row_dump
    from harness.reproduction.movies.scenes import RowCollision

    made = [_movie(RowCollision(one), one, row_dump(one)) for one in (motions.pair, motions.triple)]
    if motions.incline:
        scene = InclineGrain(motions.incline)
        made.append(_movie(scene, motions.incline, incline_dump(motions.incline)))
    return [*made, _movie(TowerShock(motions.tower), motions.tower, row_dump(motions.tower))]


def _movie(scene: Scene, motion: RowMotion | InclineMotion, dump: bytes) -> Movie:
    from harness.report.film import FRAME_MS, gif, png

    speed = 1e3 * float(motion.time[1] - motion.time[0]) / FRAME_MS
    pace = f"{speed:.2g} times as fast" if speed > 1 else f"{1 / speed:.0f} times slowed down"
    return Movie(
        name=motion.name,
        title=motion.title,
        caption=f"{motion.sentence} Shown {pace}.",
        gif=gif(scene.picture, scene.frames),
        still=png(scene.picture(scene.poster_frame)),
        dump=dump,
    )
