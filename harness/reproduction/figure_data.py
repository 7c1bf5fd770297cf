"""The data of the source's figures over height, speed and time, recomputed, and whether each holds.

Figures 1, 4, 6, 7, 10, 11, 13, 15 and 16.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.cases.incline.runs import run_inclines
from harness.cases.incline.system import Incline, InclineRun, Motion
from harness.cases.tower.impulse import READINGS, angle_from_impulse_ratio, energy_scaling_angles
from harness.cases.tower.run import tower
from harness.cases.tower.verification import PAIR, PARTED, Curve, error_over_stiffness
from harness.comparison.convergence import slope_order
from harness.engines.contract import Engine
from harness.errors import EngineError, RequestError
from harness.observables.reference import PEYNEAU_ROUX, Trajectory
from harness.observables.tower import (
    SEARCH,
    TowerRun,
    contact_changes,
    impulse_until,
    structure_end,
    turnaround,
)
from harness.parameters.tower import LAWS, Law, Tower
from harness.reproduction.claims import Fact, Statement, claim_of_facts, untestable
from harness.theory.incline import LARGEST_HEIGHT, critical_angle

STIFFNESSES = [10.0**exponent for exponent in np.arange(2.0, 7.5, 0.5)]
"""[N/m] two decades either side of what the source's claim names, and its runs."""

CLAIMED_ERROR, CLAIMED_STIFFNESS = 0.005, 1e4

FALLS = -0.01
"""Power of the stiffness below which an error falls; at it, by a tenth over ten decades."""

FIXED_STEP = "RK4, one step, 1e-4 s"
SCALED_STEP = "RK4, 50 steps per contact time"
SHRINKING_STEP = "RK4, step that shrinks as 1/k, 1e-5 s at 1e5 N/m"
GRAVITY = "exact, gravity on, but left out of the prediction"


def two_and_three_particles() -> tuple[tuple[TowerRun, ...], Statement]:
    """Run the source's collisions and judge what it reads off them."""
    two, three = runs = tuple(
        tower(PAIR.replace(height=n), solver="exact", duration=PARTED, profiles=True)
        for n in (1, 2)
    )
    joins = next(time for time, contacts in contact_changes(three) if contacts == 2)
    deformations = three.deformations / three.deformations.max()
    before = three.time_over_t0 < joins
    soon = int(np.searchsorted(three.time_over_t0, joins + 0.01))
    more, stored = (
        100 * (float(of_three.max() / of_two.max()) - 1)
        for of_two, of_three in (
            [run.deformations.sum(axis=1) for run in runs],
            [run.elastic_energy for run in runs],
        )
    )
    return runs, claim_of_facts(
        "fig-6",
        speed=two.tower.speed,
        final=float(abs(two.final_velocity[0])),
        back=three.final_velocity[0],
        joins=joins,
        apart=float(np.abs(deformations[before, 0] - deformations[before, 1]).max()),
        soon=deformations[soon],
        more=more,
        stored=stored,
    )


