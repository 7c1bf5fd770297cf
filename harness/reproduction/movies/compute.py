"""The motions of the source's supplement, and two more: rows that collide, grains on the incline.

Particles of the rows are drawn by their boundaries. These follow from the centres alone,
by the source's sweeps, and not from the forces that the propagator has at hand.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.tower.chain_evidence import PAIR
from harness.cases.tower.run import tower
from harness.chain.sweeps import compressions
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.significant_contacts import SIGNIFICANT_FORCE
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.figure_data.velocity_series import ANGLES_DEG, sampled
from harness.reproduction.movies.frames import InclineMotion, Motions, RowMotion
from harness.theory.critical_angle import critical_angle
from harness.workflows.progress import Progress, silent

Floats = NDArray[np.float64]

_SAMPLES_PER_FRAME = 40
_WIDEST = 0.32
"""The largest deformation is drawn as about this part of a diameter."""
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
    """Run ``case`` exactly from ``-lead`` to ``duration`` [t0] and return its frames.

    Before 0 the grain flies freely and the others are at rest.
    """
    after, before = round(duration * frames_per_t0), round(lead * frames_per_t0)
    run = tower(
        case,
        solver="exact",
        duration=after / frames_per_t0,
        samples=after * _SAMPLES_PER_FRAME,
        profiles=True,
    )
    kept, step = run.known_profiles, case.contact_time / frames_per_t0
    rows = np.abs(run.time[:, None] - step * np.arange(after + 1)).argmin(axis=0)
    approach = step * np.arange(-before, 0)
    still = np.zeros((before, case.height))
    flight = case.speed * approach + case.gravity * approach**2 / 2
    falling = case.speed + case.gravity * approach
    displacement = np.vstack([np.column_stack([flight, still]), kept.displacements[rows]])
    diameter = case.each("diameter")[0]
    touching = diameter * np.arange(case.particles)
    return RowMotion(
        name=name,
        title=title,
        sentence=SENTENCES[name](run),
        run=run,
        exaggeration=_exaggeration(run),
        time=np.concatenate([approach, run.time[rows]]),
        displacement=displacement,
        velocity=np.vstack([np.column_stack([falling, still]), kept.velocities[rows]]),
        compression=np.array([compressions(touching + row, diameter) for row in displacement]),
    )


def _exaggeration(run: TowerRun) -> float:
    """Return the factor with one digit that draws the largest deformation large enough."""
    factor = _WIDEST * run.tower.each("diameter")[0] / float(run.deformations.max())
    digit = 10.0 ** math.floor(math.log10(factor))
    return digit * math.floor(factor / digit)


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
            below=below,
            above=above,
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


def incline_sentence(below: InclineRun, above: InclineRun) -> str:
    """Say how far the grain comes at either angle."""
    gone = below.path.x_m[-1] / below.case.diameter
    return (
        f"The closed form has the critical angle at {critical_angle():.4f} deg. {_fate(below)}; "
        f"its path ends where it turns back, at {gone:.2f} diameters. {_fate(above)}."
    )


def _fate(run: InclineRun) -> str:
    """Say what became of a grain: ``At 10.20 deg it is trapped after 6 crests (14.8 s)``."""
    words = {"moves_on": "moves on over", "trapped": "is trapped after"}
    fate = words.get(run.motion.value, "is undecided after")
    crests = len(run.crests.time_s)
    return f"At {run.case.angle:.2f} deg it {fate} {crests} crests ({run.time_s:.1f} s)"


def _velocities(run: TowerRun) -> str:
    # + 0.0: rounding may leave a minus before a zero
    return ", ".join(f"{round(v, 2) + 0.0:.2f}" for v in run.final_velocity)


SENTENCES = {
    "two-particles": pair_sentence,
    "three-particles": triple_sentence,
    "shock-down-the-tower": tower_sentence,
}
