"""Pictures to a looping GIF: one palette for all, no dither, the same bytes each time."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from harness.report.movies.stage import Image

FRAME_MS = 50
"""Browsers slow down what is faster than 20 ms; GIF counts in 10 ms."""
LAST_MS = 1500
_EXACT = 32
_BLENDS = 64
_SAMPLES = 9


def gif(picture: Callable[[int], Image], frames: int) -> bytes:
    """Return the pictures of frames 0 to ``frames`` - 1 as a GIF that loops for ever.

    Colours are flat areas and lines: dither would only add noise, and bytes.
    """
    palette = _palette([picture(frame) for frame in _chosen(frames)])
    images = [
        Pillow.fromarray(picture(frame)).quantize(palette=palette, dither=Pillow.Dither.NONE)
        for frame in range(frames)
    ]
    target = io.BytesIO()
    images[0].save(
        target,
        format="GIF",
        save_all=True,
        append_images=images[1:],
        duration=[FRAME_MS] * (frames - 1) + [LAST_MS],
        loop=0,
        optimize=True,
        disposal=1,
    )
    return target.getvalue()


def _chosen(frames: int) -> list[int]:
    """Return a few frames, evenly chosen."""
    return [int(frame) for frame in np.unique(np.linspace(0, frames - 1, _SAMPLES).round())]


def _palette(pictures: list[Image]) -> Pillow.Image:
    """Return the palette of some pictures: the commonest colours as they are, then blends.

    Median cut alone would shift the white of the page and the colours of the lines.
    """
    pixels = np.vstack([picture.reshape(-1, 3) for picture in pictures])
    packed = pixels.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], dtype=np.uint32)
    colours, counts = np.unique(packed, return_counts=True)
    order = np.argsort(-counts.astype(np.int64), kind="stable")
    common, rest = colours[order[:_EXACT]], colours[order[_EXACT:]]
    entries = _unpacked(common).ravel().tolist()
    if rest.size:
        blends = Pillow.fromarray(_unpacked(rest)[None]).quantize(_BLENDS)
        entries += blends.getpalette() or []
    palette = Pillow.new("P", (1, 1))
    palette.putpalette(entries)
    return palette


def _unpacked(colours: NDArray[np.uint32]) -> Image:
    """Return packed colours (M,) as bytes (M, 3)."""
    return np.stack([colours >> 16, colours >> 8 & 255, colours & 255], axis=-1).astype(np.uint8)