def error_against_stiffness() -> tuple[Mapping[str, Curve], Statement]:
    """Measure the error of the peak deformation over k, by rules for the step, and judge its trend.

    The source does not say how it chose the step. The error of a prediction without gravity
    for a run with it, which does fall, is drawn as well.
    """
    steps = {
        SCALED_STEP: lambda _: 50.0,
        FIXED_STEP: lambda case: case.contact_period / 1e-4,
        SHRINKING_STEP: lambda case: case.contact_period / (1e-5 * 1e5 / case.each("stiffness")[0]),
    }
    curves = {name: error_over_stiffness(STIFFNESSES, rule) for name, rule in steps.items()}
    curves[GRAVITY] = STIFFNESSES, [_gravity_left_out(k) for k in STIFFNESSES]
    fits = {name: slope_order(*curve) for name, curve in curves.items()}
    powers = {name: f"{slope:.2f}".replace("-0.00", "0.00") for name, (slope, _) in fits.items()}
    falls = {name: high < FALLS for name, (_, (_, high)) in fits.items()}
    errors = {name: float(np.interp(CLAIMED_STIFFNESS, *curve)) for name, curve in curves.items()}
    facts = []
    for name in (SCALED_STEP, FIXED_STEP):
        facts.append((falls[name], f"the error goes as k^{powers[name]} ({name})"))
        small = errors[name] < CLAIMED_ERROR
        facts.append((small, f"at 1e4 N/m it is {100 * errors[name]:.2g} % ({name})"))
    others = [
        f"{name} (k^{powers[name]}, {100 * errors[name]:.2g} % at 1e4 N/m)"
        for name in (SHRINKING_STEP, GRAVITY)
        if falls[name]
    ]
    return curves, claim_of_facts(
        "fig-7",
        facts,
        holds=all(held for held, _ in facts[:2]) or all(held for held, _ in facts[2:]),
        remark=f"What falls with k: {'; '.join(others)}."
        if others
        else "No other reading falls with k.",
    )


def _gravity_left_out(stiffness: float) -> float:
    """Return by how much gravity deepens the peak of a grain on a fixed particle, relative."""
    case = Tower(height=1, stiffness=stiffness)
    run = tower(case, solver="exact", duration=1.0)
    predicted = case.speed * math.sqrt(1.0 / stiffness)
    return float(run.compression.max()) / predicted - 1.0


HALVED = (0.4, 0.6)
"""What "nearly halve" may mean for alpha on the plateau."""

FLAT = 0.01
"""Of alpha, and of the angle over its first: what a figure shows of a plateau or a rise."""

PUBLISHED = f"{PEYNEAU_ROUX.value:g} +- {PEYNEAU_ROUX.uncertainty:g} deg"
_LOWEST = PEYNEAU_ROUX.value - PEYNEAU_ROUX.uncertainty


def thin_layers() -> Statement:
    """Return the row of the angles that others measured, whose points are not published."""
    published = f"the published angle, {PUBLISHED} ({PEYNEAU_ROUX.who})."
    return untestable("fig-1", computed=f"Nothing was measured here: drawn is {published}")


def impulse_ratio(frame: pd.DataFrame) -> Statement:
    """Judge alpha(n) of the source's six runs."""
    runs = list(curves(frame, "impulse_ratio"))
    low, high = (pick(run.plateau for run in runs) for pick in (min, max))
    halved = low > HALVED[0] and high < HALVED[1]
    return _row("fig-10", runs, "", [(halved, f"the plateau is {low:.3f} to {high:.3f}")])


def critical_angles(frame: pd.DataFrame) -> Statement:
    """Judge theta_c(n) of the six runs and say what the source's other formula makes of it."""
    runs = list(curves(frame, "critical_angle_lost_deg"))
    plateaus, other = (
        [pick(run.plateau for run in some) for pick in (min, max)]
        for some in (runs, list(curves(frame, "critical_angle_kept_deg")))
    )
    return _row(
        "fig-11",
        runs,
        " deg",
        first=runs[0].values[0],
        plateaus=plateaus,
        reaches="below" if plateaus[-1] < _LOWEST else "reaching",
        published=PUBLISHED,
        other=other,
    )


def energy_scaling() -> tuple[pd.DataFrame, Statement]:
    """Return the angles of alpha = 1/sqrt(n), and whether they fall without an asymptote."""
    scaling = energy_scaling_angles()
    angles = scaling["critical_angle_lost_deg"].to_numpy()
    below = scaling["height"][angles < _LOWEST]
    remark = (
        f"It stays above {_LOWEST:.2f} deg, the published angle less its uncertainty, throughout."
    )
    if len(below):
        remark = (
            f"It is below the published {PUBLISHED} from n = {below.iloc[0]} on, long before ten."
        )
    return scaling, claim_of_facts("fig-13", angles=angles, remark=remark)


