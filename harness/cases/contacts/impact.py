"""Impacts: the first sphere flies at its partner, touches it, and leaves."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from harness.cases.contacts.parameters import ContactSystem
from harness.model.base import ZERO, Vector
from harness.model.motion import Floats, Motion
from harness.model.scene import Scene
from harness.solvers.contact_time import before, contact_time, yield_time

SAMPLES = 100  # of a contact, about
DURATION = 1.1  # contact times simulated: a contact that a coarse step draws out must be over
FINER = 16  # times as many steps for a law whose state is brought on step by step
PARTS = 50  # steps of a contact, all levels being multiples, for the phase of the onset of yield
ROUND_OFF = 1e-9  # of the roots of a polynomial


@lru_cache(maxsize=4096)
def impact_scene(
    p: ContactSystem,
    velocity: Vector,
    spin: Vector = ZERO,
    other_spin: Vector = ZERO,
    *,
    sampled: bool,
    gravity: Vector = ZERO,
) -> Scene:
    """Return the impact of the first sphere, which touches half a step after the start.

    The second is at rest, but that it may spin. ``sampled`` over the contact, else at both ends.
    Raise RequestError for a contact that does not end, and for steps that are not stable.
    """
    n = p.steps_per_contact * (FINER if p.lags else 1)
    guess = 0.25 * p.elastic_overlap(-velocity[2]) / -velocity[2] / p.steps_per_contact
    touching = Scene(
        bodies=p.bodies(0.0, velocity, spin, other_spin),
        walls=p.walls,
        law=p.stated_law,
        gravity=gravity,
        step=1e-6 * guess,
        steps=1,
    )
    lasts = contact_time(touching)
    step = _step_in_phase(lasts / n, yield_time(touching), n)
    every = max(1, n // SAMPLES) if sampled else 1
    steps = every * math.ceil(DURATION * (float(n) if step == lasts / n else lasts / step) / every)
    scene = touching.replace(step=step, steps=steps, every=every if sampled else steps)
    return before(scene, 0.5 * step)


def _step_in_phase(step: float, until: float, n: int) -> float:
    """Return a step [s] as long or shorter, of which there is a whole number ``until`` [s].

    So yield, which is noticed at the end of a step, is so at one phase for all numbers of steps.
    """
    parts = FINER * PARTS
    if math.isinf(until):
        return step
    return until * parts / (math.ceil(until * parts / (n * step)) * n)


def relative_velocity(motion: Motion) -> Floats:
    """Return the velocity of the first sphere against its partner [m/s], (M, 3)."""
    v = motion.velocity
    return v[:, 0] - v[:, 1] if v.shape[1] > 1 else v[:, 0]


def overlap_and_rate(p: ContactSystem, motion: Motion) -> tuple[Floats, Floats]:
    """Return the overlap [m] and its rate [m/s], each (M,)."""
    x, v = motion.position, motion.velocity
    if p.partner == "wall":
        return p.radius - x[:, 0, 2], -v[:, 0, 2]
    separation = x[:, 0] - x[:, 1]
    distance = np.linalg.norm(separation, axis=1)
    rate = np.einsum("ij,ij->i", separation, relative_velocity(motion)) / distance
    return p.radius + p.second_radius - distance, -rate


def value_at_turn(time: Floats, value: Floats, rate: Floats) -> float:
    """Return a sampled value (M,) where its rate first crosses zero, NaN if it does not.

    Both cubic between the two samples about it, by Hermite's formula.
    """
    changes = np.flatnonzero(np.sign(rate[:-1]) * np.sign(rate[1:]) < 0.0)
    if not changes.size:
        return math.nan
    i = int(changes[0])
    h = float(time[i + 1] - time[i])
    slope = np.gradient(rate, time)
    inside = [
        root.real
        for root in np.roots(_cubic(rate[i : i + 2], h * slope[i : i + 2]))
        if abs(root.imag) < ROUND_OFF and -ROUND_OFF <= root.real <= 1.0 + ROUND_OFF
    ]
    if not inside:
        return math.nan
    return float(np.polyval(_cubic(value[i : i + 2], h * rate[i : i + 2]), inside[0]))


def _cubic(values: Floats, rates: Floats) -> Floats:
    """Return the coefficients, highest power first, of Hermite's cubic on 0 to 1."""
    (a, b), (u, v) = values, rates
    return np.array([2.0 * a - 2.0 * b + u + v, -3.0 * a + 3.0 * b - 2.0 * u - v, u, a])


def peak(value: Floats) -> float:
    """Return the largest of sampled values (M,), by the quartic through the five about it."""
    if np.isnan(value).any():
        return math.nan
    i = int(np.clip(np.argmax(value), 2, max(2, len(value) - 3)))
    near = value[i - 2 : i + 3]
    if len(near) < 5:
        return float(value.max())
    quartic = np.polyfit(np.arange(-2.0, 3.0), near, 4)
    roots = np.roots(np.polyder(quartic))
    places = [x.real for x in roots if abs(x.imag) < ROUND_OFF and abs(x.real) <= 2.0]
    return max([float(value.max()), *(float(np.polyval(quartic, x)) for x in places)])
