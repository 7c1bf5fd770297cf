"""Figures 2, 3 and 5: the schematics, from positions and forces that are computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.reproduction.claims import Statement
from harness.reproduction.facts import claim_of_facts
from harness.reproduction.source import SOURCES
from harness.theory import energy_map, geometry
from harness.theory.critical_angle import critical_angle
from harness.theory.shock import SHOCK_WITHOUT_REBOUND

_ROUNDING = 1e-12
"""Of positions near 1 d: what is left of two routes to the same number."""

Points = NDArray[np.float64]

LAYERS = 4
"""Drawn: enough to see a chain, few enough to read."""


@dataclass(frozen=True)
class QuartierSystem:
    """The row and the grain on it, to scale with gravity straight down [d].

    ``grains`` maps the source's letters to centres (2,), ``path`` (P, 2) is that
    of the grain's centre.
    """

    angle_deg: float
    spheres: Points  # (S, 2)
    grains: Mapping[str, Points]
    path: Points


@dataclass(frozen=True)
class ForceDiagram:
    """The grain in the well, on one of the two spheres; gravity straight down.

    ``other`` is the centre of the second sphere, ``velocity_before`` that before the
    shock, None in the first diagram.
    """

    name: str
    state: geometry.Dynamics
    other: Points
    velocity_before: Points | None = None


@dataclass(frozen=True)
class Layers:
    """A substrate of several layers with a grain in a well of the top one, to scale [d].

    ``chain`` (L, 2) are the spheres that touch in a straight line below the
    grain's contact; ``height`` is that of the layers above the fixed row.
    """

    name: str
    layers: int
    fixed: Points
    mobile: Points
    grain: Points
    chain: Points
    height: float


def quartier() -> tuple[QuartierSystem, Statement]:
    """Return the row at its critical angle, and whether positions give well and gain."""
    angle = critical_angle()
    grains = {"A": geometry.crest(1, angle), "B": geometry.well(1), "C": geometry.crest(2, angle)}
    high = {name: geometry.height(at, angle) for name, at in grains.items()}
    depth, gain = high["C"] - high["B"], high["A"] - high["C"]
    off = max(
        abs(depth - energy_map.well_depth(angle)), abs(gain - energy_map.gain_per_crest(angle))
    )
    sides = [geometry.angle_between(grains["B"] - s, (0, 1)) for s in geometry.row(3)[1:]]
    system = QuartierSystem(
        angle,
        geometry.turned(geometry.row(4), angle),
        {name: geometry.turned(at, angle) for name, at in grains.items()},
        geometry.turned(geometry.path(0, 3), angle),
    )
    facts = [
        (
            high["B"] < high["C"] < high["A"],
            f"drawn to scale at {angle:.4f} deg, the well B is {sides[0]:.2f} and {sides[1]:.2f} "
            f"deg from the row's normal, {depth:.5f} d below the crest C, and C is {gain:.5f} d "
            "below A",
        ),
        (
            off < _ROUNDING,
            "the source's expressions for well and gain are these heights, to "
            f"{max(off, _ROUNDING):.0e} d",
        ),
    ]
    return system, claim_of_facts(SOURCES["fig-2"], facts)


def force_diagrams() -> tuple[tuple[ForceDiagram, ...], Statement]:
    """Return the grain before and after the shock in steady motion at the critical angle."""
    angle = critical_angle()
    before, after = geometry.steady_shock(angle, SHOCK_WITHOUT_REBOUND)
    turn = geometry.angle_between(before.velocity, after.velocity)
    outward = [float(s.contact_force @ (s.grain - s.sphere)) for s in (before, after)]
    speed = [float(np.hypot(*state.velocity)) for state in (before, after)]
    normal = [state.normal_weight for state in (before, after)]
    perpendicular = [abs(float(s.velocity @ (s.grain - s.sphere))) for s in (before, after)]
    facts = [
        (
            max(perpendicular) < _ROUNDING,
            f"in steady motion at {angle:.4f} deg the velocity, perpendicular to the contact, "
            f"turns by {turn:.2f} deg and keeps {speed[1] / speed[0]:.4f} of {speed[0]:.4f} "
            "sqrt(g d)",
        ),
        (
            all(0 < f <= n for f, n in zip(outward, normal, strict=True)),
            f"the contact force is {outward[0]:.4f} m g before and {outward[1]:.4f} after, the "
            f"normal component of gravity {normal[0]:.4f} and {normal[1]:.4f}",
        ),
    ]
    statement = claim_of_facts(
        SOURCES["fig-3"],
        facts,
        "What the force lacks of that component turns the velocity along the arc.",
    )
    pre, post = (
        geometry.Dynamics(*(geometry.turned(vector, angle) for vector in state))
        for state in (before, after)
    )
    return (
        ForceDiagram("before the shock", pre, post.sphere),
        ForceDiagram("after the shock", post, pre.sphere, pre.velocity),
    ), statement


def layers() -> tuple[tuple[Layers, ...], Statement]:
    """Return the substrate in upright towers and close-packed, with the chain below the contact."""
    angle, columns = critical_angle(), 6
    arranged = {
        "upright towers": geometry.towers(columns, LAYERS),
        "close-packed": geometry.close_packed(columns, LAYERS),
    }
    drawn = []
    first = columns // 2 - 2
    for name, spheres in arranged.items():
        top = spheres[columns * LAYERS :]
        grain = geometry.resting_on(top[first], top[first + 1])
        chain = geometry.straight_chain(grain, spheres, top[first + 1])
        drawn.append(
            Layers(
                name,
                LAYERS,
                geometry.turned(spheres[:columns], angle),
                geometry.turned(spheres[columns:], angle),
                geometry.turned(grain, angle),
                geometry.turned(chain, angle),
                float(top[0][1] - spheres[0][1]),
            )
        )
    reach = [len(part.chain) for part in drawn]
    leaning = geometry.angle_between(geometry.well(0) - geometry.row(2)[1], (0, 1))
    facts = [
        (
            reach[1] == LAYERS + 1,
            f"close-packed, {drawn[1].height:.3f} d high, the contact of the grain after the shock "
            f"goes on in a straight chain of {reach[1]} spheres through {LAYERS} layers to the "
            "fixed row",
        ),
        (
            reach[0] == LAYERS + 1,
            f"in upright towers, {drawn[0].height:g} d high, that chain has {reach[0]} sphere"
            f"{'s' if reach[0] != 1 else ''}, as the contact leans {leaning:.1f} deg against the "
            "tower, with which the one-dimensional collision has it in line",
        ),
    ]
    statement = claim_of_facts(
        SOURCES["fig-5"], facts, corrected_holds=any(holds for holds, _ in facts)
    )
    return tuple(drawn), statement
