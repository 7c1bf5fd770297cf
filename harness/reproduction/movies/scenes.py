"""The movie of a free row: particles with deforming boundaries, velocities and deformations."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse

from harness.cases.tower.film import RowMotion
from harness.report.film import INK, Scene, Traces
from harness.report.style import COLOURS, RED, STYLES, label, power

_FILLS = ("#d9d9d9", "#f7d9c4", "#c4e0f0")
_BOTTOM, _TOP = -0.92, 0.86  # of the scene, in diameters from the row
_ARROWS, _SPEEDS, _STATES = 0.61, 0.75, -0.72


class RowCollision(Scene):
    """Draws the frames of a row that is small enough to tell its particles apart."""

    height = 530

    def __init__(self, motion: RowMotion) -> None:
        self.motion, self.title, self.frames = motion, motion.title, motion.time.size
        super().__init__()

    def clock(self, frame: int) -> str:
        """Return the time."""
        return f"t = {round(float(self.motion.time_over_t0[frame]), 2) + 0.0:.2f} t0"

    def subtitle(self) -> str:
        """Return law, solver and scale."""
        return (
            "deformable law, exact propagator, "
            f"k = {power(self.motion.run.tower.each('stiffness')[0])} N/m, "
            f"no gravity; displacements and deformations {self.motion.exaggeration:g} times; "
            "dotted: undeformed"
        )

    @property
    def poster_frame(self) -> int:
        """Return the frame of the largest deformation."""
        return int(self.motion.deformation.max(axis=1).argmax())

    def build(self, figure: Figure) -> list[Artist]:
        """Draw the row above, velocities and deformations against time below."""
        motion, axes = self.motion, figure.add_axes((0.01, 0.395, 0.98, 0.485))
        left = (motion.drawn_centres - motion.drawn_widths / 2).min()
        right = (motion.drawn_centres + motion.drawn_widths / 2).max()
        box = axes.get_window_extent()
        half = (_TOP - _BOTTOM) * box.width / box.height / 2
        middle = (left + right) / 2
        axes.set(xlim=(middle - half, middle + half), ylim=(_BOTTOM, _TOP))
        axes.axis("off")
        moving = self._row(axes)
        self._traces = [
            self._trace(figure.add_axes((0.065 + 0.51 * column, 0.1, 0.41, 0.27)), values, name)
            for column, (values, name) in enumerate(
                (
                    (motion.velocity, "velocity (m/s)"),
                    (1e3 * motion.deformation, "deformation (mm)"),
                )
            )
        ]
        figure.axes[-1].legend(loc="upper right", handlelength=2.6)
        return [*moving, *(artist for trace in self._traces for artist in trace.moving)]

    def _row(self, axes: Axes) -> list[Artist]:
        d, n = self.motion.run.tower.each("diameter")[0], self.motion.run.tower.particles
        dotted = {"fill": False, "ec": "#999999", "lw": 0.9, "ls": (0, (2, 2))}
        self._ghosts = [Circle((0, 0), d / 2, **dotted) for _ in range(n)]
        self._shapes = [
            Ellipse((0, 0), d, d, fc=_FILLS[i % 3], ec=COLOURS[i], lw=1.8) for i in range(n)
        ]
        for patch in (*self._ghosts, *self._shapes):
            axes.add_patch(patch)
        self._faces = LineCollection([], colors=[RED], linewidths=[4.0], capstyle="round")
        self._arrows = LineCollection([], colors=[INK], linewidths=[2.2])
        axes.add_collection(self._faces, autolim=False)
        axes.add_collection(self._arrows, autolim=False)
        self._heads, self._tails = (
            axes.plot([], [], ls="none", marker=marker, ms=7, color=INK)[0] for marker in "><"
        )
        self._speeds, self._states = (
            [
                axes.text(0, y, "", ha="center", va="center", fontsize=10.5, clip_on=False)
                for _ in range(count)
            ]
            for y, count in ((_SPEEDS, n), (_STATES, n - 1))
        )
        drawn = [*self._ghosts, *self._shapes, self._faces, self._arrows, self._heads, self._tails]
        return [*drawn, *self._speeds, *self._states]

    def _trace(self, axes: Axes, values: np.ndarray, name: str) -> Traces:
        time = self.motion.time_over_t0
        label(axes, "time (t0)", name)
        axes.set_xlim(time[0], time[-1])
        spread = 0.07 * np.ptp(values)
        axes.set_ylim(values.min() - spread, values.max() + spread)
        return Traces(
            axes,
            [
                (time, one, f"particle {i}" if i > 1 else "grain", {"color": colour, "ls": line})
                for i, (one, colour, line) in enumerate(
                    zip(values.T, COLOURS, STYLES, strict=False), 1
                )
            ],
        )

    def show(self, frame: int) -> None:
        """Put particles, arrows, contacts and curves where they are at a frame."""
        motion = self.motion
        centres, widths = motion.drawn_centres[frame], motion.drawn_widths[frame]
        for x, width, shape, ghost in zip(centres, widths, self._shapes, self._ghosts, strict=True):
            shape.set_center((x, 0.0))
            shape.set_width(width)
            ghost.set_center((x, 0.0))
        self._show_velocities(motion.velocity[frame], centres)
        self._show_contacts(frame, centres, widths)
        for trace in self._traces:
            trace.show(motion.time_over_t0[frame])

    def _show_velocities(self, velocity: np.ndarray, centres: np.ndarray) -> None:
        """Draw an arrow over each particle, as long as its velocity, with the number over it."""
        tips = centres + 0.42 * velocity / self.motion.run.tower.speed
        shown = np.abs(tips - centres) > 0.02
        ends = np.stack([centres, tips], axis=1)[shown]
        self._arrows.set_segments([[(x, _ARROWS) for x in pair] for pair in ends])
        for marks, chosen in ((self._heads, tips > centres), (self._tails, tips < centres)):
            there = tips[shown & chosen]
            marks.set_data(there, np.full(there.size, _ARROWS))
        for text, x, value in zip(self._speeds, centres, velocity, strict=True):
            text.set_x(x)
            text.set_text(f"{round(value, 2) + 0.0:.2f} m/s")

    def _show_contacts(self, frame: int, centres: np.ndarray, widths: np.ndarray) -> None:
        """Draw a bar at each contact that presses, as tall as its force, and say what it is."""
        force, gap, peak = self.motion.force[frame], self.motion.gap[frame], self.motion.force.max()
        bars = []
        faces = ((centres + widths / 2)[:-1] + (centres - widths / 2)[1:]) / 2
        for x, pressing, open_by, text in zip(faces, force, gap, self._states, strict=True):
            text.set_x(x)
            if pressing > 1e-6 * peak:
                tall = 0.32 * pressing / peak + 0.06
                bars.append([(x, -tall), (x, tall)])
                text.set(text=f"touch\n{pressing / 1e3:.2f} kN", color=RED, fontweight="bold")
            else:
                told = f"apart\n{1e3 * max(open_by, 0.0):.2f} mm"
                text.set(text=told, color=INK, fontweight="normal")
        self._faces.set_segments(bars)
