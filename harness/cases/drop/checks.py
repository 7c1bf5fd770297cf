"""The drops that an engine qualifies with, and what is expected of each.

Each trap that an engine is known to have shows here: a dashpot that is
silently missing or takes another effective mass (restitution), a contact that is found late
(onset), a force along the tangent (oblique), a wrong spring (static), a wrong clock (fall).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from harness.cases.drop.expected import hertz_impact, rest, restitution
from harness.cases.drop.parameters import Drop
from harness.cases.drop.runs import DropRun
from harness.comparison.tolerances import Tolerance
from harness.engines.traits import Traits
from harness.errors import EngineOutputError
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import PLASTIC, SOURCE, Contact, Spring

HEAD_ON = "restitution head-on"

HALF = 0.5
"""Restitution that tells every rule from every other."""

GAPS = 117.5
"""Steps that the grain flies before it meets the sphere: no round number, at which a sparse
search for contacts might happen to look."""

SPEED = 1.0
"""[m/s] of the collisions, on spheres of 1 m and 1 kg."""

TIMES_TO_REST = 30.0
"""[1/rate] of the slowest decay, until a grain rests; half of them pass before it is linear."""

OVERLAP = 1e-4
"""[d] of the grain that slides by: pressed in at the start."""


@dataclass(frozen=True)
class DropTest:
    """A drop, what is measured on its path, what is expected, and how close.

    ``quantity`` is the name of what is measured, in the baseline.
    """

    name: str
    quantity: str
    case: Drop
    measure: Callable[[DropRun], float]
    expected: float
    tolerance: Tolerance


@dataclass(frozen=True)
class DropEvidence:
    """The runs of an engine's drops with the tests that they were made for."""

    who: str
    made: tuple[tuple[DropTest, DropRun], ...]


def drop_tests(traits: Traits) -> Iterator[DropTest]:
    """Yield the tests that an engine with such traits can be put to."""
    for contact in _contacts(traits):
        yield _collision(contact, traits.spring)
    yield _static(traits) if traits.spring == "linear" else _static_hertz(traits)
    yield _onset(traits)
    yield _fall(traits)
    yield _oblique(traits)


def _contacts(traits: Traits) -> Iterator[Contact]:
    for tail in traits.tails:
        for mass in traits.effective_masses:
            contact = Contact(
                name=f"e = {HALF:g}, {tail}, m_eff {mass}",
                restitution=HALF,
                damping_ratio=None,
                tail=tail,
                effective_mass=mass,
            )
            yield from (c for c in (contact,) if not traits.refuses_contact(c))
    mass = traits.effective_masses[0]
    for named in (SOURCE, SOURCE.replace(name="source, clipped", tail="clipped"), PLASTIC):
        contact = named.replace(effective_mass=mass)
        if not traits.refuses_contact(contact):
            yield contact


def _any_contact(traits: Traits) -> Contact:
    """Return a contact with damping that the engine can state."""
    return next(iter(_contacts(traits)))


def _collision(contact: Contact, spring: Spring) -> DropTest:
    """Return the test of a restitution: in closed form, or integrated with Hertz's spring.

    An error of one step in the contact's begin is worth omega h of the speed, and so is
    the first-order error of a scheme that meets damping explicitly. With Hertz's spring the largest
    overlap without damping is that of the linear one at the speed of the drop, so a step is worth
    as much of the speed as there.
    """
    if spring == "linear":
        # a contact that ends late: at 15 contact times for the source's
        case = _flying(contact, duration=25.0, every=100)
        expected = restitution(case)
    else:
        impact = hertz_impact(_flying(contact, duration=1.0, every=1))
        # the impact's own time, and as much again for the flight before it
        case = _flying(contact, duration=1.0 + 2.0 * impact.duration / math.pi, every=100)
        expected = impact.restitution
    width = math.pi / case.steps_per_contact * (1.0 + 2.0 * contact.zeta_against_full_mass)
    return DropTest(
        f"{HEAD_ON}, {contact.name}",
        "restitution",
        case,
        lambda run: float(run.path.vy_m_per_s[-1]) / SPEED,
        expected,
        Tolerance("", width, 0.0, "omega h (1 + 2 zeta): a step's worth of spring and dashpot"),
    )


def _flying(contact: Contact, duration: float, every: int) -> Drop:
    case = Drop(contact=contact, speed=SPEED, duration=duration, every=every)
    return case.replace(gap=GAPS * case.speed * case.step)


