"""Movies of the motions: looping GIFs, and dumps for OVITO."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.reproduction.movies.motions import InclineMotion, Motions, RowMotion
    from harness.reproduction.movies.scenes import Scene


@dataclass(frozen=True)
class Film:
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


def films(motions: Motions) -> list[Film]:
    """Return a film of each motion that there is."""
    from harness.reproduction.movies.motions import incline_dump, row_dump
    from harness.reproduction.movies.scenes import InclineGrain, RowCollision, TowerShock

    rows = [_film(RowCollision(one), row_dump(one)) for one in (motions.pair, motions.triple)]
    incline = motions.incline
    inclines = [_film(InclineGrain(incline), incline_dump(incline))] if incline else []
    return [*rows, *inclines, _film(TowerShock(motions.tower), row_dump(motions.tower))]


def _film(scene: Scene[Any], dump: bytes) -> Film:
    from harness.report.gallery import FRAME_MS, gif, png

    motion: RowMotion | InclineMotion = scene.motion
    speed = 1e3 * float(motion.time[1] - motion.time[0]) / FRAME_MS
    pace = f"{speed:.2g} times as fast" if speed > 1 else f"{1 / speed:.0f} times slowed down"
    return Film(
        name=motion.name,
        title=motion.title,
        caption=f"{motion.sentence} Shown {pace}.",
        gif=gif(scene.picture, scene.frames),
        still=png(scene.picture(scene.poster_frame)),
        dump=dump,
    )
