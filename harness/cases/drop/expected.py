"""What one drop is expected to do: closed forms, and Hertz's impact, which is integrated."""

from __future__ import annotations

import math

from harness.cases.contract import Reference
from harness.cases.drop.parameters import Drop
from harness.parameters.contact import Spring
from harness.parameters.hertz import hertz
from harness.theory.dashpot import duration_clipped, restitution_clipped, restitution_unclipped

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


def _linear_impact(case: Drop) -> dict[str, Reference]:
    zeta = case.contact.zeta_against_full_mass
    clipped = case.contact.tail == "clipped"
    law = restitution_clipped if clipped else restitution_unclipped
    # the motion turns at half the time at which the clipped force vanishes
    deepest = math.exp(-0.5 * zeta * duration_clipped(zeta)) * math.sqrt(case.mass / case.stiffness)
    return {
        "restitution": Reference(law(zeta), "closed form"),
        "largest_overlap_m": Reference(case.speed * deepest, "closed form"),
        "end_speed_m_per_s": Reference(law(zeta) * case.speed, "closed form"),
    }


def _hertz_impact(case: Drop) -> dict[str, Reference]:
    from harness.theory.hertz import impact

    law = hertz(case.contact, case.stiffness, case.mass, case.hertz_speed)
    found = impact(
        law.relaxation * case.speed / law.overlap, clipped=case.contact.tail == "clipped"
    )
    return {
        "restitution": Reference(found.restitution, "integrated"),
        "end_speed_m_per_s": Reference(found.restitution * case.speed, "integrated"),
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
    weight = case.mass * case.gravity
    if spring != "linear":
        law = hertz(case.contact, case.stiffness, case.mass, case.hertz_speed)
        overlap = law.rest(weight)
        zeta = law.damping_ratio(overlap, case.mass)
        omega = math.sqrt(law.slope(overlap) / case.mass)
    else:
        overlap, zeta = weight / case.stiffness, case.contact.zeta_against_full_mass
        omega = math.sqrt(case.stiffness / case.mass)
    slowest = zeta - math.sqrt(zeta * zeta - 1.0) if zeta >= 1.0 else zeta
    left = math.exp(-slowest * omega * case.steps * case.step)
    if left > RESTED:
        return {}
    return {"end_overlap_m": Reference(overlap, "closed form")}
