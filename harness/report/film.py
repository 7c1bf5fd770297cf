"""Films: scenes of which only some parts are drawn again, written as GIF or MP4.

A :class:`Scene` draws the frames of a motion. A GIF loops; an MP4 is what ``ffmpeg`` makes of the
same frames, where that program is on the path.
"""

from __future__ import annotations

import base64
import contextlib
import io
import shutil
import subprocess
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image as Pillow

from harness.errors import RequestError
from harness.files import held_folder
from harness.report.style import house_style

Image = NDArray[np.uint8]
"""A picture (height, width, 3)."""

FRAME_MS = 50
"""Browsers slow down what is faster than 20 ms; GIF counts in 10 ms."""
LAST_MS = 1500


def gif(picture: Callable[[int], Image], frames: int) -> bytes:
    """Return the pictures of frames 0 to ``frames`` - 1 as a GIF that loops for ever."""
    octree = Pillow.Quantize.FASTOCTREE
    images = [Pillow.fromarray(picture(frame)).quantize(method=octree) for frame in range(frames)]
    target = io.BytesIO()
    images[0].save(
        target,
        format="GIF",
        save_all=True,
        append_images=images[1:],
        duration=[FRAME_MS] * (frames - 1) + [LAST_MS],
        loop=0,
    )
    return target.getvalue()


def png(image: Image) -> bytes:
    """Return a picture (height, width, 3) as PNG."""
    target = io.BytesIO()
    Pillow.fromarray(image).save(target, format="PNG", optimize=True)
    return target.getvalue()


@dataclass(frozen=True)
class Film:
    """A film: its title, the number of frames, and how each looks.

    ``picture`` returns a frame; ``poster`` is the one that is shown where nothing moves. A
    notebook shows the film by itself.
    """

    title: str
    frames: int
    poster: int
    picture: Callable[[int], Image] = field(repr=False)

    def save(self, path: str | Path) -> None:
        """Write it as .gif, .mp4 where ffmpeg is on the path, or its poster as .png.

        Nothing is left half-written. Raise RequestError for another ending, a folder that is not
        there, ffmpeg missing.
        """
        path = Path(path)
        check_film(path, self.frames)
        with held_folder(path.parent) as folder:
            aside = folder / f"film{path.suffix}"
            self.write(aside)
            aside.replace(path)

    def write(self, path: Path) -> None:
        """Write it to a path that :func:`check_film` allows, not aside."""
        suffix = path.suffix.lower()
        if suffix == ".mp4":
            write_mp4(self.picture, self.frames, path)
        elif suffix == ".png":
            path.write_bytes(png(self.picture(self.poster)))
        else:
            path.write_bytes(gif(self.picture, self.frames))

    def _repr_html_(self) -> str:
        content = base64.b64encode(gif(self.picture, self.frames)).decode("ascii")
        return f'<img src="data:image/gif;base64,{content}" alt="{escape(self.title)}">'


SUFFIXES = (".gif", ".mp4", ".png")
MOST_FRAMES = 600
"""Half a minute; a GIF of more would be larger than pages and mails take."""

MP4_BY_FFMPEG = (
    "is written by ffmpeg, which is not on the path; install it, or name a .gif, which needs no "
    "other program"
)


