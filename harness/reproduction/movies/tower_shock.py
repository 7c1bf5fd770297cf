"""The movie of the shock down a tower: its particles, and the force of each contact in time."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle
from matplotlib.ticker import MaxNLocator

from harness.report.figures.style import BLACK, RED, label
from harness.reproduction.movies.frames import RowMotion
from harness.reproduction.movies.stage import Camera, Image, power, stage

WIDTH, HEIGHT = 880, 680
_COLOURS = colormaps["Blues"]
"""From light to dark, so that it reads in grey: no force is nearly white."""
_FELT = 1e-6


class TowerShock:
    """Draws the frames of a tower; depth runs down, the same in both panels."""

    def __init__(self, motion: RowMotion) -> None:
        self._motion = motion
        self._scale = Normalize(0.0, float(motion.force.max()) / 1e3)
        with stage(WIDTH, HEIGHT) as figure:
            tower = figure.add_axes((0.1, 0.2, 0.1, 0.69))
            field = figure.add_axes((0.235, 0.2, 0.64, 0.69), sharey=tower)
            chain = figure.add_axes((0.235, 0.08, 0.64, 0.09), sharex=field)
            self._head(figure)
            self._build_tower(tower)
            moving = [*self._shapes, self._bars, *self._build_field(figure, field)]
            self._camera = Camera(figure, [*moving, *self._build_chain(chain)])

    @property
    def frames(self) -> int:
        """Return the number of frames."""
        return self._motion.time.size

    @property
    def poster_frame(self) -> int:
        """Return the frame in which the shock is at the base."""
        last = self._motion.run.tower.height - 1
        return int(np.argmax(self._motion.force.argmax(axis=1) == last))

    def picture(self, frame: int) -> Image:
        """Return one frame (height, width, 3)."""
        motion = self._motion
        centres, widths = motion.drawn_centres[frame], motion.drawn_widths[frame]
        force = motion.force[frame] / 1e3
        strongest = np.maximum(np.pad(force, (1, 0)), np.pad(force, (0, 1)))
        for i, shape in enumerate(self._shapes):
            shape.set_center((0.0, centres[i]))
            shape.set_height(widths[i])
            shape.set_facecolor(_COLOURS(self._scale(strongest[i])))
        pressing = np.flatnonzero(motion.compression[frame] > _FELT * motion.compression.max())
        faces = (centres + widths / 2)[pressing]
        self._bars.set_segments([[(-0.5, y), (0.5, y)] for y in faces])
        now = float(motion.time_over_t0[frame])
        self._future.set_x(now)
        for cursor in self._cursors:
            cursor.set_xdata([now, now])
        return self._camera.picture()

    def _head(self, figure: Figure) -> None:
        motion, case = self._motion, self._motion.run.tower
        figure.text(0.02, 0.965, motion.title, fontsize=13, fontweight="bold", va="center")
        figure.text(
            0.02, 0.925,
            f"deformable law, exact propagator, k = {power(case.each('stiffness')[0])} N/m, "
            f"{case.speed:g} m/s, fixed base; displacements "
            f"{motion.exaggeration:g} times; orange: contacts that press",
            fontsize=9, va="center", color="#333333",
        )  # fmt: skip

    def _build_tower(self, axes: Axes) -> None:
        particles = self._motion.run.tower.particles
        top = float((self._motion.drawn_centres - self._motion.drawn_widths / 2).min()) - 0.1
        bottom = particles - 0.3
        box = axes.get_window_extent()
        half = (bottom - top) * box.width / box.height / 2
        axes.set(xlim=(-half, half), ylim=(bottom, top), xticks=[])
        axes.set_ylabel("particle")
        axes.set_yticks([0, 4, 9, 14, particles - 1], ["grain", "5", "10", "15", f"{particles}"])
        axes.grid(visible=False)
        axes.spines[["left", "bottom"]].set_visible(False)
        axes.tick_params(left=False)
        axes.axhspan(particles - 0.5, bottom, color="#777777")
        self._shapes = [Ellipse((0, 0), 1.0, 1.0, ec="#444444", lw=0.9) for _ in range(particles)]
        for shape in self._shapes:
            axes.add_patch(shape)
        self._bars = LineCollection([], colors=[RED], linewidths=[2.6])
        axes.add_collection(self._bars, autolim=False)

    def _build_field(self, figure: Figure, axes: Axes) -> list[Artist]:
        motion, n = self._motion, self._motion.run.tower.height
        time = motion.time_over_t0
        edges = np.append(time, 2 * time[-1] - time[-2]) - (time[1] - time[0]) / 2
        drawn = axes.pcolormesh(
            edges, np.arange(n + 1.0), motion.force.T / 1e3,
            cmap=_COLOURS, norm=self._scale, rasterized=True,
        )  # fmt: skip
        axes.set(xlim=(time[0], time[-1]))
        axes.grid(visible=False)
        axes.tick_params(labelbottom=False, left=False, labelleft=False)
        axes.spines["left"].set_visible(False)
        bar = figure.colorbar(drawn, cax=figure.add_axes((0.895, 0.2, 0.018, 0.69)))
        bar.set_label("contact force (kN)")
        bar.ax.grid(visible=False)
        self._future = Rectangle((0, 0), 2 * time[-1], n, color="white", lw=0)
        axes.add_patch(self._future)
        self._cursors = [axes.axvline(0, color=BLACK, lw=1)]
        return [self._future, *self._cursors]

    def _build_chain(self, axes: Axes) -> list[Artist]:
        run = self._motion.run
        contacts = run.contacts_above(_FELT * float(run.grain_force.max()))
        axes.step(run.time_over_t0, contacts, where="post", color=RED, lw=1.3)
        label(axes, "time (t0)", "contacts of\nthe grain")
        axes.yaxis.label.set_fontsize(9)
        axes.set_ylim(-0.3, contacts.max() + 0.5)
        axes.yaxis.set_major_locator(MaxNLocator(3, integer=True))
        self._cursors.append(axes.axvline(0, color=BLACK, lw=1))
        return [self._cursors[-1]]
