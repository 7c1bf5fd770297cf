"""Encode pictures as a looping GIF: one palette for all, no dither, the same bytes each time."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

Image = NDArray[np.uint8]
"""A picture (height, width, 3)."""

FRAME_MS = 50
"""Browsers slow down what is faster than 20 ms; GIF counts in 10 ms."""
LAST_MS = 1500
_EXACT = 32
_BLENDS = 64
_UNKNOWN = 255  # more entries than a palette of these has
_SAMPLES = 5


def gif(picture: Callable[[int], Image], frames: int) -> bytes:
    """Return the pictures of frames 0 to ``frames`` - 1 as a GIF that loops for ever.

    Colours are flat areas and lines: dither would only add noise, and bytes.
    """
    chosen = np.unique(np.linspace(0, frames - 1, _SAMPLES).round()).astype(int)
    palette = _palette([picture(int(frame)) for frame in chosen])
    nearest = np.full(1 << 24, _UNKNOWN, dtype=np.uint8)
    images = [_painted(picture(frame), palette, nearest) for frame in range(frames)]
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


def base64_uri(content: bytes, kind: str) -> str:
    """Return bytes of a kind such as ``image/gif`` as an address that holds them."""
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def png(image: Image) -> bytes:
    """Return a picture (height, width, 3) as PNG."""
    target = io.BytesIO()
    Pillow.fromarray(image).save(target, format="PNG", optimize=True)
    return target.getvalue()


def _palette(pictures: list[Image]) -> Image:
    """Return the palette (M, 3) of some pictures: the commonest colours as they are, then blends.

    Median cut alone would shift the white of the page and the colours of the lines.
    """
    packed = np.concatenate([_packed(picture).ravel() for picture in pictures])
    colours, counts = np.unique(packed, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    common, rest = colours[order[:_EXACT]], colours[order[_EXACT:]]
    entries = _unpacked(common)
    if rest.size:
        blends = Pillow.fromarray(_unpacked(rest)[None]).quantize(_BLENDS)
        entries = np.vstack([entries, np.array(blends.getpalette()).reshape(-1, 3)])
    return entries.astype(np.uint8)


def _painted(picture: Image, palette: Image, nearest: NDArray[np.uint8]) -> Pillow.Image:
    """Return a picture (height, width, 3) on a palette, the nearest colour for each pixel.

    Pillow's own is only roughly the nearest, and turns white grey. Colours come again from frame
    to frame: each is looked for once, and kept in ``nearest``, an entry for each packed colour.
    """
    packed = _packed(picture)
    unknown = np.unique(packed[nearest[packed] == _UNKNOWN])
    if unknown.size:
        entries = palette.astype(float)  # |colour|^2 is the same for all entries, and left out
        apart = (entries**2).sum(axis=1) - 2.0 * _unpacked(unknown).astype(float) @ entries.T
        nearest[unknown] = apart.argmin(axis=1)
    image = Pillow.fromarray(nearest[packed])
    image.putpalette(palette.tobytes())
    return image


def _packed(picture: Image) -> NDArray[np.uint32]:
    """Return each pixel's colour as one number, (height, width)."""
    red, green, blue = np.moveaxis(picture.astype(np.uint32), -1, 0)
    return np.asarray(red << 16 | green << 8 | blue)


def _unpacked(colours: NDArray[np.uint32]) -> Image:
    """Return packed colours (M,) as bytes (M, 3)."""
    return np.stack([colours >> 16, colours >> 8 & 255, colours & 255], axis=-1).astype(np.uint8)
