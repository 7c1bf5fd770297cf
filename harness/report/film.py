"""Films of discs: GIF by pillow, MP4 by ffmpeg where it is on the path, PNG for one picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.files import held_folder
from harness.report.content import Discs

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from harness.report.style import Figure

SUFFIXES = (".gif", ".mp4", ".png")
FRAMES = 120
FRAMES_PER_SECOND = 20
MOST_FRAMES = 600  # half a minute: a longer GIF is too large for a page or a mail
EDGE = "#333333"  # of a disc
FIXED = "#d5d9de"  # of a disc that does not move
LENGTHS = ((1.0, "m", 1.0), (1e-3, "mm", 1e3), (0.0, "µm", 1e6))  # from this extent [m] on, factor
TIMES = ((1.0, "s", 1.0), (1e-3, "ms", 1e3), (0.0, "µs", 1e6))
Scale = tuple[str, float]


def check_film(path: Path, frames: int = FRAMES, option: str = "--film") -> None:
    """Raise RequestError, before any run, for a film that cannot be written to a path."""
    from matplotlib.animation import FFMpegWriter

    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise RequestError(f"{option} {path}: must end in {', '.join(SUFFIXES)}")
    if not path.parent.is_dir():
        raise RequestError(f"{option} {path}: there is no folder {path.parent}")
    if path.exists() and not path.is_file():
        raise RequestError(f"{option} {path}: is not a file")
    if not 2 <= frames <= MOST_FRAMES:
        raise RequestError(f"{option} {path}: {frames} frames: must be from 2 to {MOST_FRAMES}")
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise RequestError(
            f"{option} {path}: MP4 needs ffmpeg, which is not on the path; install it, or name a "
            ".gif, which needs no other program"
        )


def write_film(
    discs: Discs, path: Path, frames: int = FRAMES, fps: int = FRAMES_PER_SECOND
) -> None:
    """Write a film of so many samples, at equal times, or one picture of half of its time.

    Nothing is left half-written. Raise RequestError as :func:`check_film` does, and where ffmpeg
    fails.
    """
    path = Path(path)
    check_film(path, frames)
    with held_folder(path.parent) as folder:
        part = folder / f"film{path.suffix.lower()}"
        _write(discs, part, frames, fps, path)
        part.replace(path)


def film_samples(time: NDArray[np.float64], frames: int) -> NDArray[np.int64]:
    """Return the samples (at most ``frames``) nearest to equal steps of time."""
    moments = np.linspace(time[0], time[-1], min(frames, time.size))
    after = np.clip(np.searchsorted(time, moments), 1, max(1, time.size - 1))
    before_is_nearer = moments - time[after - 1] <= time[np.minimum(after, time.size - 1)] - moments
    return np.unique(np.where(before_is_nearer, after - 1, after))


def _write(discs: Discs, part: Path, frames: int, fps: int, path: Path) -> None:
    from subprocess import CalledProcessError

    from matplotlib.animation import FFMpegWriter, FuncAnimation, PillowWriter

    from harness.report.style import house_style

    with house_style():
        film = DiscFilm(discs)
        samples = film_samples(discs.time, frames)
        if part.suffix == ".png":
            film.show(int(samples[samples.size // 2]))
            film.figure.savefig(part, dpi=150)
            return
        writer = FFMpegWriter(fps) if part.suffix == ".mp4" else PillowWriter(fps)
        animation = FuncAnimation(film.figure, film.show, [int(n) for n in samples])
        try:
            animation.save(part, writer=writer, dpi=100)
        except CalledProcessError as error:
            text = " ".join(str(error.stderr or "").split())[-200:]
            raise RequestError(
                f"--film {path}: ffmpeg failed with {error.returncode} {text}".rstrip()
            ) from None


class DiscFilm:
    """The figure of a film, whose discs move to those of a sample by :meth:`show`."""

    def __init__(self, discs: Discs) -> None:
        from matplotlib.cm import ScalarMappable
        from matplotlib.collections import EllipseCollection
        from matplotlib.colors import Normalize

        from harness.report.style import BLACK, SKY, Figure, label

        self.discs = discs
        (left, right), (bottom, top) = limits(discs)
        unit, self._factor = _scale(max(right - left, top - bottom), LENGTHS)
        self._time_scale = _scale(float(np.ptp(discs.time)), TIMES)
        self.figure: Figure = Figure(figsize=_size(right - left, top - bottom), layout="compressed")
        axes: Axes = self.figure.add_subplot()
        label(axes, f"x ({unit})", f"y ({unit})")
        axes.grid(visible=False)
        factor = self._factor
        axes.set(
            aspect="equal",
            xlim=(factor * left, factor * right),
            ylim=(factor * bottom, factor * top),
        )
        for start, end in discs.lines:
            axes.plot(
                factor * np.array([start[0], end[0]]),
                factor * np.array([start[1], end[1]]),
                color=BLACK,
                lw=1.5,
            )
        axes.set_title(discs.title, loc="left")
        self._clock = axes.set_title("", loc="right")

        def ellipses(count: int, colour: str) -> Any:
            zero = np.zeros(count)
            collection = EllipseCollection(
                zero, zero, zero, units="xy", offsets=np.zeros((count, 2)),
                offset_transform=axes.transData, facecolors=colour, edgecolors=EDGE,
                linewidths=0.4,
            )  # fmt: skip
            axes.add_collection(collection)
            return collection

        fixed = np.asarray(discs.fixed, float).reshape(-1, 3)
        _place(ellipses(len(fixed), FIXED), *(factor * fixed.T))
        self._moving = ellipses(discs.x.shape[1], SKY)
        self._colours: Any = None
        if discs.value is not None:
            span = Normalize(float(np.nanmin(discs.value)), float(np.nanmax(discs.value)))
            self._colours = ScalarMappable(span, "viridis")
            self.figure.colorbar(self._colours, ax=axes, label=discs.value_label)
        self.show(0)
        self.figure.draw_without_rendering()  # lays out once; each frame would again
        self.figure.set_layout_engine("none")

    def show(self, sample: int) -> None:
        """Move the discs and the clock to a sample."""
        discs, factor = self.discs, self._factor
        radius = discs.radius[sample] if np.ndim(discs.radius) == 2 else discs.radius
        place = (discs.x[sample], discs.y[sample], radius)
        _place(self._moving, *(factor * np.asarray(part, float) for part in place))
        if self._colours is not None and discs.value is not None:
            self._moving.set_facecolor(self._colours.to_rgba(discs.value[sample]))
        unit, scale = self._time_scale
        self._clock.set_text(f"t = {scale * discs.time[sample]:.3g} {unit}")


def limits(discs: Discs) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the range of x and of y that discs and walls take over the film [m], with a margin."""
    fixed = np.asarray(discs.fixed, float).reshape(-1, 3)
    walls = np.asarray(discs.lines, float).reshape(-1, 2)
    ranges = []
    for moving, still, wall in (
        (discs.x, fixed[:, 0], walls[:, 0]),
        (discs.y, fixed[:, 1], walls[:, 1]),
    ):
        low = [np.nanmin(moving - discs.radius), *(still - fixed[:, 2]), *wall]
        high = [np.nanmax(moving + discs.radius), *(still + fixed[:, 2]), *wall]
        ranges.append((float(min(low)), float(max(high))))
    margin = 0.03 * max(high - low for low, high in ranges)
    (left, right), (bottom, top) = ranges
    return (left - margin, right + margin), (bottom - margin, top + margin)


def _place(collection: Any, x: Any, y: Any, radius: Any) -> None:
    collection.set_offsets(np.column_stack([x, y]))
    collection.set_widths(2.0 * radius)
    collection.set_heights(2.0 * radius)


def _scale(extent: float, scales: tuple[tuple[float, str, float], ...]) -> Scale:
    return next((unit, factor) for least, unit, factor in scales if extent >= least)


def _size(width: float, height: float) -> tuple[float, float]:
    """Return the size of a figure [inch], even in pixels as films need it."""
    longest = 7.2
    wide = longest * min(1.0, width / height)
    tall = longest * min(1.0, height / width)
    return max(4.0, round(wide + 1.0, 1)), max(2.6, round(tall + 0.9, 1))
