"""The movie of the grain over the bumps, below and above the critical angle, to scale."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Text

from harness.cases.incline.result import InclineRun, Motion
from harness.observables.trajectory import Trajectory
from harness.report.figures.style import BLACK, BLUE, RED, label, power
from harness.reproduction.movies.frames import InclineMotion
from harness.reproduction.movies.stage import Scene, Traces

_LOOKS = ((RED, "--"), (BLUE, "-"))
_ENDS = {
    Motion.TRAPPED: "turns back, trapped",
    Motion.MOVES_ON: "moves on",
    Motion.UNDECIDED: "undecided",
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
