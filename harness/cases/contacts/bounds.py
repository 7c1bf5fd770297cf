"""The bounds within which parameters of a contact have meaning; errors name what is allowed.

Overlaps: coordinates are rounded, so that too small an overlap is lost; beyond the smaller radius
the centre is past the surface of the partner. Steps: velocity Verlet is off by (rate step)^2 / 24
in the phase of an oscillation, and unstable from rate step = 2 on.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, TypedDict

from harness.errors import RequestError
from harness.model.law import damping_ratio
from harness.theory import contact

if TYPE_CHECKING:
    from harness.cases.contacts.parameters import ContactSystem
    from harness.model.scene import Body

SMALLEST_RESTITUTION = 1e-6  # of a linear contact that still ends
STRONGEST = damping_ratio(SMALLEST_RESTITUTION)
SHALLOWEST = 4.0 * sys.float_info.epsilon / 1e-6  # [radii] overlap that rounding spoils by 1e-6
DEEPEST = 0.25  # [radius] flat of a sphere that yields: its law was fitted for shallow ones
FLAT_WITHIN = 0.75  # [radius] depth of mdr's flat between unequal spheres
WIDEST = 1e6  # ratio of radii: three decades between the smallest overlap and the largest
COARSEST = 0.5  # rate times step: 1 % of a phase
MOST_STEPS = 10**9
QUARTERS = 4
OVERLAP_RANGE = "the overlap must be above the round-off of coordinates and below the radius"


def check_range(name: str, value: float, unit: str, limits: tuple[float, float], why: str) -> None:
    """Raise ValueError for a value outside limits, with its name, the range and the reason."""
    low, high = limits
    if not low <= value <= high:
        text = f"{name} = {value!r} {unit}".rstrip()
        raise ValueError(f"{text}: must be between {low:.4g} and {high:.4g} here: {why}")


def check_words(parameters: ContactSystem, **allowed: tuple[str, ...]) -> None:
    """Raise ValueError for a field whose word a case does not take."""
    for name, words in allowed.items():
        if (value := getattr(parameters, name)) not in words:
            raise ValueError(f"{name} = {value!r}: must be one of {', '.join(words)} in this case")


def overlap_range(p: ContactSystem) -> tuple[float, float]:
    """Return the smallest and the largest overlap with a meaning [m].

    Raise ValueError for radii too far apart, and where JKR's area without load, a^3 = 9 pi gamma
    R*^2 / E*, is larger than the reduced radius.
    """
    r, other = p.radius, p.second_radius
    limits = (r / WIDEST, r * WIDEST)
    check_range("partner_radius", other, "m", limits, "the radii are too far apart")
    if p.surface_energy and p.moduli:
        most = p.moduli[0] * p.effective_radius / 9.0 / math.pi
        why = "the area of contact without a load must be smaller than the reduced radius"
        check_range("surface_energy", p.surface_energy, "J/m2", (0.0, most), why)
    radii = (r,) if p.partner == "wall" else (r, other)
    share = FLAT_WITHIN if p.normal == "mdr" and len(set(radii)) > 1 else 1.0
    return SHALLOWEST * sum(radii), share * min(radii)


def check_overlap(
    p: ContactSystem, name: str, unit: str, overlap: float, power: float = 1.0
) -> None:
    """Raise ValueError for a parameter whose overlap [m], which goes with its power, is none."""
    value, limits = getattr(p, name), overlap_range(p)
    if not limits[0] <= overlap <= limits[1]:
        low, high = (value * (bound / overlap) ** (1.0 / power) for bound in limits)
        check_range(name, value, unit, (low, high), OVERLAP_RANGE)


def check_rest(p: ContactSystem, gravity: float) -> None:
    """Raise ValueError for gravity along the normal [m/s2] that presses in too far, or too little.

    The parameter is ``gravity``.
    """
    power = 1.0 if p.normal == "hooke" else 2.0 / 3.0
    check_overlap(p, "gravity", "m/s2", p.rest_overlap(p.mass * gravity), power)


def check_impact(
    p: ContactSystem, name: str, unit: str, speed: float, value_of: Callable[[float], float],
    gravity: float = 0.0,
) -> None:  # fmt: skip
    """Raise ValueError for an impact at a normal speed [m/s] that no contact withstands.

    ``value_of`` gives the value of the parameter ``name`` for a speed. Under ``gravity`` [m/s2] a
    sphere that its weight presses in further than its speed does not bounce.
    """
    mass, (least, most) = p.effective_mass, overlap_range(p)
    stored = p.elastic_energy(most) / mass
    if stored <= 2.0 * gravity * most:
        check_range("gravity", gravity, "m/s2", (0.0, 0.5 * stored / most), OVERLAP_RANGE)
    slow = math.sqrt(2.0 * p.elastic_energy(least) / mass)
    if gravity:
        rest = p.rest_overlap(mass * gravity)
        slow = max(slow, gravity * math.sqrt(mass / p.slope(rest)))
    fast = math.sqrt(2.0 * (stored - gravity * most)) / _damped_share(p)
    if not slow <= speed <= fast:
        limits = value_of(slow), value_of(fast)
        check_range(name, getattr(p, name), unit, limits, OVERLAP_RANGE)
    if p.yield_stress is not None:
        _check_yield(p, p.yield_stress, speed)
    if p.damping_coefficient and not p.clipped:
        overlap = p.elastic_overlap(speed)
        critical = 2.0 * math.sqrt(mass * p.slope(overlap))
        highest = p.damping_coefficient * STRONGEST * critical / p.eta(overlap)
        why = "from critical damping on the contact does not end, unless it is clipped"
        check_range("damping_coefficient", p.damping_coefficient, "", (0.0, highest), why)


def _check_yield(p: ContactSystem, stress: float, speed: float) -> None:
    """Raise ValueError for a yield stress [Pa] with which an impact [m/s] goes too deep.

    A pressure Y on the area pi (2 R d - d^2), on each side, does at most the work of mdr.
    """
    flats = 1.0 if p.partner == "wall" else 2.0
    work = flats * math.pi * p.radius**3 * (DEEPEST**2 - DEEPEST**3 / 3.0)
    least = 0.5 * p.effective_mass * speed**2 / work
    why = "a sphere that yields must not be pressed in by more than a quarter of its radius"
    check_range("yield_stress", stress, "Pa", (least, 1e30), why)


def _damped_share(p: ContactSystem) -> float:
    """Return the largest overlap over that without damping; 1 for what is not linear."""
    if not p.is_linear:
        return 1.0
    ratio = 0.5 * p.eta(0.0) / math.sqrt(p.slope(1.0) * p.effective_mass)
    return contact.largest_overlap(ratio if p.clipped else min(ratio, STRONGEST))


def check_steps(p: ContactSystem, bodies: Iterable[Body], step: float, overlap: float) -> None:
    """Raise RequestError for a part of the law that a step [s] does not resolve.

    Dashpots are those at an ``overlap`` [m].
    """
    for name, rate, power in _rates(p, bodies, overlap):
        value, coarse = getattr(p, name), rate * step / COARSEST
        if value is not None and coarse > 1.0:
            most = f"must be at most {value / coarse**power:.4g}, or " if power else ""
            n = p.steps_per_contact
            raise RequestError(
                f"{name} = {value!r}: {most}needs steps_per_contact of at least "
                f"{math.ceil(n * coarse)}, not {n}: a step must resolve it"
            )


def _rates(
    p: ContactSystem, bodies: Iterable[Body], overlap: float
) -> Iterator[tuple[str, float, float]]:
    """Yield each coefficient with its rate [1/s], and the power of the rate that it goes with."""
    turning = sum(1.0 / body.moment_of_inertia for body in bodies if body.motion == "free")
    rolling = p.effective_radius**2 * turning
    slip = 3.5 / p.effective_mass
    eta = p.eta(overlap)
    yield "damping_coefficient", eta / p.effective_mass, 1.0
    yield "restitution", eta / p.effective_mass, 0.0
    yield "tangential_stiffness", math.sqrt((p.tangential_stiffness or 0.0) * slip), 2.0
    yield "tangential_damping", (p.tangential_damping or 0.0) * eta * slip, 1.0
    for part, factor in (("rolling", rolling), ("twisting", turning)):
        stiffness, damping = f"{part}_stiffness", f"{part}_damping"
        yield stiffness, math.sqrt((getattr(p, stiffness) or 0.0) * factor), 2.0
        yield damping, (getattr(p, damping) or 0.0) * factor, 1.0


def count_steps(duration: float, steps: float) -> int:
    """Return a number of steps; raise RequestError, which names the duration, for too many."""
    if not steps <= MOST_STEPS:
        most = duration * (MOST_STEPS / steps)
        raise RequestError(
            f"duration = {duration!r}: must be at most {most:.4g} here: {MOST_STEPS:.0e} steps are "
            f"allowed, this would take {steps:.3g}"
        )
    return math.ceil(steps)


class Steps(TypedDict):
    """Fields of a scene: the step [s], the number of steps, and the steps between samples."""

    step: float
    steps: int
    every: int


def quarters(duration: float, steps: float, seconds: float) -> Steps:
    """Return the steps of a time [s], about so many, with a sample after each quarter.

    Raise RequestError, which names the duration, for too many.
    """
    count_steps(duration, steps)
    every = max(1, round(steps / QUARTERS))
    return {"step": seconds / QUARTERS / every, "steps": QUARTERS * every, "every": every}