def _row(
    key: str, runs: list[HeightCurve], unit: str, others: list[Fact] | None = None, **numbers: Any
) -> Statement:
    falling, rising = [r for r in runs if r.falls], [r for r in runs if not r.falls]
    facts: list[Fact] = []
    if falling:
        first, last = (pick(run.level_from for run in falling) for pick in (min, max))
        heights = f"{first} to {last}" if last != first else f"{first}"
        text = f"{len(falling)} of {len(runs)} runs fall and are level from n = {heights} on"
        facts.append((last <= LARGEST_HEIGHT, f"{text} (source: about {LARGEST_HEIGHT})"))
    facts += [(False, _rising(run, falling, unit)) for run in rising]
    facts += others or []
    return claim_of_facts(
        key,
        facts,
        corrected_holds=bool(falling) and sum(not held for held, _ in facts) == len(rising),
        correction=f"not for {'; '.join(run.name for run in rising)}",
        **numbers,
    )


def _rising(run: HeightCurve, falling: list[HeightCurve], unit: str) -> str:
    """Return how far a run rises, where, and how long its window is there."""
    row = int(run.rises.argmax())
    others = [other.windows[row] for other in falling]
    range_of_others = f" (others {min(others):.1f} to {max(others):.1f})" if others else ""
    return (
        f"{run.name}: rises by {run.rise:.2f}{unit} on its way, to {run.values[row]:.2f}{unit} at "
        f"n = {run.heights[row]}, where its window is {run.windows[row]:.1f} t0{range_of_others}; "
        f"level from {run.level_from} on"
    )


class HeightCurve(NamedTuple):
    """One run over height: plateau at the tallest, and what disturbs the way to it."""

    name: str
    heights: NDArray[np.int64]
    values: NDArray[np.float64]
    windows: NDArray[np.float64]  # [t0]

    @property
    def plateau(self) -> float:
        """Return the value of the tallest tower."""
        return float(self.values[-1])

    @property
    def level_from(self) -> int:
        """Return the first height from which on all values are within FLAT of the plateau."""
        off = np.flatnonzero(np.abs(self.values - self.values[-1]) > FLAT * self.values[0])
        return int(self.heights[off[-1] + 1]) if off.size else int(self.heights[0])

    @property
    def rises(self) -> NDArray[np.float64]:
        """Return how far each value stands above that of any smaller height."""
        return np.asarray(self.values - np.minimum.accumulate(self.values))

    @property
    def rise(self) -> float:
        """Return the largest rise above any smaller height's value."""
        return float(self.rises.max())

    @property
    def falls(self) -> bool:
        """Return whether it ends lower than it begins and nowhere rises by more than FLAT."""
        limit = FLAT * float(self.values[0])
        return self.rise <= limit and self.plateau < self.values[0] - limit


def curves(frame: pd.DataFrame, column: str) -> Iterator[HeightCurve]:
    """Yield the source's law's runs of a table of impulses, each against height."""
    part = frame[frame["law"] == Tower().law]
    for (k, v), run in part.groupby(["stiffness_N_per_m", "speed_m_per_s"], sort=False):
        ordered = run.sort_values("height")
        height, value, window = (ordered[n].to_numpy() for n in ("height", column, "window_s"))
        t0 = Tower(stiffness=k, speed=v).contact_time
        yield HeightCurve(
            f"k = {k:.0e} N/m, {v:g} m/s".replace("e+0", "e"), height, value, window / t0
        )


HEIGHTS = range(1, 7)
"""Two to seven particles."""

LITERAL, LOOSER = "all n contacts", "two contacts or more"
"""What the chain must have held before it swings to one: the source's words, and a looser one."""

_LEAST = {LITERAL: None, LOOSER: 2}


class WindowChoice(NamedTuple):
    """A tower with the time of its largest compression and, where it exists, the structure window.

    Times in t0; ``structure`` is NaN where the window does not exist.
    """

    run: TowerRun
    largest_compression: float
    structure: float


