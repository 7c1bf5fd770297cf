"""Films of discs: GIF by pillow, MP4 by ffmpeg where it is on the path, PNG for one picture."""

from __future__ import annotations

from pathlib import Path
from subprocess import CalledProcessError
from typing import Any

import numpy as np
from matplotlib.animation import FFMpegWriter, FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.ticker import EngFormatter
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.files import held_folder
from harness.report.content import Discs, Floats
from harness.report.style import BLACK, SKY, Figure, house_style, label

SUFFIXES = (".gif", ".mp4", ".png")
FRAMES, FRAMES_PER_SECOND = 120, 20
MOST_FRAMES = 600  # half a minute: a longer GIF is too large for a page or a mail
EDGE, FIXED = "#333333", "#d5d9de"  # of discs, and within fixed ones
LONGEST_SIDE = 7.2  # inch
MARGIN = 0.03  # of the longer side


def check_film(path: Path, frames: int = FRAMES) -> None:
    """Raise RequestError, before any run, for a film that cannot be written to a path."""
    suffix = path.suffix.lower()
    reason = ""
    if suffix not in SUFFIXES:
        reason = f"must end in {', '.join(SUFFIXES)}"
    elif not path.parent.is_dir():
        reason = f"there is no folder {path.parent}"
    elif path.exists() and not path.is_file():
        reason = "is not a file"
    elif not 2 <= frames <= MOST_FRAMES:
        reason = f"{frames} frames: must be from 2 to {MOST_FRAMES}"
    elif suffix == ".mp4" and not FFMpegWriter.isAvailable():
        reason = ("MP4 needs ffmpeg, which is not on the path; install it, or name a .gif, which "
                  "needs no other program")  # fmt: skip
    if reason:
        raise RequestError(f"--film {path}: {reason}")


def write_film(
    discs: Discs, path: Path, frames: int = FRAMES, fps: int = FRAMES_PER_SECOND
) -> None:
    """Write a film of so many samples at equal times, or a PNG of the middle one.

    No half-written file remains. Raise RequestError as :func:`check_film` does, and where ffmpeg
    fails.
    """
    check_film(path, frames)
    samples = film_samples(discs.time, frames).tolist()
    with house_style(), held_folder(path.parent) as folder:
        part = folder / f"film{path.suffix.lower()}"
        film = DiscFilm(discs)
        try:
            if part.suffix == ".png":
                film.show(samples[len(samples) // 2])
                film.figure.savefig(part, dpi=150)
            else:
                writer = FFMpegWriter(fps) if part.suffix == ".mp4" else PillowWriter(fps)
                FuncAnimation(film.figure, film.show, samples).save(part, writer=writer, dpi=100)
        except CalledProcessError as error:
            text = " ".join(str(error.stderr or "").split())[-200:]
            raise RequestError(
                f"--film {path}: ffmpeg failed with {error.returncode} {text}".rstrip()
            ) from None
        part.replace(path)


def film_samples(time: Floats, frames: int) -> NDArray[np.int64]:
    """Return the samples (at most ``frames``) nearest to equal steps of time."""
    moments = np.linspace(time[0], time[-1], min(frames, time.size))
    middles = (time[1:] + time[:-1]) / 2.0
    return np.unique(np.searchsorted(middles, moments))


class DiscFilm:
    """The figure of a film, whose discs move to those of a sample by :meth:`show`."""

    def __init__(self, discs: Discs) -> None:
        self.discs = discs
        x_range, y_range = _limits(discs)
        size = _size(float(np.ptp(x_range)), float(np.ptp(y_range)))
        self.figure = Figure(figsize=size, layout="compressed")
        self._axes: Axes = self.figure.add_subplot()
        label(self._axes, "x", "y")
        self._axes.grid(visible=False)
        self._axes.set(aspect="equal", xlim=x_range, ylim=y_range)
        for line in (self._axes.xaxis, self._axes.yaxis):
            line.set_major_formatter(EngFormatter("m"))
        for wall in discs.lines:
            self._axes.plot(*wall.T, color=BLACK, lw=1.5)
        self._axes.set_title(discs.title, loc="left")
        self._clock = self._axes.set_title("", loc="right")
        self._place(self._ellipses(len(discs.fixed), FIXED), *discs.fixed.T)
        self._moving = self._ellipses(discs.x.shape[1], SKY)
        self._colours: ScalarMappable | None = None
        if discs.value is not None:
            span = Normalize(float(np.nanmin(discs.value)), float(np.nanmax(discs.value)))
            self._colours = ScalarMappable(span, "viridis")
            self.figure.colorbar(self._colours, ax=self._axes, label=discs.value_label)
        self.show(0)
        self.figure.draw_without_rendering()  # lays out once; each frame would again
        self.figure.set_layout_engine("none")

    def show(self, sample: int) -> None:
        """Move the discs and the clock to a sample."""
        discs = self.discs
        radius = discs.radius[sample] if discs.radius.ndim == 2 else discs.radius
        self._place(self._moving, discs.x[sample], discs.y[sample], radius)
        if self._colours is not None and discs.value is not None:
            self._moving.set_facecolor(self._colours.to_rgba(discs.value[sample]))
        self._clock.set_text(f"t = {EngFormatter('s', places=2)(discs.time[sample])}")

    def _ellipses(self, count: int, colour: str) -> Any:
        zeros = np.zeros(count)
        ellipses = EllipseCollection(
            zeros, zeros, zeros, units="xy", offsets=np.zeros((count, 2)), facecolors=colour,
            offset_transform=self._axes.transData, edgecolors=EDGE, linewidths=0.4,
        )  # fmt: skip
        self._axes.add_collection(ellipses)
        return ellipses

    def _place(self, ellipses: Any, x: Floats, y: Floats, radius: Floats) -> None:
        ellipses.set_offsets(np.column_stack([x, y]))
        ellipses.set_widths(2.0 * radius)
        ellipses.set_heights(2.0 * radius)


def _limits(discs: Discs) -> tuple[Floats, Floats]:
    """Return the ranges of x and y [m] of discs and walls, (2,) each, with a margin."""
    moving = np.stack([discs.x, discs.y], axis=-1)
    radius = np.broadcast_to(discs.radius, discs.x.shape)[..., None]
    fixed, fixed_radius, walls = discs.fixed[:, :2], discs.fixed[:, 2:], discs.lines.reshape(-1, 2)
    edges = [moving - radius, moving + radius, fixed - fixed_radius, fixed + fixed_radius, walls]
    points = np.concatenate([edge.reshape(-1, 2) for edge in edges])
    lowest, highest = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    margin = MARGIN * (highest - lowest).max()
    x_range, y_range = np.stack([lowest - margin, highest + margin], axis=1)
    return x_range, y_range


def _size(width: float, height: float) -> tuple[float, float]:
    """Return the size of a figure [inch], even in pixels as films need it."""
    wide, tall = LONGEST_SIDE * min(1.0, width / height), LONGEST_SIDE * min(1.0, height / width)
    return max(4.0, round(wide + 1.0, 1)), max(2.6, round(tall + 0.9, 1))
