"""The film of a tower: its particles, and the force of each contact in time.

A row of particles as frames at equal times, drawn by the motion and the forces of a run. Under the
deformable law particles are drawn shortened; under the overlap law they overlap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.observables.tower import SIGNIFICANT_FORCE, TowerRun, significant_contacts
from harness.report.film import Film, Scene
from harness.report.style import BLACK, RED, label, power

Floats = NDArray[np.float64]

LEAD = 0.3
"""[t0] of the grain's approach that is shown."""

_WIDEST = 0.32
"""The largest deformation is drawn as about this part of a diameter."""


def tower_film(run: TowerRun, frames: int) -> Film:
    """Return the film of a run with profiles.

    Raise RequestError for a run without any, and for one in which nothing touches.
    """
    if run.profiles is None:
        raise RequestError("film: the run kept no profiles; run the tower with profiles=True")
    touching = run.tower.start == "touching" and run.tower.gap == 0.0
    lead, duration = LEAD if touching else 0.0, float(run.time_over_t0[-1])
    before = round(frames * lead / (lead + duration))
    per_t0 = (frames - 1 - before) / duration
    return TowerShock(row_motion(run, lead=before / per_t0, frames_per_t0=per_t0)).film()


def force_scale(peak: float) -> tuple[float, str]:
    """Return the factor from N, and the unit, in which a force is from 1 to 1000 or so."""
    return (1e-3, "kN") if peak >= 1e3 else (1.0, "N") if peak >= 1.0 else (1e3, "mN")


@dataclass(frozen=True)
class RowMotion:
    """F frames of a row of N particles; frames before time 0 show the grain's approach.

    Displacements and deformations are thousandths of a diameter. ``exaggeration``
    is how many times as large they are drawn: all of them, so that the
    drawn boundaries touch where the particles do. Raise ValueError if a
    particle would be drawn without width. ``run`` is sampled finely and has profiles.
    """

    run: TowerRun
    exaggeration: float
    time: Floats  # (F,) [s]
    displacement: Floats  # (F, N) [m] from where all particles just touch
    force: Floats  # (F, N - 1) [N] of each contact, 0 where it is open

    def __post_init__(self) -> None:
        if not (self.exaggeration > 0 and self.drawn_widths.min() > 0):
            raise ValueError(
                f"exaggeration = {self.exaggeration}: must be greater than 0 and leave every "
                "particle a width"
            )

    @property
    def deformation(self) -> Floats:
        """Return how much each diameter is shortened (F, N) [m]; not at all where they overlap."""
        if self.run.tower.law == "overlap":
            return np.zeros_like(self.displacement)
        both_sides = np.pad(self.force, ((0, 0), (1, 1)))
        stiffness = np.array(self.run.tower.each("stiffness"))
        return np.asarray((both_sides[:, 1:] + both_sides[:, :-1]) / stiffness)

    @property
    def drawn_centres(self) -> Floats:
        """Return the centres as drawn (F, N) [m], the grain just touching at 0."""
        diameter = np.array(self.run.tower.each("diameter"))
        touching = np.cumsum(diameter) - (diameter + diameter[0]) / 2
        return np.asarray(touching + self.exaggeration * self.displacement)

    @property
    def drawn_widths(self) -> Floats:
        """Return the widths along the row as drawn (F, N) [m]."""
        diameter = np.array(self.run.tower.each("diameter"))
        return np.asarray(diameter - self.exaggeration * self.deformation)

    @property
    def time_over_t0(self) -> Floats:
        """Return the time in contact times of grain and one fixed particle (F,) [1]."""
        return self.time / self.run.tower.contact_time


def row_motion(run: TowerRun, *, lead: float, frames_per_t0: float) -> RowMotion:
    """Return the frames of a run with profiles, from ``-lead`` [t0] to its end.

    Before 0 the grain flies freely and the others are at rest.
    """
    case, kept = run.tower, run.known_profiles
    before = round(lead * frames_per_t0)
    after = math.floor(float(run.time_over_t0[-1]) * frames_per_t0 * (1.0 + 1e-9))
    step = case.contact_time / frames_per_t0
    rows = _nearest(run.time, np.asarray(step * np.arange(after + 1.0)))
    approach = step * np.arange(-before, 0)
    first = kept.displacements[0]
    still = np.tile(first, (before, 1))
    still[:, 0] += case.speed * approach + case.gravity * approach**2 / 2
    resting = np.zeros((before, case.height))
    return RowMotion(
        run=run,
        exaggeration=_exaggeration(run),
        time=np.concatenate([approach, run.time[rows]]),
        displacement=np.vstack([still, kept.displacements[rows]]),
        force=np.vstack([resting, kept.forces[rows]]),
    )