def structure_window() -> tuple[pd.DataFrame, Statement]:
    """Return the structure window's ends, impulse ratios and angles, by law and reading.

    Columns law, held (the reading), height, window_t0, impulse_ratio and the
    angles of both readings of the shock; NaN where the window does not exist
    within 3 t0.
    """
    frame = pd.DataFrame([row for law in LAWS for row in _of_law(law)])
    exists = frame.dropna()
    heights = {
        run: [int(n) for n in part["height"]] for run, part in exists.groupby(["law", "held"])
    }
    law = Tower().law
    angles = {held: exists[(exists["law"] == law) & (exists["held"] == held)] for held in _LEAST}
    ends = [angles[held].set_index("height")["window_t0"] for held in _LEAST]
    both = ends[0].index.intersection(ends[1].index)
    return frame, claim_of_facts(
        "fig-15",
        literal=heights[law, LITERAL],
        looser=heights[law, LOOSER],
        overlap=[heights["overlap", held] for held in _LEAST],
        every=list(HEIGHTS),
        listed=_listed,
        angles=[angles[held]["critical_angle_lost_deg"].to_numpy() for held in _LEAST],
        same="the same" if (ends[0][both] == ends[1][both]).all() else "not the same",
    )


def _of_law(law: Law) -> Iterator[dict[str, object]]:
    runs = {n: tower(Tower(height=n, law=law), solver="exact", profiles=True) for n in HEIGHTS}
    for held, least in _LEAST.items():
        single = impulse_until(runs[1], _structure(runs[1], least))
        for height, run in runs.items():
            end = _structure(run, least)
            ratio = impulse_until(run, end) / single if math.isfinite(end) else math.nan
            yield {
                "law": law,
                "held": held,
                "height": height,
                "window_t0": end / run.tower.contact_time,
                "impulse_ratio": ratio,
            } | {
                f"critical_angle_{reading}_deg": angle_from_impulse_ratio(ratio, reading)
                for reading in READINGS
            }


def window_selection() -> tuple[tuple[WindowChoice, ...], Statement]:
    """Return three and four particles with their largest compression, and what it says.

    The source's text names three particles, the caption of its figure four.
    """
    choices = tuple(_choice(height) for height in (2, 3))
    facts = []
    for choice in choices:
        at = choice.largest_compression
        text = f"{choice.run.tower.particles} particles are compressed most at {at:.3f} t0"
        text += f", which makes a window of {2 * at:.3f} t0"
        if math.isfinite(choice.structure):
            text += f" (the contacts' window: {choice.structure:.3f})"
        facts.append((0 < at < SEARCH, text))
    forces = [float(c.run.time_over_t0[int(c.run.grain_force.argmax())]) for c in choices]
    return choices, claim_of_facts("fig-16", facts, forces=forces)


def _choice(height: int) -> WindowChoice:
    run = tower(Tower(height=height), solver="exact", profiles=True)
    t0 = run.tower.contact_time
    return WindowChoice(run, turnaround(run) / t0, _structure(run, None) / t0)


def _structure(run: TowerRun, least: int | None) -> float:
    """Return the end of the structure window [s], NaN where there is none."""
    try:
        return structure_end(run, least)
    except RequestError:
        return math.nan


def _listed(heights: list[int]) -> str:
    if len(heights) > 2 and heights == list(range(heights[0], heights[-1] + 1)):
        return f"{heights[0]} to {heights[-1]}"
    return " and ".join(str(n) for n in heights) or "none"


ANGLES_DEG = (10.20, 10.22)
"""A hundredth of a degree either side of the source's 10.21 deg: trapped, and moving."""

_EVERY = 200  # steps between samples: 0.013 s, as the paths in MFiX's scheme


