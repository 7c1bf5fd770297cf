"""The movie of the grain over the bumps, below and above the critical angle, to scale."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from harness.cases.incline.result import InclineRun, Motion
from harness.observables.trajectory import Trajectory
from harness.report.figures.style import BLACK, BLUE, RED, label
from harness.reproduction.movies.frames import InclineMotion
from harness.reproduction.movies.stage import Camera, Image, power, stage

WIDTH, HEIGHT = 880, 700
_LOOKS = ((RED, "--"), (BLUE, "-"))
_ENDS = {
    Motion.TRAPPED: "turns back, trapped",
    Motion.MOVES_ON: "moves on",
    Motion.UNDECIDED: "undecided",
}
_LANE = 2.05
"""Distance of the two rows across, in diameters."""


class InclineGrain:
    """Draws the frames of two grains on parallel rows, tilted as they are."""

    def __init__(self, motion: InclineMotion) -> None:
        self._motion = motion
        self._paths = [_recorded(run) for run in motion.runs]
        self._on_stage = [
            _tilted(path.x_m / run.case.diameter, path.y_m / run.case.diameter, run, lane)
            for lane, (run, path) in enumerate(zip(motion.runs, self._paths, strict=True))
        ]
        with stage(WIDTH, HEIGHT) as figure:
            self._head(figure)
            scene = figure.add_axes((0.0, 0.28, 1.0, 0.62))
            curves = figure.add_axes((0.075, 0.08, 0.905, 0.175))
            moving = self._build_scene(scene)
            self._camera = Camera(figure, [*moving, *self._build_curves(curves)])

    @property
    def frames(self) -> int:
        """Return the number of frames."""
        return self._motion.time.size

    @property
    def poster_frame(self) -> int:
        """Return the last frame, where both fates are known."""
        return self.frames - 1

    def picture(self, frame: int) -> Image:
        """Return one frame (height, width, 3)."""
        now = float(self._motion.time[frame])
        for lane, (run, path) in enumerate(zip(self._motion.runs, self._paths, strict=True)):
            x, y = self._on_stage[lane]
            seen = int(np.searchsorted(path.time_s, now, side="right"))
            at, speed = (x[seen - 1], y[seen - 1]), path.speed_m_per_s[:seen]
            self._grains[lane].set_center(at)
            self._speeds[lane].set_position(at)
            self._speeds[lane].set_text(f"{speed[-1]:.2f}\nm/s")
            self._trails[lane].set_data(x[:seen], y[:seen])
            self._lines[lane].set_data(path.time_s[:seen], speed)
            self._words[lane].set_text(_status(run, now, self._motion))
        self._cursor.set_xdata([now, now])
        return self._camera.picture()

    def _head(self, figure: Figure) -> None:
        case, who = self._motion.below.case, self._motion.below.provenance
        figure.text(0.02, 0.966, self._motion.title, fontsize=13, fontweight="bold", va="center")
        figure.text(
            0.02, 0.927,
            f"{who.engine} {who.engine_version}, {case.contact.name} contact, "
            f"k = {power(case.stiffness)} N/m, {case.steps_per_contact:g} steps per contact, "
            f"d = {case.diameter:g} m; drawn to scale, tilted as it is",
            fontsize=9, va="center", color="#333333",
        )  # fmt: skip

    def _build_scene(self, axes: Axes) -> list[Artist]:
        motion = self._motion
        ahead = max(float(path.x_m.max()) for path in self._paths) / motion.below.case.diameter
        spheres = np.arange(int(ahead) + 3)
        box = axes.get_window_extent()
        axes.set(xlim=(-0.6, ahead + 1.1), aspect="equal")
        left, right = axes.get_xlim()
        tall = (right - left) * box.height / box.width
        axes.set_ylim(1.5 - tall, 1.5)
        axes.axis("off")
        self._grains, self._trails, self._words, self._speeds = [], [], [], []
        for lane, (run, (colour, style)) in enumerate(zip(motion.runs, _LOOKS, strict=True)):
            x, y = _tilted(spheres, 0.0 * spheres, run, lane)
            row = [Circle((float(a), float(b)), 0.5) for a, b in zip(x, y, strict=True)]
            axes.add_collection(PatchCollection(row, fc="#e4e4e4", ec="#888888", lw=0.8))
            grain = Circle((0, 0), 0.5, fc=colour, ec=BLACK, lw=1)
            axes.add_patch(grain)
            (trail,) = axes.plot([], [], color=colour, ls=style, lw=1.8)
            self._grains.append(grain)
            self._trails.append(trail)
            self._speeds.append(
                axes.text(0, 0, "", color="white", fontweight="bold", ha="center", va="center")
            )
            self._words.append(
                axes.text(
                    0.98, 0.955 - 0.062 * lane, "", transform=axes.transAxes, ha="right",
                    va="center", color=colour, fontweight="bold", fontsize=11,
                )
            )  # fmt: skip
        return [*self._trails, *self._grains, *self._speeds, *self._words]

    def _build_curves(self, axes: Axes) -> list[Artist]:
        self._lines = []
        for run, path, (colour, style) in zip(self._motion.runs, self._paths, _LOOKS, strict=True):
            axes.plot(path.time_s, path.speed_m_per_s, color=colour, lw=0.8, alpha=0.25)
            (line,) = axes.plot(
                [], [], color=colour, ls=style, lw=1.8, label=f"{run.case.angle:.2f} deg"
            )
            self._lines.append(line)
        axes.set_xlim(0, self._motion.time[-1])
        axes.set_ylim(0, None)
        label(axes, "time (s)", "speed (m/s)")
        axes.legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.12))
        self._cursor = axes.axvline(0, color=BLACK, lw=1)
        return [*self._lines, self._cursor]


def _tilted(
    x: np.ndarray, y: np.ndarray, run: InclineRun, lane: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return where a point of a row is on stage [diameters]: it falls to the right."""
    tilt = np.radians(run.case.angle)
    across = y - _LANE * lane
    return x * np.cos(tilt) + across * np.sin(tilt), across * np.cos(tilt) - x * np.sin(tilt)


def _recorded(run: InclineRun) -> Trajectory:
    if run.trajectory is None:
        raise ValueError("run without trajectory: nothing to show")
    return run.trajectory


def _status(run: InclineRun, now: float, motion: InclineMotion) -> str:
    """Say which grain this is and how far it is, or how it ended."""
    side = "below" if run is motion.below else "above"
    crests = int(np.searchsorted(run.crests.time_s, now * (1 + 1e-9), side="right"))
    words = f"{run.case.angle:.2f} deg, {side}: {crests} crests passed"
    return words + (f", {_ENDS[run.motion]}" if now >= run.time_s else "")