def check_film(path: Path, frames: int, option: str = "film") -> None:
    """Raise RequestError, before any work, for a film that cannot be written to a path."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise RequestError(f"{option} {path}: must end in {', '.join(SUFFIXES)}")
    if not path.parent.is_dir():
        raise RequestError(f"{option} {path}: there is no folder {path.parent}")
    if path.exists() and not path.is_file():
        raise RequestError(f"{option} {path}: is no file")
    check_frames(frames, f"{option} {path}")
    if suffix == ".mp4" and _ffmpeg() is None:
        raise RequestError(f"{option} {path}: {MP4_BY_FFMPEG}")


def check_frames(frames: int, name: str) -> None:
    """Raise RequestError for a film of too few frames or too many."""
    if not 2 <= frames <= MOST_FRAMES:
        raise RequestError(f"{name}: {frames} frames: must be from 2 to {MOST_FRAMES}")


def write_mp4(picture: Callable[[int], Image], frames: int, path: Path) -> None:
    """Write the pictures of frames 0 to ``frames`` - 1 as MP4.

    Raise RequestError where ffmpeg is missing or cannot do it.
    """
    program, (height, width, _) = _ffmpeg(), picture(0).shape
    if program is None:
        raise RequestError(f"film: MP4 {MP4_BY_FFMPEG}")
    even = f"crop={width - width % 2}:{height - height % 2}:0:0"  # its colours are in twos
    command = [
        program, "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{width}x{height}", "-r", str(1000 // FRAME_MS), "-i", "-",
        "-vf", even, "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", str(path),
    ]  # fmt: skip
    order = [*range(frames), *[frames - 1] * (LAST_MS // FRAME_MS)]
    with tempfile.TemporaryFile() as messages:
        with (
            subprocess.Popen(command, stdin=subprocess.PIPE, stderr=messages) as running,
            contextlib.suppress(BrokenPipeError),  # what it says and its status tell why
        ):
            assert running.stdin is not None
            for frame in order:
                running.stdin.write(picture(frame).tobytes())
        if running.returncode:
            messages.seek(0)
            text = " ".join(messages.read().decode(errors="replace").split())[-200:]
            raise RequestError(f"film: {program} failed with {running.returncode}: {text}")


def _ffmpeg() -> str | None:
    return shutil.which(str(mpl.rcParams["animation.ffmpeg_path"]))


DPI, WIDTH = 100, 880
INK = "#333333"


class Scene(ABC):
    """Draws the frames of a motion.

    A scene gives its height, its title and what it says below, what moves, and how that looks at
    a frame. All else is drawn once; what moves is drawn in the given order above it. The time of
    the frame stands at the right of the title.
    """

    height: int
    frames: int
    title: str

    def __init__(self) -> None:
        with house_style():
            figure = Figure(figsize=(WIDTH / DPI, self.height / DPI), dpi=DPI)
            figure.set_layout_engine("none")
            lines = self.subtitle().split("\n")
            place: dict[str, Any] = {"va": "center", "transform": None}
            figure.text(0.02 * WIDTH, self.height - 23, self.title, fontsize=13,
                        fontweight="bold", **place)  # fmt: skip
            for line, text in enumerate(lines):
                figure.text(0.02 * WIDTH, self.height - 49 - 19 * line, text, fontsize=10.5,
                            color=INK, **place)  # fmt: skip
            clock = figure.text(
                0.98 * WIDTH, self.height - 23, "", ha="right", fontsize=13, **place
            )
            self._clock, self._figure = clock, figure
            self._moving = [*self.build(figure), clock]
            for artist in self._moving:
                artist.set_animated(True)
            canvas: Any = FigureCanvasAgg(figure)  # Any: matplotlib does not type it
            canvas.draw()
        self._canvas, self._rest = canvas, canvas.copy_from_bbox(figure.bbox)

    def axes(self, figure: Figure, left: float, bottom: float, width: float, tall: float) -> Axes:
        """Return new axes; all lengths in pixels."""
        return figure.add_axes(
            (left / WIDTH, bottom / self.height, width / WIDTH, tall / self.height)
        )

    def picture(self, frame: int) -> Image:
        """Return one frame (height, width, 3)."""
        self.show(frame)
        self._clock.set_text(self.clock(frame))
        self._canvas.restore_region(self._rest)
        for artist in self._moving:
            self._figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()

    def film(self) -> Film:
        """Return the film of all frames."""
        return Film(self.title, self.frames, self.poster_frame, self.picture)

    @abstractmethod
    def subtitle(self) -> str:
        """Return what is drawn, by whom and to which scale, on one line or two."""

    @abstractmethod
    def clock(self, frame: int) -> str:
        """Return the time of a frame in words."""

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
