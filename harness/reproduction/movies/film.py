"""What a movie is: frames in a file, a still, and the same motion for OVITO."""

from __future__ import annotations

from dataclasses import dataclass


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
