"""The motions of the movies: computed, as frames at equal times, as dumps.

Motions as frames at equal times, ready to be drawn or dumped.

Motions as LAMMPS text dumps, the format that OVITO and LAMMPS's read_dump open.

One snapshot a frame; the timestep counts frames, ``ITEM: TIME`` has the time [s].
OVITO takes ``radius``, ``shapex shapey shapez`` (diameters, it draws ellipsoids),
velocities and forces for what they are; columns with ``v_`` come in by their name.

The motions of the source's supplement, and two more: rows that collide, grains on the incline.
"""

from __future__ import annotations

import gzip
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.cases.incline.film import InclineMotion, incline_sentence
from harness.cases.incline.system import Incline
from harness.cases.tower.film import RowMotion
from harness.cases.tower.film import row_motion as frames_of
from harness.cases.tower.run import tower
from harness.cases.tower.verification import PAIR
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.tower import TowerRun
from harness.observables.windows import SIGNIFICANT_FORCE
from harness.parameters.tower import Tower
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
