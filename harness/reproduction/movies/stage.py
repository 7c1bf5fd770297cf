"""What the scenes share: a figure of which only some parts are drawn again for each frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from harness.report.figures.style import BLACK, house_style
from harness.report.gif import Image
from harness.reproduction.movies.frames import InclineMotion, RowMotion

Floats = NDArray[np.float64]
Motion = TypeVar("Motion", RowMotion, InclineMotion)

DPI, WIDTH = 100, 880
INK = "#333333"


class Scene(ABC, Generic[Motion]):
    """Draws the frames of one motion.

    A scene gives its height and where its two lines of text stand, what moves, and how that
    looks at a frame. All else is drawn once; what moves is drawn in the given order above it.
    """

    height: ClassVar[int]
    head: ClassVar[tuple[float, float]]
    motion: Motion

    def __init__(self, motion: Motion) -> None:
        self.motion = motion
        with house_style():
            figure = Figure(figsize=(WIDTH / DPI, self.height / DPI), dpi=DPI)
            figure.set_layout_engine("none")
            above, below = self.head
            figure.text(0.02, above, motion.title, fontsize=13, fontweight="bold", va="center")
            figure.text(0.02, below, self.subtitle(), fontsize=9, va="center", color=INK)
            self._figure, self._moving = figure, self.build(figure)
            for artist in self._moving:
                artist.set_animated(True)
            canvas: Any = FigureCanvasAgg(figure)  # Any: matplotlib does not type it
            canvas.draw()
        self._canvas, self._rest = canvas, canvas.copy_from_bbox(figure.bbox)

    @property
    def frames(self) -> int:
        """Return the number of frames."""
        return int(self.motion.time.size)

    def picture(self, frame: int) -> Image:
        """Return one frame (height, width, 3)."""
        self.show(frame)
        self._canvas.restore_region(self._rest)
        for artist in self._moving:
            self._figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()

    @abstractmethod
    def subtitle(self) -> str:
        """Return what is drawn, and to which scale."""

    @abstractmethod
    def build(self, figure: Figure) -> list[Artist]:
        """Draw what stays on a figure; return what moves."""

    @abstractmethod
    def show(self, frame: int) -> None:
        """Put what moves where it is at a frame."""

    @property
    @abstractmethod
    def poster_frame(self) -> int:
        """Return the frame to show where nothing moves."""


class Traces:
    """Curves against time, faint as a whole, bold as far as the film is, and a cursor."""

    def __init__(
        self, axes: Axes, curves: Iterable[tuple[Floats, Floats, str, dict[str, Any]]]
    ) -> None:
        self._lines = []
        for time, values, name, look in curves:
            axes.plot(time, values, lw=1, alpha=0.25, **look)
            (line,) = axes.plot([], [], lw=2.2, label=name, **look)
            self._lines.append((line, time, values))
        self._cursor = axes.axvline(0, color=BLACK, lw=1)
        self.moving: list[Artist] = [self._cursor, *(line for line, _, _ in self._lines)]

    def show(self, now: float) -> None:
        """Draw all up to a time."""
        self._cursor.set_xdata([now, now])
        for line, time, values in self._lines:
            seen = int(np.searchsorted(time, now, side="right"))
            line.set_data(time[:seen], values[:seen])
