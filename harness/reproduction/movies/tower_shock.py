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

from harness.observables.significant_contacts import SIGNIFICANT_FORCE, significant_contacts
from harness.report.figures.style import BLACK, RED, label, power
from harness.reproduction.movies.frames import RowMotion
from harness.reproduction.movies.stage import Scene

_COLOURS = colormaps["Blues"]
"""From light to dark, so that it reads in grey: no force is nearly white."""


class TowerShock(Scene[RowMotion]):
    """Draws the frames of a tower; depth runs down, the same in both panels."""

    height, head = 680, (0.965, 0.925)

    def subtitle(self) -> str:
        """Return law, solver and scale."""
        case = self.motion.run.tower
        return (
            f"deformable law, exact propagator, k = {power(case.each('stiffness')[0])} N/m, "
            f"{case.speed:g} m/s, fixed base; displacements "
            f"{self.motion.exaggeration:g} times; orange: contacts that press"
        )

    @property
    def poster_frame(self) -> int:
        """Return the frame in which the shock is at the base."""
        last = self.motion.run.tower.height - 1
        return int(np.argmax(self.motion.force.argmax(axis=1) == last))

    def build(self, figure: Figure) -> list[Artist]:
        """Draw the tower, the forces of its contacts in time, and the chain of its grain."""
        tower = figure.add_axes((0.1, 0.2, 0.1, 0.69))
        field = figure.add_axes((0.235, 0.2, 0.64, 0.69), sharey=tower)
        chain = figure.add_axes((0.235, 0.08, 0.64, 0.09), sharex=field)
        self._scale = Normalize(0.0, float(self.motion.force.max()) / 1e3)
        self._tower(tower)
        self._field(figure, field)
        contacts = significant_contacts(self.motion.run)
        chain.step(self.motion.run.time_over_t0, contacts, where="post", color=RED, lw=1.3)
        label(chain, "time (t0)", "contacts of\nthe grain")
        chain.yaxis.label.set_fontsize(9)
        chain.set_ylim(-0.3, contacts.max() + 0.5)
        chain.yaxis.set_major_locator(MaxNLocator(3, integer=True))
        self._cursors = [axes.axvline(0, color=BLACK, lw=1) for axes in (field, chain)]
        return [*self._shapes, self._bars, self._future, *self._cursors]

    def _tower(self, axes: Axes) -> None:
        particles = self.motion.run.tower.particles
        top = float((self.motion.drawn_centres - self.motion.drawn_widths / 2).min()) - 0.1
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

    def _field(self, figure: Figure, axes: Axes) -> None:
        time, n = self.motion.time_over_t0, self.motion.run.tower.height
        edges = np.append(time, 2 * time[-1] - time[-2]) - (time[1] - time[0]) / 2
        drawn = axes.pcolormesh(
            edges, np.arange(n + 1.0), self.motion.force.T / 1e3,
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

    def show(self, frame: int) -> None:
        """Put particles and contacts where they are at a frame, and hide what comes later."""
        motion = self.motion
        centres, widths = motion.drawn_centres[frame], motion.drawn_widths[frame]
        force = np.pad(motion.force[frame] / 1e3, 1)
        colours = _COLOURS(self._scale(np.maximum(force[:-1], force[1:])))
        for shape, y, width, colour in zip(self._shapes, centres, widths, colours, strict=True):
            shape.set_center((0.0, y))
            shape.set_height(width)
            shape.set_facecolor(colour)
        pressing = motion.compression[frame] > SIGNIFICANT_FORCE * motion.compression.max()
        faces = (centres + widths / 2)[:-1][pressing]
        self._bars.set_segments([[(-0.5, y), (0.5, y)] for y in faces])
        now = float(motion.time_over_t0[frame])
        self._future.set_x(now)
        for cursor in self._cursors:
            cursor.set_xdata([now, now])
