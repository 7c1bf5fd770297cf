"""Films of bulk runs: a cut through the middle, to scale, frame by frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from harness.engines.contract import Engine, Job
from harness.errors import EngineError
from harness.report.film import WIDTH, Film, Scene
from harness.report.style import BLACK, COLOURS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

PARTICLES = "particles"
"""Value of a job: 1 writes all particles in place of the series, where scripts have it."""

BANDS = 4
"""Colours of grains of one kind, by the height at which they begin."""


@dataclass(frozen=True)
class Cut:
    """What a film shows of a system: a plane y [m], walls in it as lines of x and z [m]."""

    y: float
    walls: Sequence[tuple[Sequence[float], Sequence[float]]]
    low: float
    high: float


@dataclass(frozen=True)
class Motion:
    """Particles over time: ``time`` (M,) [s], ``place`` (M, N, 3) [m], ``radius`` (N,) [m]."""

    time: Floats
    place: Floats
    radius: Floats

    @property
    def kinds(self) -> NDArray[np.int64]:
        """Return the colour of each particle: bands of first heights, then the larger sizes.

        Sizes that vary from grain to grain are one kind.
        """
        sizes = np.unique(self.radius)
        sizes = sizes if len(sizes) < len(COLOURS) else self.radius.max(keepdims=True)
        smallest = self.radius <= sizes[0]
        heights = self.place[0, :, 2]
        edges = np.quantile(heights[smallest], np.linspace(0.0, 1.0, BANDS + 1)[1:-1])
        bands = np.searchsorted(edges, heights)
        larger = BANDS - 1 + np.searchsorted(sizes, self.radius)
        return np.asarray(np.where(smallest, bands, larger))


def bulk_film(
    engine: Engine, job: Job, radius: Floats | None, begins: float, cut: Cut, title: str
) -> Film:
    """Run a job whose series is that of all particles, and return the film of the cut.

    ``begins`` is the step at which time counts; ``radius`` (N,) [m] of jobs that do not write it.
    Raise EngineError for a run that failed.
    """
    (output,) = engine.run([job])
    if isinstance(output, EngineError):
        raise output
    table = output.table(("step", "x_m", "y_m", "z_m"))
    time = (table["step"] - begins) * float(job.values["step_size"])
    kept = time >= 0.0
    place = np.stack([table[f"{axis}_m"][kept] for axis in "xyz"], axis=2)
    sizes = table["radius_m"][0] if radius is None else radius
    return CutScene(Motion(time[kept], place, sizes), cut, f"{title} by {engine.title}").film()


class CutScene(Scene):
    """How a frame looks: the circles in which the plane cuts the particles."""

    height = 620

    def __init__(self, motion: Motion, cut: Cut, title: str) -> None:
        self.motion, self.cut, self.title = motion, cut, title
        self.frames = motion.time.size
        super().__init__()

    @property
    def poster_frame(self) -> int:
        """Return a frame halfway."""
        return self.frames // 2

    def subtitle(self) -> str:
        """Return what is drawn."""
        return "cut through the middle, to scale; colours by first height and by size"

    def clock(self, frame: int) -> str:
        """Return the time."""
        return f"t = {1e3 * self.motion.time[frame]:.0f} ms"

    def build(self, figure: Figure) -> list[Artist]:
        """Draw the walls; the circles move."""
        axes = self.axes(figure, 80, 50, WIDTH - 100, self.height - 130)
        axes.grid(visible=False)
        for x, z in self.cut.walls:
            axes.plot(1e3 * np.asarray(x), 1e3 * np.asarray(z), color=BLACK, lw=1.5)
        axes.set(aspect="equal", xlabel="x (mm)", ylabel="z (mm)")
        axes.set_ylim(1e3 * self.cut.low, 1e3 * self.cut.high)
        zero = np.zeros(len(self.motion.radius))
        colours = [COLOURS[kind % len(COLOURS)] for kind in self.motion.kinds]
        self._circles: Any = EllipseCollection(
            zero, zero, zero, units="xy", offsets=np.zeros((len(zero), 2)),
            transOffset=axes.transData, facecolors=colours, edgecolors="#333333", linewidths=0.4,
            antialiaseds=False,
        )  # fmt: skip
        axes.add_collection(self._circles)
        return [self._circles]

    def show(self, frame: int) -> None:
        """Put the circles where the plane cuts; the rest has none."""
        place = self.motion.place[frame]
        off = place[:, 1] - self.cut.y
        width = 2e3 * np.sqrt(np.maximum(self.motion.radius**2 - off**2, 0.0))
        self._circles.set_offsets(1e3 * place[:, [0, 2]])
        self._circles.set_widths(width)
        self._circles.set_heights(width)


def circle(radius: float) -> tuple[list[float], list[float]]:
    """Return x and z of a circle about the origin [m]."""
    angles = [math.tau * i / 180 for i in range(181)]
    return [radius * math.cos(a) for a in angles], [radius * math.sin(a) for a in angles]
