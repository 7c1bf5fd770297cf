"""The film of the grain over the bumps, at one angle or several: to scale, tilted as it is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Text
from numpy.typing import NDArray

from harness.cases.incline.runs import measured
from harness.cases.incline.system import Incline, InclineRun, Motion
from harness.engines.contract import Engine
from harness.observables.reference import Trajectory
from harness.report.film import WIDTH, Film, Scene, Traces
from harness.report.style import BLACK, BLUE, GREEN, RED, label, power
from harness.theory.incline import critical_angle

SAMPLING = 0.02
"""[sqrt(d/g)] between two samples of a path: a tenth of a frame."""

_LOOKS = ((RED, "--"), (BLUE, "-"), (GREEN, "-."))
_ENDS = {
    Motion.TRAPPED: "turns back, trapped",
    Motion.MOVES_ON: "moves on",
    Motion.UNDECIDED: "undecided",
}
_LANE = 2.05
"""Distance of two rows across, in diameters."""

_LEAST_AHEAD = 8.0
"""[diameters] of the row that is seen at least."""

_ABOVE, _BELOW = 1.5, 0.7
_HEAD, _PLOT = 78, 190
"""Pixels of the text above, and of the speeds below."""


def incline_film(engine: Engine, case: Incline, frames: int) -> Film:
    """Run a case in steady motion and return its film; raise EngineError for a run that failed."""
    (run,) = measured(engine, [case], "steady", every=sampling(case))
    motion = InclineMotion(
        name="incline-film",
        title=f"The grain over the bumps at {_degrees(run)}",
        sentence=incline_sentence(run),
        runs=(run,),
        time=np.linspace(0.0, run.time_s, frames),
    )
    return InclineGrain(motion).film(motion.name, motion.sentence)


def sampling(case: Incline) -> int:
    """Return the steps between two samples of a film."""
    return max(1, int(SAMPLING * (case.diameter / case.gravity) ** 0.5 / case.step))


@dataclass(frozen=True)
class InclineMotion:
    """F frames of the grain over the bumps in runs that differ by the angle.

    The runs have trajectories. After its end a run stays where it ended.
    """

    name: str
    title: str
    sentence: str
    runs: tuple[InclineRun, ...]
    time: NDArray[np.float64]  # (F,) [s]

    def path(self, run: InclineRun) -> Trajectory:
        """Return the run's trajectory at the frames: the last recorded row by each."""
        rows = np.searchsorted(run.path.time_s, self.time + 1e-9 * self.time[-1], side="right") - 1
        rows = rows.clip(0)
        return Trajectory(**{name: column[rows] for name, column in vars(run.path).items()})


def incline_sentence(*runs: InclineRun) -> str:
    """Say how far the grain comes at each angle."""
    closed = f"The closed form has the critical angle at {critical_angle():.4f} deg"
    return ". ".join((closed, *map(_fate, runs))) + "."


def _fate(run: InclineRun) -> str:
    """Say what became of a grain: ``At 10.20 deg it is trapped after 6 crests (14.8 s)``."""
    words = {"moves_on": "moves on over", "trapped": "is trapped after"}
    fate = words.get(run.motion.value, "is undecided after")
    crests = len(run.crests.time_s)
    text = f"At {_degrees(run)} it {fate} {crests} crests ({run.time_s:.3g} s)"
    if run.motion is not Motion.TRAPPED:
        return text
    gone = run.path.x_m[-1] / run.case.diameter
    return f"{text}; its path ends where it turns back, at {gone:.2f} diameters"


def _degrees(run: InclineRun) -> str:
    hundredths = f"{run.case.angle:.2f}"
    exact = abs(float(hundredths) - run.case.angle) < 1e-9
    return f"{hundredths if exact else format(run.case.angle, '.6g')} deg"


class Lane(NamedTuple):
    """One of the rows: its run, where the grain is on stage, and what moves."""

    run: InclineRun
    path: Trajectory
    x: NDArray[np.float64]  # [diameters]
    y: NDArray[np.float64]
    trail: Line2D
    grain: Circle
    speed: Text
    words: Text


