"""The film of the grain over the bumps: to scale, tilted as it is, with its speed below."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from harness.cases.incline.runs import measured
from harness.cases.incline.system import Incline, InclineRun, Motion
from harness.engines.contract import Engine
from harness.report.film import WIDTH, Film, Scene
from harness.report.style import BLACK, RED, label, power

Floats = NDArray[np.float64]

SAMPLING = 0.02
"""[sqrt(d/g)] between two samples of a path: a tenth of a frame."""

_ENDS = {
    Motion.TRAPPED: "turns back, trapped",
    Motion.MOVES_ON: "moves on",
    Motion.UNDECIDED: "undecided",
}

_LEAST_AHEAD = 8.0
"""[diameters] of the row that is seen at least."""

_ABOVE, _BELOW = 1.5, 0.7
"""[diameters] that are seen over the grain at the start and under the row's end."""

_HEAD, _PLOT = 78, 190
"""Pixels of the text above, and of the speed below."""


def incline_film(engine: Engine, case: Incline, frames: int) -> Film:
    """Run a case in steady motion and return its film; raise EngineError for a run that failed."""
    (run,) = measured(engine, [case], "steady", every=sampling(case))
    return InclineGrain(InclineMotion(run, np.linspace(0.0, run.time_s, frames))).film()


def sampling(case: Incline) -> int:
    """Return the steps between two samples of a film."""
    return max(1, int(SAMPLING * (case.diameter / case.gravity) ** 0.5 / case.step))


@dataclass(frozen=True)
class InclineMotion:
    """F frames, at ``time`` (F,) [s], of the grain over the bumps in a run with a path."""

    run: InclineRun
    time: Floats


class InclineGrain(Scene):
    """Draws the frames of a grain on its row, tilted as it is."""

    def __init__(self, motion: InclineMotion) -> None:
        self.motion, self.frames = motion, motion.time.size
        run = motion.run
        self.title = f"The grain over the bumps at {_degrees(run)}"
        d = run.case.diameter
        self._x, self._y = _tilted(run.path.x_m / d, run.path.y_m / d, run)
        self._ahead = max(float(run.path.x_m.max()) / d, _LEAST_AHEAD)
        self._tall = _ABOVE + _BELOW + self._ahead * math.sin(math.radians(run.case.angle))
        self._row = self._tall * WIDTH / (self._ahead + 1.7)
        self.height = 2 * round((self._row + _HEAD + _PLOT) / 2)
        super().__init__()

    def subtitle(self) -> str:
        """Return engine, contact and scale."""
        case, provenance = self.motion.run.case, self.motion.run.provenance
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
        """Return the last frame, where it is known how the motion ends."""
        return self.frames - 1

    def build(self, figure: Figure) -> list[Artist]:
        """Draw the row above, the speed against time below."""
        run = self.motion.run
        axes = self.axes(figure, 0, _PLOT, WIDTH, self._row)
        axes.set(xlim=(-0.6, self._ahead + 1.1), ylim=(_ABOVE - self._tall, _ABOVE), aspect="equal")
        axes.axis("off")
        places = np.arange(int(self._ahead) + 3)
        row = [Circle(at, 0.5) for at in zip(*_tilted(places, 0.0 * places, run), strict=True)]
        axes.add_collection(PatchCollection(row, fc="#e4e4e4", ec="#888888", lw=0.8))
        (self._trail,) = axes.plot([], [], color=RED, ls="--", lw=1.8)
        self._grain = Circle((0, 0), 0.5, fc=RED, ec=BLACK, lw=1)
        axes.add_patch(self._grain)
        bold: dict[str, Any] = {"va": "center", "fontweight": "bold"}
        self._speed = axes.text(0, 0, "", color="white", ha="center", **bold)
        self._words = axes.text(
            0.98 * WIDTH, axes.get_window_extent().y1 - 12, "", transform=None,
            ha="right", color=RED, fontsize=11.5, **bold,
        )  # fmt: skip
        below = self.axes(figure, 75, 54, WIDTH - 92, _PLOT - 68)
        drawn = self._speed_against_time(below)
        return [self._trail, self._grain, self._speed, self._words, *drawn]

    def _speed_against_time(self, axes: Axes) -> list[Artist]:
        """Draw the speed, faint as a whole; return what is bold as far as the film is."""
        path = self.motion.run.path
        axes.plot(path.time_s, path.speed_m_per_s, color=RED, lw=1, alpha=0.25)
        (self._passed,) = axes.plot([], [], color=RED, lw=2.2)
        self._cursor = axes.axvline(0, color=BLACK, lw=1)
        axes.set(xlim=(0, self.motion.time[-1]), ylim=(0, None))
        label(axes, "time (s)", "speed (m/s)")
        return [self._cursor, self._passed]

    def show(self, frame: int) -> None:
        """Put the grain, its trail and words where they are at a frame."""
        now, run = float(self.motion.time[frame]), self.motion.run
        time, speed = run.path.time_s, run.path.speed_m_per_s
        seen = max(int(np.searchsorted(time, now, side="right")), 1)
        at = self._x[seen - 1], self._y[seen - 1]
        self._grain.set_center(at)
        self._speed.set_position(at)
        self._speed.set_text(f"{speed[seen - 1]:.{_digits(speed.max())}f}\nm/s")
        self._trail.set_data(self._x[:seen], self._y[:seen])
        self._words.set_text(_status(run, now))
        self._passed.set_data(time[:seen], speed[:seen])
        self._cursor.set_xdata([now, now])


def _degrees(run: InclineRun) -> str:
    hundredths = f"{run.case.angle:.2f}"
    exact = abs(float(hundredths) - run.case.angle) < 1e-9
    return f"{hundredths if exact else format(run.case.angle, '.6g')} deg"


def _seconds(time: float, longest: float) -> str:
    """Return a time to a hundredth of the longest, in s or ms."""
    factor, unit = (1.0, "s") if longest >= 1.0 else (1e3, "ms")
    return f"{time * factor:.{_digits(longest * factor)}f} {unit}"


def _digits(largest: float) -> int:
    """Return the decimals of a hundredth of a value."""
    return max(0, 2 - math.floor(math.log10(largest)))


def _tilted(x: NDArray[Any], y: NDArray[Any], run: InclineRun) -> tuple[Floats, Floats]:
    """Return where a point of the row is in the picture [diameters]: it falls to the right."""
    tilt = np.radians(run.case.angle)
    return x * np.cos(tilt) + y * np.sin(tilt), y * np.cos(tilt) - x * np.sin(tilt)


def _status(run: InclineRun, now: float) -> str:
    """Say how far the grain is at a time [s], or how it ended."""
    crests = int(np.searchsorted(run.crests.time_s, now * (1 + 1e-9), side="right"))
    end = f", {_ENDS[run.motion]}" if now >= run.time_s else ""
    return f"{crests} crests passed{end}"