def _onset(traits: Traits) -> DropTest:
    """Return the collision that tells whether the force begins in the step after the contact."""
    case = _flying(_any_contact(traits), duration=0.2, every=1)
    resolution = 10.0 ** (1 - traits.digits)
    return DropTest(
        "contact found within two steps",
        "onset_steps",
        case,
        lambda run: _depth_of_onset(run, resolution) / (case.speed * case.step),
        0.0,
        Tolerance("steps", 2.0, 0.0, "a step is the resolution, and a scheme may write one late"),
    )


def _depth_of_onset(run: DropRun, resolution: float) -> float:
    """Return the depth [m] to which the grain flies freely, by its first change of speed."""
    v = run.path.vy_m_per_s
    changed = np.flatnonzero(np.abs(v - v[0]) > 10.0 * resolution * abs(v[0]))
    if changed.size == 0:
        raise EngineOutputError(f"{run.provenance.engine}: the grain never felt the sphere")
    return float(run.case.diameter - run.path.y_m[changed[0] - 1])


def _static(traits: Traits) -> DropTest:
    """Return the grain that comes to rest under its weight: the overlap is m g / k."""
    contact = _any_contact(traits)
    # soft, so that single precision can tell the overlap
    case = Drop(contact=contact, stiffness=1e4, gravity=9.81, duration=40.0, every=1000)
    left = 2.0 * math.exp(-contact.zeta_against_full_mass * math.pi * case.duration)
    return _rest("m g / k", case, left, traits)


def _static_hertz(traits: Traits) -> DropTest:
    """Return the grain that comes to rest on Hertz's spring: the overlap is (m g / K)^(2/3).

    The most damped contact rests first; the step may be coarse, as the rest does not depend on it.
    """
    contact = max(_contacts(traits), key=lambda contact: contact.zeta_against_full_mass)
    case = Drop(contact=contact, gravity=9.81, steps_per_contact=200.0, every=100)
    _, rate = rest(case, traits.spring)
    case = case.replace(duration=TIMES_TO_REST / rate / case.contact_time)
    return _rest("(m g / K)^(2/3)", case, math.exp(-0.5 * TIMES_TO_REST), traits)


def _rest(name: str, case: Drop, left: float, traits: Traits) -> DropTest:
    """Return the test of the overlap at rest; ``left`` is the part of the motion left."""
    overlap, _ = rest(case, traits.spring)
    digits = 10.0 ** (1 - traits.digits) * case.diameter / overlap
    return DropTest(
        f"static contact, overlap over {name}",
        "static_overlap_ratio",
        case,
        lambda run: (case.diameter - float(run.path.y_m[-1])) / overlap,
        1.0,
        Tolerance(
            "",
            left + 10.0 * digits + 1e-9,
            0.0,
            "what the dashpot has left of the motion, and the digits of the output",
        ),
    )


def _fall(traits: Traits) -> DropTest:
    """Return the free fall that ends before it meets the sphere: g t^2 / 2."""
    case = Drop(contact=_any_contact(traits), gravity=9.81, gap=0.05, every=100)
    time = 0.9 * math.sqrt(2.0 * case.gap / case.gravity)
    case = case.replace(duration=time / case.contact_time)

    def fallen(run: DropRun) -> float:
        t = float(run.path.time_s[-1])
        start = case.diameter + case.gap
        return (start - float(run.path.y_m[-1])) / (0.5 * case.gravity * t * t)

    step = 2.0 * case.step / time
    digits = 10.0 ** (1 - traits.digits) / case.gap
    return DropTest(
        "free fall over g t^2 / 2",
        "fall_ratio",
        case,
        fallen,
        1.0,
        Tolerance("", step + 10.0 * digits, 0.0, "a scheme may begin half a step late or early"),
    )


def _oblique(traits: Traits) -> DropTest:
    """Return the grain that slides by a sphere: a central force keeps m (x vy - y vx)."""
    case = Drop(contact=_any_contact(traits), sideways=SPEED, gap=-OVERLAP, duration=3.0, every=100)

    def kept(run: DropRun) -> float:
        ratio = angular_momentum_ratio(run.path)
        if not math.isfinite(ratio):
            raise EngineOutputError(f"{run.provenance.engine}: the grain never moved sideways")
        return ratio

    width = max(1e-9, 10.0 * 10.0 ** (1 - traits.digits))
    return DropTest(
        "oblique contact, angular momentum kept",
        "angular_momentum_ratio",
        case,
        kept,
        1.0,
        Tolerance("", width, 0.0, "exact in symplectic schemes but for round-off and digits"),
    )


def angular_momentum_ratio(path: Trajectory) -> float:
    """Return the angular momentum about the sphere's centre, end over start; NaN for none there."""
    momentum = path.x_m * path.vy_m_per_s - path.y_m * path.vx_m_per_s
    return float(momentum[-1] / momentum[0]) if momentum[0] else math.nan
