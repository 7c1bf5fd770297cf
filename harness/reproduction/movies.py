"""The movies of the source's supplement, and two more: looping GIFs, and dumps for OVITO.

A motion is run, cut into frames at equal times, drawn, and written as a LAMMPS text dump, which
OVITO and LAMMPS's read_dump open. One snapshot a frame; the timestep counts frames, ``ITEM: TIME``
has the time [s]. OVITO takes ``radius``, ``shapex shapey shapez`` (diameters, it draws
ellipsoids), velocities and forces for what they are; columns with ``v_`` come in by their name.
"""

from __future__ import annotations

import gzip
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse
from numpy.typing import ArrayLike, NDArray

from harness.cases.incline.film import InclineGrain, InclineMotion, incline_sentence
from harness.cases.incline.system import Incline
from harness.cases.tower.film import RowMotion, TowerShock
from harness.cases.tower.film import row_motion as frames_of
from harness.cases.tower.run import tower
from harness.cases.tower.verification import PAIR
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.tower import SIGNIFICANT_FORCE, TowerRun
from harness.parameters.tower import Tower
from harness.report.film import FRAME_MS, INK, Scene, Traces, gif, png
from harness.report.style import COLOURS, RED, STYLES, label, power
from harness.reproduction.figure_data import ANGLES_DEG, sampled
from harness.workflows.progress import Progress, silent

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Motions:
    """All motions; what no engine could run is None, and ``missing`` says why."""

    pair: RowMotion
    triple: RowMotion
    tower: RowMotion
    incline: InclineMotion | None = None
    missing: str = ""


ROW_COLUMNS = (
    "id", "type", "x", "y", "z", "radius", "shapex", "shapey", "shapez",
    "vx", "vy", "vz", "fx", "fy", "fz", "v_displacement", "v_deformation", "v_contact_force",
)  # fmt: skip
INCLINE_COLUMNS = ("id", "type", "mol", "x", "y", "z", "radius", "vx", "vy", "vz")
_LANE = 3.0  # diameters between the two rows of the incline
_WHOLE = {"id", "type", "mol"}


def row_dump(motion: RowMotion) -> bytes:
    """Return a row as a dump, along x, or down -z where gravity acts.

    Type 1 is the grain, 2 the others, 3 a fixed base. Positions and shapes are
    exaggerated as in the movie, or nothing would be seen to move. All else is true to
    the run: velocities, net contact forces, ``v_displacement`` and
    ``v_deformation`` [m], and ``v_contact_force`` [N] with the next particle.
    """
    tower, n = motion.run.tower, motion.run.tower.particles
    down = tower.gravity > 0
    sign, axis = (-1.0, "z") if down else (1.0, "x")
    diameter = np.array(tower.each("diameter"))
    centres, widths = motion.drawn_centres, motion.drawn_widths
    force = np.pad(motion.force, ((0, 0), (1, 1)))
    columns: dict[str, ArrayLike] = dict.fromkeys(ROW_COLUMNS, 0.0)
    columns |= dict.fromkeys(("shapex", "shapey", "shapez"), diameter)
    columns |= {
        "id": np.arange(1, n + 1),
        "type": [1.0] + [2.0] * (n - 2) + [3.0 if tower.base == "fixed" else 2.0],
        "radius": diameter / 2,
        f"shape{axis}": widths,
        axis: sign * centres,
        f"v{axis}": sign * motion.velocity,
        f"f{axis}": sign * (force[:, :-1] - force[:, 1:]),
        "v_displacement": motion.displacement,
        "v_deformation": motion.deformation,
        "v_contact_force": force[:, 1:],
    }
    low, high = float((centres - widths).min()), float((centres + widths).max())
    along, across = ((-high, -low) if down else (low, high)), (-1.0, 1.0)
    bounds = (across, across, along) if down else (along, across, across)
    return _zipped(motion.time, n, columns, bounds)


def incline_dump(motion: InclineMotion) -> bytes:
    """Return both inclines as one dump, true to the runs, rows along x and normal to y.

    Molecule 1 is the row below the critical angle, 2 the one above it, 3 diameters
    aside; type 1 are fixed spheres, 2 is the grain. Gravity is tilted.
    """
    d = motion.runs[0].case.diameter
    paths = [motion.path(run) for run in motion.runs]
    spheres = int(max(float(path.x_m.max()) for path in paths) / d) + 2
    lane = np.repeat([0, 1], spheres + 1)  # the grain is the last of each
    grains = [spheres, 2 * spheres + 1]
    columns = {name: np.zeros((motion.time.size, lane.size)) for name in INCLINE_COLUMNS}
    columns["id"][:] = np.arange(1, lane.size + 1)
    columns["type"][:] = np.isin(np.arange(lane.size), grains) + 1
    columns["mol"][:] = lane + 1
    columns["x"][:] = d * (np.arange(lane.size) % (spheres + 1))
    columns["y"][:] = _LANE * d * (1 - lane)
    columns["radius"][:] = d / 2
    for grain, path in zip(grains, paths, strict=True):
        columns["x"][:, grain] = path.x_m
        columns["y"][:, grain] += path.y_m
        columns["vx"][:, grain] = path.vx_m_per_s
        columns["vy"][:, grain] = path.vy_m_per_s
    bounds = ((-d, spheres * d), (-d, (_LANE + 2) * d), (-d, d))
    return _zipped(motion.time, lane.size, columns, bounds)


