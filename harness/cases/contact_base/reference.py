"""The same scenes by the independent integration of the law: what limits are held against."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

from harness.cases.contact_base.motion import Motion
from harness.engines.contact_model import stating
from harness.engines.contract import Job
from harness.engines.traits import Traits
from harness.errors import RequestError
from harness.parameters.contact_rules import Rules
from harness.parameters.contact_scene import ContactScene

LONGEST = 64
"""Guesses of a contact's duration that are tried: a strong dashpot draws it out."""


@dataclass(frozen=True)
class Followed:
    """The motion of a scene, and whether friction began or ceased to slide in it.

    ``jumps``: with a jump of the force, as the dashpot is off while it slides.
    """

    motion: Motion
    kinked: bool
    jumps: bool


def rules_of(job: Job, traits: Traits) -> Rules:
    """Return the rules of the model by which an engine states the contact of a job."""
    return Rules(**stating(traits.contact_models, job.values)[0].rules)


@lru_cache(maxsize=2048)
def followed(scene: ContactScene, rules: Rules, tolerance: float | None = None) -> Followed:
    """Return the motion that the law asks for under a code's rules, to a local error."""
    from harness.pair.integration import TOLERANCE, integrate

    path = integrate(scene, rules, tolerance or TOLERANCE)
    motion = Motion(
        path.times, path.positions, path.velocities, path.omegas, path.forces, path.torques
    )
    law = scene.law
    dashpot = law.tangential_spring and law.tangential_damping and law.damping != "none"
    off = rules.damping_in_cap in ("sticking_only", "until_sliding")
    jumps = off and dashpot and path.of_kind("slides", "sticks")
    kinked = path.of_kind("slides", "sticks", "clips", "repels")
    return Followed(motion, bool(kinked), bool(jumps))


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
    raise RequestError("the contact does not end: its damping, or its attraction, is too strong")
