"""What one drop is expected to do: closed forms, and Hertz's impact, which is integrated."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from harness.cases.contract import Reference
from harness.cases.drop.parameters import Drop
from harness.parameters.contact import Spring
from harness.theory.dashpot import (
    duration_clipped,
    duration_unclipped,
    restitution_clipped,
    restitution_unclipped,
)

if TYPE_CHECKING:
    from harness.theory.hertz import Impact

RESTED = 1e-6
"""Part of its motion that a grain keeps at most which is said to rest."""


def references_of(case: Drop, spring: Spring) -> dict[str, Reference]:
    """Return the expected quantities of a drop by their names; {} where none is known."""
    if case.sideways != 0.0:
        kept = case.gravity == 0.0
        return {"angular_momentum_ratio": Reference(1.0, "closed form")} if kept else {}
    if case.gravity > 0.0:
        return _falling(case) if case.gap > 0.0 else _resting(case, spring)
    if case.speed <= 0.0:
        return {}
    return _linear_impact(case) if spring == "linear" else _hertz_impact(case)


def restitution(case: Drop) -> float:
    """Return the restitution of a head-on collision with the linear spring."""
    law = restitution_clipped if case.contact.tail == "clipped" else restitution_unclipped
    return law(case.contact.zeta_against_full_mass)


def hertz_impact(case: Drop) -> Impact:
    """Return the head-on collision with Hertz's spring."""
    from harness.theory.hertz import impact

    law = case.hertz
    clipped = case.contact.tail == "clipped"
    return impact(law.relaxation * case.speed / law.overlap, clipped=clipped)


def rest(case: Drop, spring: Spring) -> tuple[float, float]:
    """Return the overlap [m] under the weight, and the slowest rate [1/s] at which it is reached.

    m g / k, or (m g / K)^(2/3) with Hertz's spring.
    """
    weight = case.mass * case.gravity
    if spring == "linear":
        overlap, slope = weight / case.stiffness, case.stiffness
        zeta = case.contact.zeta_against_full_mass
    else:
        overlap = case.hertz.rest(weight)
        slope, zeta = case.hertz.slope(overlap), case.hertz.damping_ratio(overlap, case.mass)
    slowest = zeta - math.sqrt(zeta * zeta - 1.0) if zeta >= 1.0 else zeta
    return overlap, slowest * math.sqrt(slope / case.mass)


def _linear_impact(case: Drop) -> dict[str, Reference]:
    """Return the overlap of a collision that has turned within the run, and what one over leaves.

    The motion turns at half the time at which the clipped force vanishes.
    """
    zeta, unit = case.contact.zeta_against_full_mass, math.sqrt(case.mass / case.stiffness)
    left = (case.steps * case.step - max(case.gap, 0.0) / case.speed) / unit
    turns = 0.5 * duration_clipped(zeta)
    if case.contact.tail == "clipped":
        parts = duration_clipped(zeta)
    else:  # from critical damping on it creeps back for ever
        parts = duration_unclipped(zeta) if zeta < 1.0 else math.inf
    found = {}
    if left >= turns:
        deepest = case.speed * math.exp(-zeta * turns) * unit
        found["largest_sampled_overlap_m"] = Reference(deepest, "closed form")
    if left >= parts:
        found["restitution"] = Reference(restitution(case), "closed form")
        found["end_speed_m_per_s"] = Reference(restitution(case) * case.speed, "closed form")
    return found


def _hertz_impact(case: Drop) -> dict[str, Reference]:
    found = hertz_impact(case).restitution
    return {
        "restitution": Reference(found, "integrated"),
        "end_speed_m_per_s": Reference(found * case.speed, "integrated"),
    }


def _falling(case: Drop) -> dict[str, Reference]:
    """Return where a free fall ends; {} for one that meets the sphere."""
    time = case.steps * case.step
    fallen = case.speed * time + 0.5 * case.gravity * time * time
    if fallen >= case.gap:
        return {}
    return {
        "end_overlap_m": Reference(fallen - case.gap, "closed form"),
        "end_speed_m_per_s": Reference(case.speed + case.gravity * time, "closed form"),
    }


def _resting(case: Drop, spring: Spring) -> dict[str, Reference]:
    """Return the overlap under the weight; {} for a grain that is still moving at the end."""
    overlap, rate = rest(case, spring)
    if math.exp(-rate * case.steps * case.step) > RESTED:
        return {}
    return {"end_overlap_m": Reference(overlap, "closed form")}
