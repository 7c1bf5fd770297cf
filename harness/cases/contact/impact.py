"""Impacts: the first sphere flies at its partner, touches it, and leaves.

Closed forms of the normal motion by the names of quantities, and the literature's curve of an
impact with friction: the velocity that is left at the contact.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from harness.cases.contact.motion import Array, Motion
from harness.cases.contact.parameters import (
    ContactSystem,
    dashpots,
    elastic_overlap,
    hertz_spring,
    resolved,
)
from harness.errors import RequestError
from harness.parameters.rules import Rules
from harness.parameters.scene import ZERO, ContactScene, Vector
from harness.solvers.pair.integration import integrate
from harness.theory import contact


def head_on(parameters: ContactSystem, speed: float) -> dict[str, float]:
    """Return what is known of an impact at a speed [m/s] without gravity."""
    if parameters.linear:
        return _linear(parameters, speed)
    if parameters.normal != "hertz" or parameters.clipped:
        return {}
    if parameters.damping == "none":
        return _hertz(parameters, speed)
    if parameters.dashpot.gives_restitution:
        assert parameters.restitution is not None
        return {"restitution": parameters.restitution}
    return {}


def rebound(parameters: ContactSystem, height: float, gravity: float) -> dict[str, float]:
    """Return what is known of a fall from a height [m] under gravity [m/s2] on a floor."""
    elastic = {"rebound_ratio": 1.0} if parameters.damping == "none" else {}
    if not parameters.linear or parameters.clipped:
        return elastic
    zeta, omega = oscillator(parameters)
    speed = math.sqrt(2.0 * gravity * height)
    speed_after = contact.rebound(omega, zeta, gravity, speed) if zeta < 1.0 else None
    if speed_after is None:
        return elastic
    ratio = speed_after.speed**2 / (2.0 * gravity * height)
    return {"rebound_ratio": ratio, "contact_time_s": speed_after.duration, **elastic}


def _hertz(parameters: ContactSystem, speed: float) -> dict[str, float]:
    impact = parameters.reduced_mass, hertz_spring(parameters), speed
    return {
        "restitution": 1.0,
        "contact_time_s": contact.contact_time(*impact),
        "largest_overlap_m": contact.largest_hertz_overlap(*impact),
        "largest_force_N": contact.largest_force(*impact),
    }


def _linear(parameters: ContactSystem, speed: float) -> dict[str, float]:
    zeta, omega = oscillator(parameters)
    if zeta >= 1.0:
        return {}
    overlap = speed / omega * contact.largest_overlap(zeta)
    if parameters.clipped:
        return {
            "restitution": contact.restitution_clipped(zeta),
            "largest_overlap_m": overlap,
        }
    return {
        "restitution": contact.restitution_unclipped(zeta),
        "contact_time_s": contact.duration_unclipped(zeta) / omega,
        "largest_overlap_m": overlap,
    }


def oscillator(parameters: ContactSystem) -> tuple[float, float]:
    """Return zeta = eta_n / (2 sqrt(k m*)) and omega = sqrt(k / m*) [1/s] of a linear contact."""
    k, m = parameters.normal_stiffness, parameters.reduced_mass
    assert k is not None
    omega = math.sqrt(k / m)
    if parameters.restitution is not None:
        return contact.damping_ratio(parameters.restitution), omega
    eta = dashpots(parameters, 0.0)  # constant, whatever the overlap
    return eta / 2.0 / math.sqrt(k * m), omega


IMPACT_SAMPLES = 100
"""Of a contact, about."""

STEPS_IN_PULL = 20
"""In the part 1/mu of a contact in which the dashpot's pull cuts back the tangential spring."""

AFTER = 1.1
"""Contact times that are simulated: a contact that a coarse step draws out must be over."""

FINER = 16
"""Times as many steps for a law that codes bring on behind the motion: by up to ten steps."""

PARTED = 50
"""Steps of a contact, all levels being multiples, that the time up to yield is
rounded to a part of: yield is noticed at the end of a step, at the same phase on every level."""


