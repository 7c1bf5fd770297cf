"""A figure of which only some parts are drawn again for each frame."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from harness.report.figures.style import house_style

Image = NDArray[np.uint8]
DPI = 100


@contextmanager
def stage(width: int, height: int) -> Iterator[Figure]:
    """Give a figure of so many pixels in the house style, axes to be placed by hand."""
    with house_style():
        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
        figure.set_layout_engine("none")
        yield figure


class Camera:
    """Takes pictures of a figure; ``moving`` are the artists that change between them.

    All else is drawn once. Moving artists are drawn in the given order, above the rest.
    """

    def __init__(self, figure: Figure, moving: list[Artist]) -> None:
        self._figure, self._moving = figure, moving
        for artist in moving:
            artist.set_animated(True)
        canvas: Any = FigureCanvasAgg(figure)  # Any: matplotlib does not type it
        self._canvas = canvas
        self._canvas.draw()
        self._rest = self._canvas.copy_from_bbox(figure.bbox)

    def picture(self) -> Image:
        """Return the figure as it is now, (height, width, 3)."""
        self._canvas.restore_region(self._rest)
        for artist in self._moving:
            self._figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


def png(image: Image) -> bytes:
    """Return a picture (height, width, 3) as PNG."""
    from PIL import Image as Pillow

    target = io.BytesIO()
    Pillow.fromarray(image).save(target, format="PNG", optimize=True)
    return target.getvalue()


def power(value: float) -> str:
    """Return a number as ``1e6`` or ``2.5e6``."""
    return f"{value:.3g}" if value < 1e4 else f"{value:.1e}".replace("e+0", "e").replace(".0e", "e")
