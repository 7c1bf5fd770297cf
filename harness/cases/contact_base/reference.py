"""The same scenes by the independent integration of the law: what limits are held against."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from harness.cases.contact_base.motion import Array, Motion
from harness.engines.contact_model import stating
from harness.engines.contract import Job
from harness.engines.traits import Traits
from harness.errors import RequestError
from harness.pair.path import ContactPath, Event
from harness.parameters.contact_rules import Rules
from harness.parameters.contact_scene import ContactScene

SAME = 1e-6
"""Relative difference of durations that makes none for the phase of a step."""

LONGEST = 64
"""Guesses of a contact's duration that are tried: a strong dashpot draws it out."""


@dataclass(frozen=True)
class Interval:
    """The time between two switches of a contact: from one on, how long [s], and what it is worth.

    ``change`` is how far the accelerations by the contacts differ in it from those after it at
    most, (bodies, 6) [m/s2, rad/s2].
    """

    begin: float
    duration: float
    change: Array


@dataclass(frozen=True)
class Followed:
    """The motion of a scene, and whether friction began or ceased to slide in it.

    ``jumps``: with a jump of the force, as the dashpot is off while it slides. ``ended``: when the
    contact last ended [s], NaN if it did not. ``intervals`` lie between its switches.
    """

    motion: Motion
    kinked: bool
    jumps: bool
    ended: float
    intervals: tuple[Interval, ...] = ()


def rules_of(job: Job, traits: Traits) -> Rules:
    """Return the rules of the model by which an engine states the contact of a job."""
    return Rules(**stating(traits.contact_models, job.values)[0].rules)


def powers_of(job: Job, traits: Traits) -> tuple[float, ...]:
    """Return the powers of the step in the errors that an engine adds to those of the law."""
    springs = ("tangential", "rolling", "twisting")
    if all(job.values[part] in ("none", "linear_nohistory") for part in springs):
        return traits.contact_powers
    return (*traits.contact_powers, *stating(traits.contact_models, job.values)[0].turning)


@lru_cache(maxsize=2048)
def asked_for(scene: ContactScene, rules: Rules) -> Rules:
    """Return rules without those that change nothing in a scene."""
    from harness.pair.system import same_system

    for name in rules.model_dump(exclude_defaults=True):
        without = rules.model_copy(update={name: Rules.model_fields[name].default})
        rules = without if same_system(scene, without, rules) else rules
    return rules


def followed(scene: ContactScene, rules: Rules, tolerance: float | None = None) -> Followed:
    """Return the motion that the law asks for under a code's rules.

    ``tolerance`` is that of the integration, its own unless given.
    """
    from harness.pair.integration import TOLERANCE

    return _followed(scene, asked_for(scene, rules), tolerance or TOLERANCE)


@lru_cache(maxsize=2048)
def _followed(scene: ContactScene, rules: Rules, tolerance: float) -> Followed:
    from harness.pair.integration import integrate

    path = integrate(scene, rules, tolerance)
    motion = Motion(
        path.times, path.positions, path.velocities, path.omegas, path.forces, path.torques
    )
    law = scene.law
    dashpot = law.tangential_spring and law.tangential_damping and law.damping != "none"
    dashpot = dashpot or law.rolling_damping or law.twisting_damping
    off = rules.damping_in_cap in ("sticking_only", "until_sliding")
    jumps = off and dashpot and path.of_kind("slides", "sticks")
    kinked = path.of_kind("slides", "sticks", "clips", "repels")
    ends = [event.time for event in path.of_kind("ends")]
    ended = ends[-1] if ends else math.nan
    return Followed(motion, bool(kinked), bool(jumps), ended, _intervals(path))


def _intervals(path: ContactPath) -> tuple[Interval, ...]:
    """Return the times between switches of one contact, in order of their ends."""
    latest: dict[tuple[int, int], Event] = {}
    found = []
    for event in path.of_kind("begins", "slides", "sticks", "clips", "repels"):
        first = latest.get(event.contact)
        if first is not None and event.time > first.time:
            change = np.maximum(abs(first.after - event.after), abs(event.before - event.after))
            found.append(Interval(first.time, event.time - first.time, change))
        latest[event.contact] = event
    return tuple(found)


def jumps_at_the_end(scene: ContactScene, rules: Rules) -> bool:
    """Return whether a dashpot is cut off at another phase of a step on every rung.

    The steps are parts of the contact's duration under the default rules: where others change
    it, the contact no longer ends at the same phase. Nor does one whose steps are parts of the
    time up to yield, or that a code draws out by steps that the bulk's response is behind; there
    a dashpot is cut off, or falls to 0 as the fourth root of what is left of the overlap.
    """
    if scene.law.lags and scene.law.damping != "none" and not scene.law.clipped:
        return math.isfinite(followed(scene, rules).ended)
    ended, plain = followed(scene, rules).ended, followed(scene, Rules()).ended
    dashpot = scene.law.damping != "none" and not scene.law.clipped
    return dashpot and math.isfinite(ended) and not math.isclose(ended, plain, rel_tol=SAME)


@lru_cache(maxsize=2048)
def yield_time(scene: ContactScene) -> float:
    """Return after which time of its first contact a sphere yields [s]; inf if it does not."""
    from harness.pair.integration import integrate

    path = integrate(scene, Rules())
    begun = [event.time for event in path.of_kind("begins")]
    return next((event.time - begun[0] for event in path.of_kind("yields")), math.inf)


@lru_cache(maxsize=2048)
def contact_time(scene: ContactScene) -> float:
    """Return how long the first contact of a scene lasts [s]; its one step is a first guess.

    Raise RequestError for a contact that does not end.
    """
    from harness.pair.integration import integrate

    longer = 1
    while longer <= LONGEST:
        path = integrate(replace(scene, step=scene.step * longer), Rules())
        lasted = path.contact_times()
        if lasted:
            return lasted[0]
        longer *= 4
    strong = ("damping_coefficient", "restitution", "surface_energy")
    given = [(name, getattr(scene.law, name)) for name in strong]
    named = ", ".join(f"{name} = {value!r}" for name, value in given if value is not None)
    raise RequestError(
        f"{named}: the contact does not end; less damping or attraction, or a faster impact, end it"
    )