def _zipped(
    times: Floats,
    atoms: int,
    columns: Mapping[str, ArrayLike],
    bounds: Sequence[tuple[float, float]],
) -> bytes:
    """Return snapshots of ``columns``, each (frames, atoms), as a gzipped text dump.

    The same bytes each time, on every machine.
    """
    shape = (times.size, atoms)
    frames = np.stack(
        [_without_round_off(np.broadcast_to(values, shape)) for values in columns.values()], axis=-1
    )
    # units once, at the top: OVITO takes a second one for the end of the file
    parts = ["ITEM: UNITS\nsi\n"]
    box = "\n".join(f"{low:.9g} {high:.9g}" for low, high in bounds)
    form = " ".join("%d" if name in _WHOLE else "%.7g" for name in columns)
    for step, (time, table) in enumerate(zip(times, frames, strict=True)):
        rows = "\n".join(form % tuple(row) for row in table)
        parts.append(
            f"ITEM: TIME\n{time:.9g}\nITEM: TIMESTEP\n{step}\n"
            f"ITEM: NUMBER OF ATOMS\n{atoms}\nITEM: BOX BOUNDS ff ff ff\n{box}\n"
            f"ITEM: ATOMS {' '.join(columns)}\n{rows}\n"
        )
    return gzip.compress("".join(parts).encode("ascii"), 9, mtime=0)


def _without_round_off(values: Floats) -> Floats:
    """Return numbers to ten digits of the largest.

    What is left of a difference of larger numbers would be another on another machine.
    """
    largest = float(np.abs(values).max())
    digits = 10 - math.floor(math.log10(largest)) if largest else 0
    return np.round(values, digits) + 0.0  # no minus before a zero


_SAMPLES_PER_FRAME = 40
_INCLINE_FRAMES = 150


def motions(engine: Engine | None, progress: Progress = silent) -> Motions:
    """Run the free pair, the free triple, the tower of 20 and both inclines.

    Without an engine, or where it fails, the inclines are missing, with the reason.
    """
    progress("movies", 0, 4)
    pair = row_motion(
        "two-particles", "Two deformable particles collide", PAIR,
        lead=0.35, duration=1.15, frames_per_t0=44,
    )  # fmt: skip
    progress("movies", 1, 4)
    triple = row_motion(
        "three-particles", "A deformable particle runs into two at rest", PAIR.replace(height=2),
        lead=0.35, duration=1.75, frames_per_t0=44,
    )  # fmt: skip
    progress("movies", 2, 4)
    shock = row_motion(
        "shock-down-the-tower", "A shock runs down a tower of 20", Tower(height=19),
        lead=0.5, duration=9.5, frames_per_t0=14,
    )  # fmt: skip
    progress("movies", 3, 4)
    incline, missing = _incline(engine)
    progress("movies", 4, 4)
    return Motions(pair, triple, shock, incline, missing)


def row_motion(
    name: str, title: str, case: Tower, *, lead: float, duration: float, frames_per_t0: int
) -> RowMotion:
    """Run ``case`` exactly from ``-lead`` to ``duration`` [t0] and return its frames."""
    after = round(duration * frames_per_t0)
    run = tower(
        case,
        solver="exact",
        duration=after / frames_per_t0,
        samples=after * _SAMPLES_PER_FRAME,
        profiles=True,
    )
    sentence = SENTENCES[name](run)
    return frames_of(run, name, title, sentence, lead=lead, frames_per_t0=frames_per_t0)


def _incline(engine: Engine | None) -> tuple[InclineMotion | None, str]:
    """Return the grain below and above the critical angle, or the reason why not."""
    if engine is None:
        return None, "no engine"
    cases = [Incline(angle=angle) for angle in ANGLES_DEG]
    try:
        below, above = (run for run, _ in sampled(engine, cases, 50))
    except EngineError as error:
        return None, f"{error.kind}: {error}"
    return (
        InclineMotion(
            name="below-and-above-the-critical-angle",
            title="The grain over the bumps, just below and just above the critical angle",
            sentence=incline_sentence(below, above),
            runs=(below, above),
            time=np.linspace(0.0, max(below.time_s, above.time_s), _INCLINE_FRAMES),
        ),
        "",
    )


def contact_changes(run: TowerRun) -> list[tuple[float, tuple[int, ...]]]:
    """Return each change of contacts: the time [t0] and the contacts that press from then on.

    Contacts count from 1, the grain's. Needs profiles; the times are as good as the samples.
    """
    forces = run.known_profiles.forces
    pressing = forces > SIGNIFICANT_FORCE * forces.max()
    rows = 1 + np.flatnonzero((pressing[1:] != pressing[:-1]).any(axis=1))
    return [
        (float(run.time_over_t0[row]), tuple(int(i) + 1 for i in np.flatnonzero(pressing[row])))
        for row in rows
    ]


