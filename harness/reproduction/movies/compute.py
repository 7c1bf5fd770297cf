"""The motions of the source's supplement, and two more: rows that collide, grains on the incline.

Particles of the rows are drawn by their boundaries. These follow from the centres alone,
by the source's sweeps, and not from the forces that the propagator has at hand.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.parameters import Incline
from harness.cases.tower.run import tower
from harness.chain.sweeps import compressions
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.incline_runs import sampled
from harness.reproduction.movies.frames import InclineMotion, Motions, RowMotion
from harness.reproduction.movies.sentences import (
    incline_sentence,
    pair_sentence,
    tower_sentence,
    triple_sentence,
)
from harness.workflows.progress import Progress, silent

Floats = NDArray[np.float64]

FREE = Tower(height=1, base="free", gravity=0.0)
NEAR_CRITICAL_DEG = (10.20, 10.22)
"""The two angles of the source's velocity figure: trapped and moving."""

STAGE = "movies"
_SAMPLES_PER_FRAME = 40
_WIDEST = 0.32
"""The largest deformation is drawn as about this part of a diameter."""
_INCLINE_FRAMES = 150


def motions(engine: Engine | None, progress: Progress = silent) -> Motions:
    """Run the free pair, the free triple, the tower of 20 and both inclines.

    Without an engine, or where it fails, the inclines are missing, with the reason.
    """
    progress(STAGE, 0, 4)
    pair = row_motion(
        "two-particles", "Two deformable particles collide", FREE,
        lead=0.35, duration=1.15, frames_per_t0=44,
    )  # fmt: skip
    progress(STAGE, 1, 4)
    triple = row_motion(
        "three-particles", "A deformable particle runs into two at rest", FREE.replace(height=2),
        lead=0.35, duration=1.75, frames_per_t0=44,
    )  # fmt: skip
    progress(STAGE, 2, 4)
    shock = row_motion(
        "shock-down-the-tower", "A shock runs down a tower of 20", Tower(height=19),
        lead=0.5, duration=9.5, frames_per_t0=14,
    )  # fmt: skip
    progress(STAGE, 3, 4)
    incline, missing = _incline(engine)
    progress(STAGE, 4, 4)
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
    assert run.profiles is not None
    step = case.contact_time / frames_per_t0
    rows = np.abs(run.time[:, None] - step * np.arange(after + 1)).argmin(axis=0)
    approach = step * np.arange(-before, 0)
    still = np.zeros((before, case.height))
    flight = case.speed * approach + case.gravity * approach**2 / 2
    falling = case.speed + case.gravity * approach
    displacement = np.vstack([np.column_stack([flight, still]), run.profiles.displacements[rows]])
    diameter = case.each("diameter")[0]
    touching = diameter * np.arange(case.particles)
    compression = np.array([compressions(touching + row, diameter) for row in displacement])
    return RowMotion(
        name=name,
        title=title,
        sentence=_SENTENCES[name](run),
        run=run,
        exaggeration=_exaggeration(run),
        time=np.concatenate([approach, run.time[rows]]),
        displacement=displacement,
        velocity=np.vstack([np.column_stack([falling, still]), run.profiles.velocities[rows]]),
        compression=compression,
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
    cases = [Incline(angle=angle) for angle in NEAR_CRITICAL_DEG]
    try:
        below, above = (run for run, _ in sampled(engine, cases, 50))
    except EngineError as error:
        return None, f"{error.kind}: {error}"
    end = max(below.time_s, above.time_s)
    return (
        InclineMotion(
            name="below-and-above-the-critical-angle",
            title="The grain over the bumps, just below and just above the critical angle",
            sentence=incline_sentence(below, above),
            below=below,
            above=above,
            time=np.linspace(0.0, end, _INCLINE_FRAMES),
        ),
        "",
    )


_SENTENCES = {
    "two-particles": pair_sentence,
    "three-particles": triple_sentence,
    "shock-down-the-tower": tower_sentence,
}