@lru_cache(maxsize=4096)  # job, samples and references of a run each ask for its scene
def impact(
    parameters: ContactSystem,
    velocity: Vector,
    omega: Vector = ZERO,
    other_omega: Vector = ZERO,
    *,
    finely: bool,
    gravity: Vector = ZERO,
) -> ContactScene:
    """Return the impact of the first sphere, which touches half a step after the start.

    The second is at rest, but that it may spin. ``finely``: sampled over the contact, else at its
    ends. Raise RequestError for a contact that does not end, and for steps that do not resolve the
    law.
    """
    n = parameters.steps_per_contact
    guess = _guess(parameters, velocity)
    first, *others = parameters.bodies(0.0, velocity, omega)
    touching = ContactScene(
        (first, *(replace(other, omega=other_omega) for other in others)),
        parameters.planes,
        parameters.law,
        step=guess,
        steps=1,
        gravity=gravity,
    )
    overlap = elastic_overlap(parameters, -velocity[2])
    _friction_resolved(parameters)
    # before anything is integrated with it: damping only draws the contact out
    resolved(parameters, replace(touching, step=0.25 * guess / n), overlap)
    early = _before(touching, 1e-3 * guess)
    n = steps_of(parameters)
    lasts = contact_time(early)
    step, count = lasts / n, float(n)
    if parameters.yield_stress is not None:
        until = yield_time(replace(early, step=lasts + 1e-3 * guess))
        step = _in_phase(step, until, n)
        count = lasts / step
    every = max(1, n // IMPACT_SAMPLES) if finely else 1
    steps = every * math.ceil(AFTER * count / every)
    scene = replace(touching, step=step, steps=steps, every=every if finely else steps)
    resolved(parameters, scene, overlap)
    return _before(scene, 0.5 * step)


def steps_of(parameters: ContactSystem) -> int:
    """Return the steps that a contact of an impact takes."""
    return parameters.steps_per_contact * (FINER if parameters.lags else 1)


def _in_phase(step: float, until: float, n: int) -> float:
    """Return a step [s] as long or shorter, of which there is a whole number ``until`` [s]."""
    parts = FINER * PARTED
    if math.isinf(until):
        return step
    return until * parts / (math.ceil(until * parts / (n * step)) * n)


def _before(scene: ContactScene, lead: float) -> ContactScene:
    """Return a scene a time [s] before, when its first body flew freely."""
    first, *others = scene.bodies
    v = [u - lead * g for u, g in zip(first.velocity, scene.gravity, strict=True)]
    x = [
        x - lead * u + 0.5 * lead * lead * g
        for x, u, g in zip(first.position, first.velocity, scene.gravity, strict=True)
    ]
    early = replace(first, position=(x[0], x[1], x[2]), velocity=(v[0], v[1], v[2]))
    return replace(scene, bodies=(early, *others))


def _friction_resolved(parameters: ContactSystem) -> None:
    """Raise RequestError for a friction whose limit passes zero unseen, as a dashpot pulls.

    The normal force is below 1/mu of its peak for a part 1/mu of the contact, in which whatever the
    tangential spring holds is cut back: of which a step must see something.
    """
    mu, most = parameters.friction or 0.0, parameters.steps_per_contact / STEPS_IN_PULL
    if mu > most and parameters.damping != "none" and not parameters.clipped:
        raise RequestError(
            f"friction = {mu!r}: must be at most {most:g} with steps_per_contact = "
            f"{parameters.steps_per_contact}: the force of the dashpot changes its sign in a step"
        )


def _guess(parameters: ContactSystem, velocity: Vector) -> float:
    """Return a time that is longer than the contact [s], without damping."""
    speed, m = -velocity[2], parameters.reduced_mass
    if parameters.normal_stiffness is not None:
        return 4.0 * math.pi * math.sqrt(m / parameters.normal_stiffness)
    return 12.0 * elastic_overlap(parameters, speed) / speed


def relative_velocity(motion: Motion) -> Array:
    """Return the velocity of the first sphere against what it meets [m/s], (M, 3)."""
    v = motion.velocity
    return v[:, 0] - v[:, 1] if v.shape[1] > 1 else v[:, 0]


def overlap_of(parameters: ContactSystem, motion: Motion) -> tuple[Array, Array]:
    """Return the overlap [m] and its rate [m/s], each (M,)."""
    x, v = motion.position, motion.velocity
    if parameters.partner == "wall":
        return parameters.radius - x[:, 0, 2], -v[:, 0, 2]
    apart, moving = x[:, 0] - x[:, 1], v[:, 0] - v[:, 1]
    distance = np.linalg.norm(apart, axis=1)
    rate = np.einsum("ij,ij->i", apart, moving) / distance
    return parameters.radius + parameters.second_radius - distance, -rate


LONGEST = 64
"""Guesses of a contact's duration that are tried: a strong dashpot draws it out."""


@lru_cache(maxsize=2048)
def yield_time(scene: ContactScene) -> float:
    """Return after which time of its first contact a sphere yields [s]; inf if it does not."""
    path = integrate(scene, Rules())
    begun = [event.time for event in path.of_kind("begins")]
    return next((event.time - begun[0] for event in path.of_kind("yields")), math.inf)


@lru_cache(maxsize=2048)
def contact_time(scene: ContactScene) -> float:
    """Return how long the first contact of a scene lasts [s]; its one step is a first guess.

    Raise RequestError for a contact that does not end.
    """
    longer = 1
    while longer <= LONGEST:
        path = integrate(replace(scene, step=scene.step * longer), Rules())
        lasted = path.contact_times()
        if lasted:
            return lasted[0]
        longer *= 4
    strong = ("damping_coefficient", "restitution", "surface_energy")
    values = [(name, getattr(scene.law, name)) for name in strong]
    named = ", ".join(f"{name} = {value!r}" for name, value in values if value is not None)
    raise RequestError(
        f"{named}: the contact does not end; less damping or attraction, or a faster impact, end it"
    )