def _nearest(times: Floats, wanted: Floats) -> NDArray[np.int64]:
    """Return the samples (F,) nearest to times (F,), both ascending."""
    after = np.searchsorted(times, wanted).clip(1, times.size - 1)
    return np.asarray(after - (wanted - times[after - 1] < times[after] - wanted))


def _exaggeration(run: TowerRun) -> float:
    """Return the factor with one digit that draws the largest deformation large enough.

    Raise RequestError for a run in which nothing is deformed.
    """
    most = float(run.deformations.max())
    if not most > 0.0:
        raise RequestError("film: no contact presses in this run, there is nothing to show")
    factor = _WIDEST * min(run.tower.each("diameter")) / most
    digit = 10.0 ** math.floor(math.log10(factor))
    return digit * math.floor(factor / digit)


_COLOURS = colormaps["Blues"]
"""From light to dark, so that it reads in grey: no force is nearly white."""


class TowerShock(Scene):
    """Draws the frames of a tower; depth runs down, the same in both panels."""

    height = 690

    def __init__(self, motion: RowMotion) -> None:
        tower = motion.run.tower
        self.motion, self.frames = motion, motion.time.size
        self.title = f"Tower of {tower.particles} particles, {tower.law} law"
        self._factor, self._unit = force_scale(float(motion.force.max()))
        self._scale = Normalize(0.0, float(motion.force.max()) * self._factor)
        self._diameter = tower.each("diameter")[0]
        super().__init__()

    def subtitle(self) -> str:
        """Return law, solver, parameters and scale."""
        run, factor = self.motion.run, self.motion.exaggeration
        case = run.tower
        provenance = run.provenance
        name = (
            f"{provenance.engine} {provenance.engine_version}"
            if provenance
            else f"{run.solver} solver"
        )
        drawn = "displacements" if case.law == "overlap" else "displacements and deformations"
        return (
            f"{case.law} law, {name}, k = {power(case.each('stiffness')[0])} N/m, "
            f"m = {case.each('mass')[0]:.4g} kg, {case.speed:g} m/s, g = {case.gravity:g} m/s², "
            f"{case.base} base\n"
            f"{drawn} drawn {factor:g} times as large; orange: contacts that press; "
            f"t0 = {1e3 * case.contact_time:.4g} ms"
        )

    def clock(self, frame: int) -> str:
        """Return the time."""
        time = self.motion.time_over_t0[frame]
        return f"t = {round(float(time), 2) + 0.0:.2f} t0"

    @property
    def poster_frame(self) -> int:
        """Return the frame in which the shock is at the base; the largest force without one."""
        force = self.motion.force
        at_base = (force.argmax(axis=1) == force.shape[1] - 1) & (force[:, -1] > 0.0)
        if force.shape[1] == 1 or not at_base.any():
            return int(force.max(axis=1).argmax())
        return int(at_base.argmax())

    def build(self, figure: Figure) -> list[Artist]:
        """Draw the tower, the forces of its contacts in time, and the chain of its grain."""
        bottom, tall, particles = 132, 465, self.motion.run.tower.particles
        highest = self.motion.drawn_centres - self.motion.drawn_widths / 2
        top = max(float(highest.min()) / self._diameter, -2.0) - 0.1
        width = min(max(88.0, 1.15 * tall / (particles - 0.3 - top)), 300.0)
        x0, x1 = 118 + width, 760.0
        tower = self.axes(figure, 88, bottom, width, tall)
        field = figure.add_axes(
            (x0 / 880, bottom / self.height, (x1 - x0) / 880, tall / self.height),
            sharey=tower,
        )
        chain = figure.add_axes(
            (x0 / 880, 52 / self.height, (x1 - x0) / 880, 62 / self.height), sharex=field
        )
        self._tower(tower, top)
        self._field(figure, field, bottom, tall)
        contacts = significant_contacts(self.motion.run)
        chain.step(self.motion.run.time_over_t0, contacts, where="post", color=RED, lw=1.3)
        label(chain, "time (t0)", "contacts of\nthe grain")
        chain.yaxis.label.set_fontsize(9)
        chain.set_ylim(-0.3, contacts.max() + 0.5)
        chain.yaxis.set_major_locator(MaxNLocator(3, integer=True))
        self._cursors = [axes.axvline(0, color=BLACK, lw=1) for axes in (field, chain)]
        return [*self._shapes, self._bars, self._future, *self._cursors]

    def _tower(self, axes: Axes, top: float) -> None:
        particles = self.motion.run.tower.particles
        bottom = particles - 0.3
        box = axes.get_window_extent()
        half = (bottom - top) * box.width / box.height / 2
        axes.set(xlim=(-half, half), ylim=(bottom, top), xticks=[])
        axes.set_ylabel("particle")
        places = _ticks(particles)
        axes.set_yticks(places, ["grain", *(str(place + 1) for place in places[1:])])
        axes.grid(visible=False)
        axes.spines[["left", "bottom"]].set_visible(False)
        axes.tick_params(left=False)
        if self.motion.run.tower.base == "fixed":
            axes.axhspan(particles - 0.5, bottom, color="#777777")
        widths = np.array(self.motion.run.tower.each("diameter")) / self._diameter
        self._shapes = [Ellipse((0, 0), wide, wide, ec="#444444", lw=0.9) for wide in widths]
        for shape in self._shapes:
            axes.add_patch(shape)
        self._bars = LineCollection([], colors=[RED], linewidths=[2.6])
        axes.add_collection(self._bars, autolim=False)

    def _field(self, figure: Figure, axes: Axes, bottom: float, tall: float) -> None:
        time, n = self.motion.time_over_t0, self.motion.run.tower.height
        edges = np.append(time, 2 * time[-1] - time[-2]) - (time[1] - time[0]) / 2
        drawn = axes.pcolormesh(
            edges, np.arange(n + 1.0), self.motion.force.T * self._factor,
            cmap=_COLOURS, norm=self._scale, rasterized=True,
        )  # fmt: skip
        axes.set(xlim=(time[0], time[-1]))
        axes.grid(visible=False)
        axes.tick_params(labelbottom=False, left=False, labelleft=False)
        axes.spines["left"].set_visible(False)
        bar = figure.colorbar(drawn, cax=self.axes(figure, 782, bottom, 16, tall))
        bar.set_label(f"contact force ({self._unit})")
        bar.ax.grid(visible=False)
        self._future = Rectangle((0, 0), 2 * time[-1] - time[0], n, color="white", lw=0)
        axes.add_patch(self._future)

    def show(self, frame: int) -> None:
        """Put particles and contacts where they are at a frame, and hide what comes later."""
        motion = self.motion
        centres = motion.drawn_centres[frame] / self._diameter
        widths = motion.drawn_widths[frame] / self._diameter
        force = np.pad(motion.force[frame] * self._factor, 1)
        colours = _COLOURS(self._scale(np.maximum(force[:-1], force[1:])))
        for shape, y, width, colour in zip(self._shapes, centres, widths, colours, strict=True):
            shape.set_center((0.0, y))
            shape.set_height(width)
            shape.set_facecolor(colour)
        pressing = motion.force[frame] > SIGNIFICANT_FORCE * motion.force.max()
        faces = ((centres + widths / 2)[:-1] + (centres - widths / 2)[1:])[pressing] / 2
        self._bars.set_segments([[(-0.5, y), (0.5, y)] for y in faces])
        now = float(motion.time_over_t0[frame])
        self._future.set_x(now)
        for cursor in self._cursors:
            cursor.set_xdata([now, now])


def _ticks(particles: int) -> list[int]:
    """Return the particles that are named, from 0, the grain: the last, some round between."""
    most = 6
    apart = next(
        n for n in (1, 2, 5, 10, 20, 50, 100, 200, 500, particles) if particles / n <= most
    )
    between = range(apart - 1, particles - 1, apart)
    return [0, *(n for n in between if n > 0 and particles - 1 - n >= 0.6 * apart), particles - 1]