class InclineGrain(Scene):
    """Draws the frames of grains on parallel rows, tilted as they are."""

    def __init__(self, motion: InclineMotion) -> None:
        self.motion, self.title, self.frames = motion, motion.title, motion.time.size
        d = motion.runs[0].case.diameter
        farthest = max(float(run.path.x_m.max()) for run in motion.runs) / d
        self._ahead = max(farthest, _LEAST_AHEAD)
        steepest = np.radians(max(run.case.angle for run in motion.runs))
        self._tall = _ABOVE + _LANE * (len(motion.runs) - 1) + _BELOW
        self._tall += self._ahead * float(np.sin(steepest))
        self._rows = self._tall * WIDTH / (self._ahead + 1.7)
        self.height = 2 * round((self._rows + _HEAD + _PLOT) / 2)
        super().__init__()

    def subtitle(self) -> str:
        """Return engine, contact and scale."""
        case, provenance = self.motion.runs[0].case, self.motion.runs[0].provenance
        contact = (
            f"{case.contact.name} contact, zeta = {case.contact.zeta:.3g}, {case.contact.tail}"
        )
        return (
            f"{provenance.engine} {provenance.engine_version}, {contact} tail, "
            f"k = {power(case.stiffness)} N/m\n"
            f"{case.steps_per_contact:g} steps per contact, d = {case.diameter:g} m, "
            f"m = {case.mass:.4g} kg, g = {case.gravity:g} m/s²; drawn to scale, tilted as it is"
        )

    def clock(self, frame: int) -> str:
        """Return the time."""
        return f"t = {_seconds(self.motion.time[frame], self.motion.time[-1])}"

    @property
    def poster_frame(self) -> int:
        """Return the last frame, where all fates are known."""
        return self.frames - 1

    def build(self, figure: Figure) -> list[Artist]:
        """Draw the rows above, the speeds against time below."""
        axes = self.axes(figure, 0, _PLOT, WIDTH, self._rows)
        below = self.axes(figure, 75, 54, WIDTH - 92, _PLOT - 68)
        axes.set(xlim=(-0.6, self._ahead + 1.1), ylim=(_ABOVE - self._tall, _ABOVE), aspect="equal")
        axes.axis("off")
        spheres = np.arange(int(self._ahead) + 3)
        self._lanes = [_lane(axes, run, lane, spheres) for lane, run in enumerate(self.motion.runs)]
        self._speeds = Traces(
            below,
            [
                (row.path.time_s, row.path.speed_m_per_s, _degrees(row.run), {"color": c, "ls": ls})
                for row, (c, ls) in zip(self._lanes, _LOOKS, strict=False)
            ],
        )
        below.set(xlim=(0, self.motion.time[-1]), ylim=(0, None))
        label(below, "time (s)", "speed (m/s)")
        below.legend(loc="upper right", ncols=3, bbox_to_anchor=(1.0, 1.18))
        parts = zip(
            *((row.trail, row.grain, row.speed, row.words) for row in self._lanes), strict=True
        )
        return [*(artist for part in parts for artist in part), *self._speeds.moving]

    def show(self, frame: int) -> None:
        """Put grains, their trails and words where they are at a frame."""
        now = float(self.motion.time[frame])
        for lane in self._lanes:
            seen = max(int(np.searchsorted(lane.path.time_s, now, side="right")), 1)
            at = lane.x[seen - 1], lane.y[seen - 1]
            lane.grain.set_center(at)
            lane.speed.set_position(at)
            speed = lane.path.speed_m_per_s[seen - 1]
            lane.speed.set_text(f"{speed:.{_digits(lane.path.speed_m_per_s.max())}f}\nm/s")
            lane.trail.set_data(lane.x[:seen], lane.y[:seen])
            lane.words.set_text(_status(lane.run, now))
        self._speeds.show(now)


def _seconds(time: float, longest: float) -> str:
    """Return a time to a hundredth of the longest, in s or ms."""
    factor, unit = (1.0, "s") if longest >= 1.0 else (1e3, "ms")
    return f"{time * factor:.{_digits(longest * factor)}f} {unit}"


def _digits(largest: float) -> int:
    """Return the decimals of a hundredth of a value."""
    return max(0, 2 - math.floor(math.log10(largest)))


def _lane(axes: Axes, run: InclineRun, lane: int, spheres: NDArray[np.int64]) -> Lane:
    """Draw a row of spheres; return it with the grain on it."""
    colour, style = _LOOKS[lane]
    row = [Circle(at, 0.5) for at in zip(*_tilted(spheres, 0.0 * spheres, run, lane), strict=True)]
    axes.add_collection(PatchCollection(row, fc="#e4e4e4", ec="#888888", lw=0.8))
    grain = Circle((0, 0), 0.5, fc=colour, ec=BLACK, lw=1)
    axes.add_patch(grain)
    (trail,) = axes.plot([], [], color=colour, ls=style, lw=1.8)
    middle: dict[str, Any] = {"va": "center", "fontweight": "bold"}
    path, d = run.path, run.case.diameter
    return Lane(
        run,
        path,
        *_tilted(path.x_m / d, path.y_m / d, run, lane),
        trail,
        grain,
        axes.text(0, 0, "", color="white", ha="center", **middle),
        axes.text(
            0.98 * WIDTH, axes.get_window_extent().y1 - 12 - 26 * lane, "", transform=None,
            ha="right", color=colour, fontsize=11.5, **middle,
        ),
    )  # fmt: skip


def _tilted(
    x: NDArray[Any], y: NDArray[Any], run: InclineRun, lane: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where a point of a row is on stage [diameters]: it falls to the right."""
    tilt = np.radians(run.case.angle)
    across = y - _LANE * lane
    return x * np.cos(tilt) + across * np.sin(tilt), across * np.cos(tilt) - x * np.sin(tilt)


def _status(run: InclineRun, now: float) -> str:
    """Say which grain this is and how far it is, or how it ended."""
    crests = int(np.searchsorted(run.crests.time_s, now * (1 + 1e-9), side="right"))
    words = f"{_degrees(run)}: {crests} crests passed"
    return words + (f", {_ENDS[run.motion]}" if now >= run.time_s else "")