def pair_sentence(run: TowerRun) -> str:
    """Say how long two particles touch, how much they give, and how fast they part."""
    end, _ = contact_changes(run)[-1]
    return (
        f"They touch for {end:.3f} t0, each shortened by up to {1e3 * run.deformations.max():.2f} "
        f"mm, and part with {_velocities(run)} m/s."
    )


def triple_sentence(run: TowerRun) -> str:
    """Say who touches when, and how fast the three part."""
    names = {(1,): "grain and second", (2,): "second and third", (1, 2): "all three", (): "none"}
    story = [f"{names[c]} from {t:.2f} t0" for t, c in contact_changes(run)[1:]]
    most = [f"{1e3 * most:.2f}" for most in run.deformations.max(axis=0)]
    return (
        f"First grain and second touch; {', '.join(story)}. They are shortened by up to "
        f"{', '.join(most)} mm. "
        f"They part with {_velocities(run)} m/s."
    )


def tower_sentence(run: TowerRun) -> str:
    """Say when the shock is at the base, how many contacts carry it, and how strong it is."""
    forces, n = run.known_profiles.forces, run.tower.height
    at_base = forces.argmax(axis=1) == n - 1
    if not at_base.any():
        return "The shock does not reach the base."
    arrival = int(at_base.argmax())
    carrying = (forces[:arrival] > 0.1 * forces[:arrival].max(axis=1, keepdims=True)).sum(axis=1)
    middle = forces[: arrival + 1, n // 2].max()
    return (
        f"The strongest contact is the last one, {n}, from {run.time_over_t0[arrival]:.2f} t0 on. "
        f"On the way down at most {carrying.max()} contacts at a time carry a tenth of the "
        f"strongest or more. The largest force is {forces[:, 0].max() / 1e3:.2f} kN on the "
        f"grain, {middle / 1e3:.2f} kN in the middle and {forces[:, -1].max() / 1e3:.2f} kN "
        "on the base."
    )


def _velocities(run: TowerRun) -> str:
    # + 0.0: rounding may leave a minus before a zero
    return ", ".join(f"{round(v, 2) + 0.0:.2f}" for v in run.final_velocity)


SENTENCES = {
    "two-particles": pair_sentence,
    "three-particles": triple_sentence,
    "shock-down-the-tower": tower_sentence,
}


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
        leftmost = (motion.drawn_centres - motion.drawn_widths / 2).min()
        right = (motion.drawn_centres + motion.drawn_widths / 2).max()
        box = axes.get_window_extent()
        half = (_TOP - _BOTTOM) * box.width / box.height / 2
        middle = (leftmost + right) / 2
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
                (time, curve, f"particle {i}" if i > 1 else "grain", {"color": colour, "ls": line})
                for i, (curve, colour, line) in enumerate(
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
        tips = centres + 0.42 * velocity / self.motion.run.tower.speed
        visible = np.abs(tips - centres) > 0.02
        ends = np.stack([centres, tips], axis=1)[visible]
        self._arrows.set_segments([[(x, _ARROWS) for x in pair] for pair in ends])
        for marks, chosen in ((self._heads, tips > centres), (self._tails, tips < centres)):
            there = tips[visible & chosen]
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
                gap_text = f"apart\n{1e3 * max(open_by, 0.0):.2f} mm"
                text.set(text=gap_text, color=INK, fontweight="normal")
        self._faces.set_segments(bars)


@dataclass(frozen=True)
class Movie:
    """A movie with its title and caption.

    ``gif`` is the looping movie, ``still`` a PNG of its most telling frame;
    ``dump`` is a gzipped LAMMPS text dump, to be named ``<name>.dump.gz``.
    """

    name: str
    title: str
    caption: str
    gif: bytes
    still: bytes
    dump: bytes


def films(computed: Motions) -> list[Movie]:
    """Return a movie of each motion that there is."""
    movies = [
        _movie(RowCollision(motion), motion, row_dump(motion))
        for motion in (computed.pair, computed.triple)
    ]
    if computed.incline:
        scene = InclineGrain(computed.incline)
        movies.append(_movie(scene, computed.incline, incline_dump(computed.incline)))
    return [*movies, _movie(TowerShock(computed.tower), computed.tower, row_dump(computed.tower))]


def _movie(scene: Scene, motion: RowMotion | InclineMotion, dump: bytes) -> Movie:
    speed = 1e3 * float(motion.time[1] - motion.time[0]) / FRAME_MS
    pace = f"{speed:.2g} times as fast" if speed > 1 else f"{1 / speed:.0f} times slowed down"
    return Movie(
        name=motion.name,
        title=motion.title,
        caption=f"{motion.sentence} Shown {pace}.",
        gif=gif(scene.picture, scene.frames),
        still=png(scene.picture(scene.poster_frame)),
        dump=dump,
    )
