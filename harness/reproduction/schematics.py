"""The data of the source's schematics (figures 2, 3, 5) and towers in time (8, 9, 14)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.cases.tower.impulse import HEIGHTS, STIFFNESSES
from harness.cases.tower.run import tower
from harness.observables.tower import TowerRun, contact_changes, grain_alone, significant_contacts
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement, claim_of_facts
from harness.theory import incline
from harness.theory.chain import SHOCK_WITHOUT_REBOUND
from harness.theory.incline import critical_angle

_ROUNDING = 1e-12
"""Of positions near 1 d: what is left of two routes to the same number."""

Points = NDArray[np.float64]

LAYERS = 4
"""Drawn: enough to see a chain, few enough to read."""


class QuartierSystem(NamedTuple):
    """The row and the grain on it, to scale with gravity straight down [d]."""

    angle_deg: float
    spheres: Points  # (S, 2)
    grains: Mapping[str, Points]  # by the source's letters, centres (2,)
    path: Points  # (P, 2) of the grain's centre


class ForceDiagram(NamedTuple):
    """The grain in the well, on one of the two spheres; gravity straight down."""

    name: str
    state: incline.Dynamics
    other: Points  # centre of the second sphere
    velocity_before: Points | None = None  # the shock; None in the first diagram


class LayerDrawing(NamedTuple):
    """A substrate of several layers with a grain in a well of the top one, to scale [d]."""

    name: str
    layers: int
    fixed: Points
    mobile: Points
    grain: Points
    chain: Points  # (L, 2) spheres that touch in a straight line below the grain's contact
    height: float  # of the layers above the fixed row


def quartier() -> tuple[QuartierSystem, Statement]:
    """Return the row at its critical angle, and whether positions give well and gain."""
    angle = critical_angle()
    grains = {"A": incline.crest(1, angle), "B": incline.well(1), "C": incline.crest(2, angle)}
    high = {name: incline.height(at, angle) for name, at in grains.items()}
    depth, gain = high["C"] - high["B"], high["A"] - high["C"]
    off = max(abs(depth - incline.well_depth(angle)), abs(gain - incline.gain_per_crest(angle)))
    system = QuartierSystem(
        angle,
        incline.turned(incline.row(4), angle),
        {name: incline.turned(at, angle) for name, at in grains.items()},
        incline.turned(incline.path(0, 3), angle),
    )
    return system, claim_of_facts(
        "fig-2",
        angle=angle,
        high=high,
        sides=[incline.angle_between(grains["B"] - s, (0, 1)) for s in incline.row(3)[1:]],
        depth=depth,
        gain=gain,
        off=off,
        rounding=_ROUNDING,
    )


def force_diagrams() -> tuple[tuple[ForceDiagram, ...], Statement]:
    """Return the grain before and after the shock in steady motion at the critical angle."""
    angle = critical_angle()
    states = before, after = incline.steady_shock(angle, SHOCK_WITHOUT_REBOUND)
    statement = claim_of_facts(
        "fig-3",
        angle=angle,
        turn=incline.angle_between(before.velocity, after.velocity),
        speed=[float(np.hypot(*s.velocity)) for s in states],
        perpendicular=[abs(float(s.velocity @ (s.grain - s.sphere))) for s in states],
        outward=[float(s.contact_force @ (s.grain - s.sphere)) for s in states],
        normal=[s.normal_weight for s in states],
    )
    pre, post = (incline.Dynamics(*(incline.turned(v, angle) for v in s)) for s in states)
    return (
        ForceDiagram("before the shock", pre, post.sphere),
        ForceDiagram("after the shock", post, pre.sphere, pre.velocity),
    ), statement


def layers() -> tuple[tuple[LayerDrawing, ...], Statement]:
    """Return the substrate in upright towers and close-packed, with the chain below the contact."""
    columns = 6
    upright = _layers("upright towers", incline.towers(columns, LAYERS), columns)
    packed = _layers("close-packed", incline.close_packed(columns, LAYERS), columns)
    return (upright, packed), claim_of_facts(
        "fig-5",
        packed=packed,
        upright=upright,
        ends="1 sphere" if len(upright.chain) == 1 else f"{len(upright.chain)} spheres",
        leaning=incline.angle_between(incline.well(0) - incline.row(2)[1], (0, 1)),
    )


def _layers(name: str, spheres: Points, columns: int) -> LayerDrawing:
    """Return an arrangement, the fixed row first, at the critical angle."""
    top = spheres[columns * LAYERS :]
    below = top[columns // 2 - 2 : columns // 2]
    grain = incline.resting_on(*below)
    centres = (spheres[:columns], spheres[columns:], grain)
    fixed, mobile, resting, chain = (
        incline.turned(points, critical_angle())
        for points in (*centres, incline.straight_chain(grain, spheres, below[1]))
    )
    return LayerDrawing(
        name, LAYERS, fixed, mobile, resting, chain, float(top[0][1] - spheres[0][1])
    )


PARTICLES = (2, 3, 10, 20)
SEPARATED = (2, 3, 4, 20)

COLLAPSED = 9  # ten particles
LAST = 1.5  # [t0] beyond it the grain of ten particles has left

START = 0.01  # [t0] before it the first contacts close, all at once

SEEN = 0.01
"""Of the peak: what a figure shows."""

ALIKE = 1e-6
"""Of the peak: the part of a force that other figures call felt."""


class TowersInTime(NamedTuple):
    """Towers of several heights over time, and the largest force on the grain of all [N].

    ``by_height`` are those of figure 8, ``separated`` of figure 14.
    """

    by_height: tuple[TowerRun, ...]
    largest_force: float
    separated: tuple[TowerRun, ...]
    base_felt: tuple[float, ...]  # [t0], for each of ``separated``; infinite if not in the run


@cache
def towers_in_time() -> TowersInTime:
    """Run the towers of all heights once; return those of both figures."""
    *runs, tall = (
        tower(Tower(height=n), solver="exact", profiles=True) for n in (*HEIGHTS, 2 * max(HEIGHTS))
    )
    by_height, separated = (tuple(runs[n - 2] for n in chosen) for chosen in (PARTICLES, SEPARATED))
    largest = max(float(run.grain_force.max()) for run in runs)
    return TowersInTime(
        by_height, largest, separated, tuple(base_felt(run, tall) for run in separated)
    )


class Events(NamedTuple):
    """When things happen to three particles [t0], NaN for what does not."""

    joins: float
    alone: float
    back: float
    leaves: float


def event_times(run: TowerRun) -> Events:
    """Return when the tower of three does what :class:`Events` names.

    Raise ValueError for a tower of another height.
    """
    if run.tower.height != 2:
        raise ValueError(f"height = {run.tower.height}: the events are those of three particles")
    joins = [time for time, contacts in contact_changes(run) if contacts == 2]
    (begins, ends), *later = grain_alone(run) or [(math.nan, math.nan)]
    back, leaves = (ends, later[-1][0]) if later else (math.nan, math.nan)
    return Events(joins[0] if joins else math.nan, begins, back, leaves)


def force_and_contacts() -> tuple[TowersInTime, Statement]:
    """Judge the force on the grain and its contacts in time, of four heights."""
    towers = towers_in_time()
    apart = largest_difference(*towers.by_height[2:]) / towers.largest_force
    return towers, claim_of_facts(
        "fig-8",
        events=event_times(towers.by_height[1]),
        half=lambda time: np.round(2 * time) / 2,
        apart=apart,
        seen=SEEN,
        apart_text=f"{apart:.1e}" if apart > ALIKE else f"less than {ALIKE:.0e}",
        longest=[int(significant_contacts(run).max()) for run in towers.by_height],
    )


def separated() -> tuple[TowersInTime, Statement]:
    """Judge how contacts with neighbour and chain separate, of four heights."""
    towers = towers_in_time()
    return towers, separation(towers.separated, towers.base_felt)


def separation(runs: Sequence[TowerRun], felt: Sequence[float]) -> Statement:
    """Judge whether the base is felt later in longer chains, and where the neighbour's part ends.

    ``felt`` are the times of :func:`base_felt` of ``runs`` [t0], the longest chain last.
    """
    packets = grain_alone(runs[-1])
    return claim_of_facts(
        "fig-14",
        felt=felt,
        listing=[
            f"{run.tower.particles} particles {f'at {at:.2f} t0' if math.isfinite(at) else 'never'}"
            for run, at in zip(runs, felt, strict=True)
        ],
        span=runs[0].time_over_t0[-1],
        packets=packets,
        last=packets[-1][0],
    )


def base_felt(run: TowerRun, tall: TowerRun) -> float:
    """Return when the grain's force first differs from that in ``tall`` [t0], infinite if never.

    By :data:`SEEN` of the peak. Both runs need the same grain, as t0 is theirs.
    """
    grid, force, tall_force = _on_one_grid(run, tall)
    apart = np.flatnonzero(np.abs(force - tall_force) > SEEN * tall_force.max())
    return float(grid[apart[0]]) if apart.size else math.inf


def largest_difference(run: TowerRun, other: TowerRun) -> float:
    """Return the largest difference of the forces on the grain at one t/t0 [N]."""
    _, first, second = _on_one_grid(run, other)
    return float(np.abs(first - second).max())


def _on_one_grid(first: TowerRun, second: TowerRun) -> list[NDArray[np.float64]]:
    """Return common times [t0], and both forces there [N]."""
    grid = np.linspace(0, min(first.time_over_t0[-1], second.time_over_t0[-1]), 6001)
    forces = [np.interp(grid, run.time_over_t0, run.grain_force) for run in (first, second)]
    return [grid, *forces]


def collapse() -> tuple[tuple[TowerRun, ...], Statement]:
    """Run ten particles at the source's stiffnesses, and judge how close scaling brings them."""
    runs = tuple(
        tower(Tower(height=COLLAPSED, stiffness=k), solver="exact", profiles=True)
        for k in STIFFNESSES
    )
    return runs, judged(runs)


def judged(runs: tuple[TowerRun, ...]) -> Statement:
    """Judge by how much scaling brings runs an order of rigidity apart closer together."""
    remaining = np.array([_spread(pair, scaled=True) for pair in pairwise(runs)])
    events = [[time for time, _ in contact_changes(run) if START < time < LAST] for run in runs]
    same = len({len(times) for times in events}) == 1
    return claim_of_facts(
        "fig-9",
        before=max(_spread(pair, scaled=False) for pair in pairwise(runs)),
        remaining=remaining,
        shift=float(np.ptp(np.array(events), axis=0).max()) if same else math.nan,
        gammas=[run.tower.gamma for run in runs],
    )


def _spread(pair: tuple[TowerRun, TowerRun], *, scaled: bool) -> float:
    """Return the mean difference of two forces over their mean, against scaled or bare axes."""
    last = LAST * (1 if scaled else max(run.tower.contact_time for run in pair))
    grid = np.linspace(0, last, 3001)
    first, second = (
        np.interp(grid, run.time_over_t0, run.grain_force / (run.tower.speed * run.tower.omega))
        if scaled
        else np.interp(grid, run.time, run.grain_force)
        for run in pair
    )
    return float(np.abs(first - second).mean() / np.mean([first, second]))
