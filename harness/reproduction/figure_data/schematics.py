"""Figures 2, 3 and 5: the schematics, from positions and forces that are computed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.reproduction.claims import Statement, claim_of_facts
from harness.theory import energy_map, geometry
from harness.theory.critical_angle import critical_angle
from harness.theory.shock import SHOCK_WITHOUT_REBOUND

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
    state: geometry.Dynamics
    other: Points  # centre of the second sphere
    velocity_before: Points | None = None  # the shock; None in the first diagram


class Layers(NamedTuple):
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
    grains = {"A": geometry.crest(1, angle), "B": geometry.well(1), "C": geometry.crest(2, angle)}
    high = {name: geometry.height(at, angle) for name, at in grains.items()}
    depth, gain = high["C"] - high["B"], high["A"] - high["C"]
    off = max(
        abs(depth - energy_map.well_depth(angle)), abs(gain - energy_map.gain_per_crest(angle))
    )
    system = QuartierSystem(
        angle,
        geometry.turned(geometry.row(4), angle),
        {name: geometry.turned(at, angle) for name, at in grains.items()},
        geometry.turned(geometry.path(0, 3), angle),
    )
    return system, claim_of_facts(
        "fig-2",
        angle=angle,
        high=high,
        sides=[geometry.angle_between(grains["B"] - s, (0, 1)) for s in geometry.row(3)[1:]],
        depth=depth,
        gain=gain,
        off=off,
        rounding=_ROUNDING,
    )


def force_diagrams() -> tuple[tuple[ForceDiagram, ...], Statement]:
    """Return the grain before and after the shock in steady motion at the critical angle."""
    angle = critical_angle()
    states = before, after = geometry.steady_shock(angle, SHOCK_WITHOUT_REBOUND)
    statement = claim_of_facts(
        "fig-3",
        angle=angle,
        turn=geometry.angle_between(before.velocity, after.velocity),
        speed=[float(np.hypot(*s.velocity)) for s in states],
        perpendicular=[abs(float(s.velocity @ (s.grain - s.sphere))) for s in states],
        outward=[float(s.contact_force @ (s.grain - s.sphere)) for s in states],
        normal=[s.normal_weight for s in states],
    )
    pre, post = (geometry.Dynamics(*(geometry.turned(v, angle) for v in s)) for s in states)
    return (
        ForceDiagram("before the shock", pre, post.sphere),
        ForceDiagram("after the shock", post, pre.sphere, pre.velocity),
    ), statement


def layers() -> tuple[tuple[Layers, ...], Statement]:
    """Return the substrate in upright towers and close-packed, with the chain below the contact."""
    columns = 6
    upright = _layers("upright towers", geometry.towers(columns, LAYERS), columns)
    packed = _layers("close-packed", geometry.close_packed(columns, LAYERS), columns)
    return (upright, packed), claim_of_facts(
        "fig-5",
        packed=packed,
        upright=upright,
        ends="1 sphere" if len(upright.chain) == 1 else f"{len(upright.chain)} spheres",
        leaning=geometry.angle_between(geometry.well(0) - geometry.row(2)[1], (0, 1)),
    )


def _layers(name: str, spheres: Points, columns: int) -> Layers:
    """Return an arrangement, the fixed row first, at the critical angle."""
    top = spheres[columns * LAYERS :]
    left, right = top[columns // 2 - 2 : columns // 2]
    grain = geometry.resting_on(left, right)
    drawn = (spheres[:columns], spheres[columns:], grain)
    fixed, mobile, resting, chain = (
        geometry.turned(points, critical_angle())
        for points in (*drawn, geometry.straight_chain(grain, spheres, right))
    )
    return Layers(name, LAYERS, fixed, mobile, resting, chain, float(top[0][1] - spheres[0][1]))
