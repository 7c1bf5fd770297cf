"""The movie of a free row: particles with deforming boundaries, velocities and deformations."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse
from matplotlib.text import Text

from harness.report.figures.style import BLUE, COLOURS, RED, STYLES, label
from harness.reproduction.movies.frames import RowMotion
from harness.reproduction.movies.stage import Camera, Image, power, stage

WIDTH, HEIGHT = 880, 520
_FILLS = ("#d9d9d9", "#f7d9c4", "#c4e0f0")
_BOTTOM, _TOP = -0.92, 0.86  # of the scene, in diameters from the row
_ARROWS, _SPEEDS, _STATES = 0.61, 0.75, -0.72
_INK = "#333333"


class RowCollision:
    """Draws the frames of a row that is small enough to tell its particles apart."""

    def __init__(self, motion: RowMotion) -> None:
        self._motion = motion
        with stage(WIDTH, HEIGHT) as figure:
            _head(figure, motion)
            scene = figure.add_axes((0.01, 0.395, 0.98, 0.485))
            self._build_scene(scene)
            self._curves = _Curves(figure, motion)
            self._camera = Camera(figure, [*self._artists(), *self._curves.moving])

    @property
    def frames(self) -> int:
        """Return the number of frames."""
        return self._motion.time.size

    @property
    def poster_frame(self) -> int:
        """Return the frame of the largest deformation."""
        return int(self._motion.deformation.max(axis=1).argmax())

    def picture(self, frame: int) -> Image:
        """Return one frame (height, width, 3)."""
        motion = self._motion
        centres, widths = motion.drawn_centres[frame], motion.drawn_widths[frame]
        for i, (shape, ghost) in enumerate(zip(self._shapes, self._ghosts, strict=True)):
            shape.set_center((centres[i], 0.0))
            shape.set_width(widths[i])
            ghost.set_center((centres[i], 0.0))
        self._show_velocities(frame, centres)
        self._show_contacts(frame, centres, widths)
        self._curves.show(frame)
        return self._camera.picture()

    def _build_scene(self, axes: Axes) -> None:
        motion = self._motion
        left = (motion.drawn_centres - motion.drawn_widths / 2).min()
        right = (motion.drawn_centres + motion.drawn_widths / 2).max()
        box = axes.get_window_extent()
        half = (_TOP - _BOTTOM) * box.width / box.height / 2
        middle = (left + right) / 2
        axes.set(xlim=(middle - half, middle + half), ylim=(_BOTTOM, _TOP))
        axes.axis("off")
        d = motion.run.tower.each("diameter")[0]
        particles = range(motion.run.tower.particles)
        self._ghosts = [
            Circle((0, 0), d / 2, fill=False, ec="#999999", lw=0.9, ls=(0, (2, 2)))
            for _ in particles
        ]
        self._shapes = [
            Ellipse((0, 0), d, d, fc=_FILLS[i % 3], ec=COLOURS[i], lw=1.8) for i in particles
        ]
        for patch in (*self._ghosts, *self._shapes):
            axes.add_patch(patch)
        self._faces = LineCollection([], colors=[RED], linewidths=[4.0], capstyle="round")
        self._arrows = LineCollection([], colors=[_INK], linewidths=[2.2])
        axes.add_collection(self._faces, autolim=False)
        axes.add_collection(self._arrows, autolim=False)
        (self._heads,) = axes.plot([], [], ls="none", marker=">", ms=7, color=_INK)
        (self._tails,) = axes.plot([], [], ls="none", marker="<", ms=7, color=_INK)
        self._speeds = [_text(axes, _SPEEDS) for _ in particles]
        self._states = [_text(axes, _STATES) for _ in range(len(self._shapes) - 1)]

    def _artists(self) -> list[Artist]:
        return [
            *self._ghosts, *self._shapes, self._faces, self._arrows, self._heads, self._tails,
            *self._speeds, *self._states,
        ]  # fmt: skip

    def _show_velocities(self, frame: int, centres: np.ndarray) -> None:
        """Draw an arrow over each particle, as long as its velocity, with the number over it."""
        velocity = self._motion.velocity[frame]
        tips = centres + 0.42 * velocity / self._motion.run.tower.speed
        shown = np.abs(tips - centres) > 0.02
        pairs = [
            [(centre, _ARROWS), (tip, _ARROWS)]
            for centre, tip, show in zip(centres, tips, shown, strict=True)
            if show
        ]
        self._arrows.set_segments(pairs)
        forward, backward = shown & (tips > centres), shown & (tips < centres)
        self._heads.set_data(tips[forward], np.full(forward.sum(), _ARROWS))
        self._tails.set_data(tips[backward], np.full(backward.sum(), _ARROWS))
        for text, centre, value in zip(self._speeds, centres, velocity, strict=True):
            text.set_position((centre, text.get_position()[1]))
            text.set_text(f"{round(value, 2) + 0.0:.2f} m/s")

    def _show_contacts(self, frame: int, centres: np.ndarray, widths: np.ndarray) -> None:
        """Draw a bar at each contact that presses, as tall as its force, and say what it is."""
        motion = self._motion
        force, gap = motion.force[frame], motion.gap[frame]
        peak = motion.force.max()
        right, left = (centres + widths / 2)[:-1], (centres - widths / 2)[1:]
        bars, middles = [], (right + left) / 2
        for i, (x, text) in enumerate(zip(middles, self._states, strict=True)):
            pressing = force[i] > 1e-6 * peak
            text.set_position((x, text.get_position()[1]))
            if pressing:
                tall = 0.32 * force[i] / peak + 0.06
                bars.append([(x, -tall), (x, tall)])
                text.set(text=f"touch\n{force[i] / 1e3:.2f} kN", color=RED, fontweight="bold")
            else:
                text.set(
                    text=f"apart\n{1e3 * max(gap[i], 0.0):.2f} mm", color=_INK, fontweight="normal"
                )
        self._faces.set_segments(bars)


class _Curves:
    """Velocity and deformation of each particle against time, drawn as far as the film is."""

    def __init__(self, figure: Figure, motion: RowMotion) -> None:
        self._time = motion.time_over_t0
        self._values = (motion.velocity, 1e3 * motion.deformation)
        names = ("velocity (m/s)", "deformation (mm)")
        self.moving: list[Artist] = []
        self._lines = []
        self._cursors = []
        for column, (values, name) in enumerate(zip(self._values, names, strict=True)):
            axes = figure.add_axes((0.065 + 0.51 * column, 0.1, 0.41, 0.27))
            label(axes, "time (t0)", name)
            axes.set_xlim(self._time[0], self._time[-1])
            spread = np.ptp(values)
            axes.set_ylim(values.min() - 0.07 * spread, values.max() + 0.07 * spread)
            lines = []
            for i in range(values.shape[1]):
                who = "grain" if i == 0 else f"particle {i + 1}"
                axes.plot(
                    self._time, values[:, i], color=COLOURS[i], ls=STYLES[i], lw=1, alpha=0.25
                )
                (line,) = axes.plot([], [], color=COLOURS[i], ls=STYLES[i], lw=2.2, label=who)
                lines.append(line)
            if column == 1:
                axes.legend(loc="upper right", handlelength=2.6)
            cursor = axes.axvline(0, color=BLUE, lw=1)
            self._lines.append(lines)
            self._cursors.append(cursor)
            self.moving += [cursor, *lines]

    def show(self, frame: int) -> None:
        now = self._time[frame]
        for values, lines, cursor in zip(self._values, self._lines, self._cursors, strict=True):
            cursor.set_xdata([now, now])
            for i, line in enumerate(lines):
                line.set_data(self._time[: frame + 1], values[: frame + 1, i])


def _head(figure: Figure, motion: RowMotion) -> None:
    tower = motion.run.tower
    figure.text(0.02, 0.957, motion.title, fontsize=13, fontweight="bold", va="center")
    figure.text(
        0.02, 0.908,
        f"deformable law, exact propagator, k = {power(tower.each('stiffness')[0])} N/m, "
        f"no gravity; displacements and deformations {motion.exaggeration:g} times; "
        "dotted: undeformed",
        fontsize=9, va="center", color=_INK,
    )  # fmt: skip


def _text(axes: Axes, y: float) -> Text:
    return axes.text(0, y, "", ha="center", va="center", fontsize=10.5, clip_on=False)