@dataclass(frozen=True)
class VelocitySeries:
    """The speed of one grain near the critical angle, and whether it kept moving."""

    code: str
    steps: float  # in one contact time of the code
    angle_deg: float
    moving: bool
    path: Trajectory

    @property
    def label(self) -> str:
        """Return code and steps: ``LAMMPS, 50 steps``."""
        return f"{self.code}, {self.steps:g} steps"

    @property
    def fact(self) -> Fact:
        """Return whether it moves on above the closed form, or stops below it, in words."""
        fate = "moves on" if self.moving else "is trapped"
        text = (
            f"{self.label}, at {self.angle_deg:.2f} deg {fate} "
            f"({np.ptp(self.path.x_m):.0f} d in {self.path.time_s[-1]:.0f} s)"
        )
        return self.moving == (self.angle_deg > critical_angle()), text


def velocity_series(
    engine: Engine | None, paths: Mapping[tuple[int, float], Trajectory]
) -> tuple[tuple[VelocitySeries, ...], Statement]:
    """Run the source's contact in ``engine`` and compare with ``paths`` in MFiX's scheme.

    Without an engine, or with one that fails, these stand alone and the statement says why it
    cannot be tested. ``paths`` are by MFiX's steps per contact time and the angle [deg].
    """
    others = as_series(paths)
    try:
        if engine is None:
            raise EngineError("no engine was given")
        from_engine = _engine_series(engine, others)
    except EngineError as error:
        return tuple(others), untestable("fig-4", f"{error}", computed="the engine did not run")
    return (*from_engine, *others), judged(from_engine, others)


def as_series(motions: Mapping[tuple[int, float], Trajectory]) -> list[VelocitySeries]:
    """Return paths in MFiX's scheme as velocity series, finest step and smallest angle first."""
    return [
        VelocitySeries("MFiX's scheme", steps, angle, not turns_back(path), path)
        for (steps, angle), path in sorted(motions.items(), key=lambda m: (-m[0][0], m[0][1]))
    ]


def turns_back(path: Trajectory) -> bool:
    """Return whether the grain ever moved uphill along the row.

    Without friction, a grain that turns back in a well has not the energy for the
    crest and stays. The small rebound in a well turns its velocity by less than
    the 60 deg left until it points uphill.
    """
    return bool((path.vx_m_per_s < 0).any())


def _engine_series(engine: Engine, others: Sequence[VelocitySeries]) -> list[VelocitySeries]:
    """Run both angles for as many wells as the grain in MFiX's scheme that went farthest."""
    wells = max((math.ceil(s.path.x_m[-1] - s.path.x_m[0]) for s in others), default=20)
    cases = [Incline(angle=angle, wells=wells) for angle in ANGLES_DEG]
    return [
        VelocitySeries(
            run.provenance.engine.upper(),
            run.case.steps_per_contact,
            run.case.angle,
            run.motion is not Motion.TRAPPED,
            path,
        )
        for run, path in sampled(engine, cases, _EVERY)
    ]


def judged(from_engine: Sequence[VelocitySeries], others: Sequence[VelocitySeries]) -> Statement:
    """Return the row: which runs stop below the closed form and move above it."""
    coarse = min((series.steps for series in others), default=math.nan)
    return claim_of_facts(
        "fig-4",
        [series.fact for series in (*from_engine, *others)],
        corrected_holds=all(series.fact[0] for series in from_engine)
        and all(series.fact[0] or series.steps == coarse for series in others),
        coarse=coarse,
        closed=critical_angle(),
    )


def sampled(
    engine: Engine, cases: Sequence[Incline], every: int
) -> list[tuple[InclineRun, Trajectory]]:
    """Run cases in steady motion; return each with its path, sampled every so many steps.

    Raise the first EngineError.
    """
    sampled_runs = []
    for run in run_inclines(engine, cases, "steady", every=every):
        if isinstance(run, EngineError):
            raise run
        sampled_runs.append((run, run.path))
    return sampled_runs
