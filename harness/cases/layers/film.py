"""A film of a small flow of layers, from all its particles: seen from the side, until it stops."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from harness.cases.layers.parameters import Layers
from harness.cases.layers.template import job_of
from harness.engines.contract import Job
from harness.engines.output import SERIES, Output
from harness.report.figures.style import house_style
from harness.report.sections import Film

Floats = NDArray[np.float64]

FILMED = Layers(layers=4, length=16, width=5, first_angle=16.0, rate=2.0, flow_time=10.0)
"""Lowered quickly: a film is no measurement."""

FRAME = 0.3
"""[sqrt(d/g)] between two frames."""

PREPARED = 20.0
"""[sqrt(d/g)] before which the grains come to rest on the base."""

MOST_FRAMES = 100
SIZE, DPI = (8.2, 5.6), 90

FASTEST, COLOURS = 1.6, 8
"""[sqrt(g d)] of the scale, and its colours, each for 0.2: a GIF has few."""


def film_job() -> Job:
    """Return the job whose particles are filmed."""
    return job_of(FILMED, round(FRAME / FILMED.step))


class Flow:
    """Places and speeds of all particles, frame by frame, and how a frame looks.

    ``time`` (M,) in sqrt(d/g) from the end of the preparation; x, y, z, vx (M, N) in d and
    sqrt(g d); ``width`` (N,) in d.
    """

    def __init__(self, output: Output) -> None:
        table = output.table(("step", "x_m", "z_m"), name=SERIES)
        time = np.asarray(table["step"]) * FILMED.step - PREPARED
        kept = np.flatnonzero(time >= 0.0)[:MOST_FRAMES]
        self.time: Floats = time[kept]
        names = ("x_m", "y_m", "z_m", "vx_m_per_s")
        self.x, self.y, self.z, self.vx = (np.asarray(table[name])[kept] for name in names)
        self.width: Floats = 2.0 * np.asarray(table["radius_m"])[0]
        self.fixed = np.ptp(np.asarray(table["x_m"]), axis=0) == 0.0

    @property
    def speed(self) -> Floats:
        """Return the mean speed of the grains in each frame, (M,)."""
        return np.asarray(self.vx[:, ~self.fixed].mean(axis=1))

    @cached_property
    def _drawing(self) -> tuple[Any, Any, tuple[Any, Any]]:
        """Return what is drawn once, and what changes with the frame."""
        with house_style():
            figure = Figure(figsize=SIZE, dpi=DPI)
            canvas: Any = FigureCanvasAgg(figure)  # Any: matplotlib does not type it
            axes, below = figure.subplots(2, 1, height_ratios=(4.2, 1.0))
            axes.grid(False)
            axes.set(xlim=(0.0, FILMED.length), ylim=(-1.0, FILMED.layers + 1.4), aspect="equal")
            axes.set(xlabel="along the base (d)", ylabel="height (d)")
            discs = EllipseCollection(
                self.width, self.width, np.zeros_like(self.width), units="xy",
                offsets=np.zeros((self.width.size, 2)), transOffset=axes.transData,
                edgecolors="#333333", linewidths=0.4, antialiaseds=False,
                cmap=mpl.colormaps["viridis"].resampled(COLOURS),
            )  # fmt: skip
            discs.set_clim(0.0, FASTEST)
            axes.add_collection(discs)
            scale = figure.colorbar(discs, ax=axes, orientation="horizontal", aspect=60)
            scale.set_label("speed of a grain along the base (sqrt(g d))")
            below.plot(self.time, self.speed, color="0.6", lw=1.0)
            (cursor,) = below.plot([], [], "o", color="#D55E00")
            below.set(xlabel="time (sqrt(d/g))", ylabel="mean speed\n(sqrt(g d))")
            below.set(xlim=(0.0, float(self.time[-1])), ylim=(0.0, None))
            title = axes.set_title("time")
            figure.set_layout_engine("constrained")
            canvas.draw()
            figure.set_layout_engine("none")
        return canvas, discs, (cursor, title)

    def picture(self, frame: int) -> NDArray[np.uint8]:
        """Return a frame (height, width, 3): the grains behind first, the base in grey."""
        canvas, discs, (cursor, title) = self._drawing
        order = np.argsort(-self.y[frame])
        discs.set_offsets(np.column_stack([self.x[frame], self.z[frame]])[order])
        discs.set_widths(self.width[order])
        discs.set_heights(self.width[order])
        colours = discs.cmap(discs.norm(self.vx[frame][order]))
        colours[self.fixed[order]] = (0.7, 0.7, 0.7, 1.0)
        discs.set_array(None)
        discs.set_facecolor(colours)
        cursor.set_data([self.time[frame]], [self.speed[frame]])
        title.set_text(f"{FILMED.layers} layers, {self.time[frame]:.1f} sqrt(d/g)")
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def film_of(output: Output, who: str) -> Film:
    """Return the film of a run of :func:`film_job`; its still is a frame of the full flow."""
    flow = Flow(output)
    angle, rate = FILMED.first_angle, FILMED.rate
    fastest = int(np.argmax(flow.speed))
    return Film(
        "layers-flow",
        "A flow of layers until it stops",
        f"{FILMED.layers} layers in a box of {FILMED.length} d by {FILMED.width} d, seen from the "
        f"side, by {who}: at {angle:g} deg for {FILMED.flow_time:g} sqrt(d/g), then lowered by "
        f"{rate:g} deg for each diameter that the grains move. Grey: the base.",
        flow.time.size,
        fastest,
        flow.picture,
    )
