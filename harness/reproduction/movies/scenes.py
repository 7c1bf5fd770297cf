"""The scenes of the movies: grain on the incline, row that collides, shock down a tower.

What the scenes share: a figure of which only some parts are drawn again for each frame.

The movie of the grain over the bumps, below and above the critical angle, to scale.

The movie of a free row: particles with deforming boundaries, velocities and deformations.

The movie of the shock down a tower: its particles, and the force of each contact in time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Ellipse, Rectangle
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from harness.cases.incline.system import InclineRun
from harness.cases.incline.system import Motion as GrainMotion
from harness.observables.reference import Trajectory
from harness.observables.windows import SIGNIFICANT_FORCE, significant_contacts
from harness.report.gallery import Image
from harness.report.style import BLACK, BLUE, COLOURS, RED, STYLES, house_style, label, power
from harness.reproduction.movies.motions import InclineMotion, RowMotion

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


_LOOKS = ((RED, "--"), (BLUE, "-"))
_ENDS = {
    GrainMotion.TRAPPED: "turns back, trapped",
    GrainMotion.MOVES_ON: "moves on",
    GrainMotion.UNDECIDED: "undecided",
}
_LANE = 2.05
"""Distance of the two rows across, in diameters."""


class Lane(NamedTuple):
    """One of the two rows: its run, where the grain is on stage, and what moves."""

    run: InclineRun
    path: Trajectory
    x: np.ndarray  # [diameters]
    y: np.ndarray
    trail: Line2D
    grain: Circle
    speed: Text
    words: Text


class InclineGrain(Scene[InclineMotion]):
    """Draws the frames of two grains on parallel rows, tilted as they are."""

    height, head = 700, (0.966, 0.927)

    def subtitle(self) -> str:
        """Return engine, contact and scale."""
        case, who = self.motion.below.case, self.motion.below.provenance
        return (
            f"{who.engine} {who.engine_version}, {case.contact.name} contact, "
            f"k = {power(case.stiffness)} N/m, {case.steps_per_contact:g} steps per contact, "
            f"d = {case.diameter:g} m; drawn to scale, tilted as it is"
        )

    @property
    def poster_frame(self) -> int:
        """Return the last frame, where both fates are known."""
        return self.frames - 1

    def build(self, figure: Figure) -> list[Artist]:
        """Draw both rows above, the speeds against time below."""
        axes, below = (
            figure.add_axes((0.0, 0.28, 1.0, 0.62)),
            figure.add_axes((0.075, 0.08, 0.905, 0.175)),
        )
        paths = [run.path for run in self.motion.runs]
        ahead = max(float(path.x_m.max()) for path in paths) / self.motion.below.case.diameter
        box = axes.get_window_extent()
        axes.set(xlim=(-0.6, ahead + 1.1), aspect="equal")
        tall = (ahead + 1.7) * box.height / box.width
        axes.set_ylim(1.5 - tall, 1.5)
        axes.axis("off")
        spheres = np.arange(int(ahead) + 3)
        self._lanes = [
            _lane(axes, run, path, lane, spheres)
            for lane, (run, path) in enumerate(zip(self.motion.runs, paths, strict=True))
        ]
        self._speeds = Traces(
            below,
            [
                (
                    path.time_s,
                    path.speed_m_per_s,
                    f"{run.case.angle:.2f} deg",
                    {"color": c, "ls": line},
                )
                for run, path, (c, line) in zip(self.motion.runs, paths, _LOOKS, strict=True)
            ],
        )
        below.set(xlim=(0, self.motion.time[-1]), ylim=(0, None))
        label(below, "time (s)", "speed (m/s)")
        below.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.12))
        parts = zip(
            *((one.trail, one.grain, one.speed, one.words) for one in self._lanes), strict=True
        )
        return [*(artist for part in parts for artist in part), *self._speeds.moving]

    def show(self, frame: int) -> None:
        """Put grains, their trails and words where they are at a frame."""
        now = float(self.motion.time[frame])
        for lane in self._lanes:
            seen = int(np.searchsorted(lane.path.time_s, now, side="right"))
            at = lane.x[seen - 1], lane.y[seen - 1]
            lane.grain.set_center(at)
            lane.speed.set_position(at)
            lane.speed.set_text(f"{lane.path.speed_m_per_s[seen - 1]:.2f}\nm/s")
            lane.trail.set_data(lane.x[:seen], lane.y[:seen])
            lane.words.set_text(_status(lane.run, now, self.motion))
        self._speeds.show(now)


def _lane(axes: Axes, run: InclineRun, path: Trajectory, lane: int, spheres: np.ndarray) -> Lane:
    """Draw a row of spheres; return it with the grain on it."""
    colour, style = _LOOKS[lane]
    row = [Circle(at, 0.5) for at in zip(*_tilted(spheres, 0.0 * spheres, run, lane), strict=True)]
    axes.add_collection(PatchCollection(row, fc="#e4e4e4", ec="#888888", lw=0.8))
    grain = Circle((0, 0), 0.5, fc=colour, ec=BLACK, lw=1)
    axes.add_patch(grain)
    (trail,) = axes.plot([], [], color=colour, ls=style, lw=1.8)
    middle: dict[str, Any] = {"va": "center", "fontweight": "bold"}
    return Lane(
        run,
        path,
        *_tilted(path.x_m / run.case.diameter, path.y_m / run.case.diameter, run, lane),
        trail,
        grain,
        axes.text(0, 0, "", color="white", ha="center", **middle),
        axes.text(
            0.98, 0.955 - 0.062 * lane, "", transform=axes.transAxes, ha="right", color=colour,
            fontsize=11, **middle,
        ),
    )  # fmt: skip


def _tilted(
    x: np.ndarray, y: np.ndarray, run: InclineRun, lane: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return where a point of a row is on stage [diameters]: it falls to the right."""
    tilt = np.radians(run.case.angle)
    across = y - _LANE * lane
    return x * np.cos(tilt) + across * np.sin(tilt), across * np.cos(tilt) - x * np.sin(tilt)


def _status(run: InclineRun, now: float, motion: InclineMotion) -> str:
    """Say which grain this is and how far it is, or how it ended."""
    side = "below" if run is motion.below else "above"
    crests = int(np.searchsorted(run.crests.time_s, now * (1 + 1e-9), side="right"))
    words = f"{run.case.angle:.2f} deg, {side}: {crests} crests passed"
    return words + (f", {_ENDS[run.motion]}" if now >= run.time_s else "")


_FILLS = ("#d9d9d9", "#f7d9c4", "#c4e0f0")
_BOTTOM, _TOP = -0.92, 0.86  # of the scene, in diameters from the row
_ARROWS, _SPEEDS, _STATES = 0.61, 0.75, -0.72


class RowCollision(Scene[RowMotion]):
    """Draws the frames of a row that is small enough to tell its particles apart."""

    height, head = 520, (0.957, 0.908)

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
